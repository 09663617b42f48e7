// The words and the positions of the crossing units on the map.
import type { CrossingUnit } from '../live/contract';
import * as format from '../live/format';
import { short } from '../live/rows';

const names = (vehicles: readonly { id: string }[]) => vehicles.map(({ id }) => short(id)).join(', ');

export type UnitState = 'unresponsive' | 'occupied' | 'free';

export function unit_state(unit: CrossingUnit): UnitState {
  if (unit.state === 'unresponsive') return 'unresponsive';
  return unit.holders.length > 0 ? 'occupied' : 'free';
}

/** What the unit reports, in a line. */
export function unit_words(unit: CrossingUnit): string {
  if (unit.state === 'unresponsive') return `Unit unresponsive for ${format.duration(unit.age_ms)}`;
  const oldest = Math.max(0, ...unit.holders.map(({ age_ms }) => age_ms));
  const holders = unit.holders.length > 0 ? `held by ${names(unit.holders)}${oldest > 1_000 ? `, last message ${format.duration(oldest)} ago` : ''}` : 'free';
  return `Unit: ${holders}${unit.waiting.length > 0 ? `; waiting: ${names(unit.waiting)}` : ''}`;
}

/** The direction in which the unit is drawn from its crossing: away from the others, so that crossings side by side stay visible. */
export function unit_direction(unit: CrossingUnit, all: readonly CrossingUnit[]): readonly [number, number] {
  const x = unit.x - all.reduce((sum, one) => sum + one.x, 0) / all.length;
  const y = unit.y - all.reduce((sum, one) => sum + one.y, 0) / all.length;
  const away = Math.hypot(x, y);
  return away < 1e-6 ? [Math.SQRT1_2, Math.SQRT1_2] : [x / away, y / away];
}
