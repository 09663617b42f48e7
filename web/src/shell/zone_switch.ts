// The text that reports the outcome of a zone switch.
import type { ZoneState } from '../live/contract';
import * as format from '../live/format';
import { short } from '../live/rows';

/** "12 snapped, 1 off-route: AIV7; the first moved after 431 ms" */
export function switched_text(switched: NonNullable<ZoneState['switched']>): string {
  const { snapped, offRoute, first_moving_ms } = switched;
  const named = offRoute.length === 0 ? 'no AIV off-route' : `${offRoute.length} off-route: ${offRoute.map(short).join(', ')}`;
  return `${snapped} snapped, ${named}${first_moving_ms === null ? '' : `; the first moved after ${format.duration(first_moving_ms)}`}`;
}
