// The text that reports the outcome of a zone switch.
import type { ZoneState } from '../live/contract';
import * as format from '../live/format';
import { short } from '../live/rows';

/** "12 snapped, 1 parked: AIV7; the first moved after 431 ms" */
export function switched_text(switched: NonNullable<ZoneState['switched']>): string {
  const { snapped, parked, first_moving_ms } = switched;
  const named = parked.length === 0 ? 'nobody parked' : `${parked.length} parked: ${parked.map(short).join(', ')}`;
  return `${snapped} snapped, ${named}${first_moving_ms === null ? '' : `; the first moved after ${format.duration(first_moving_ms)}`}`;
}
