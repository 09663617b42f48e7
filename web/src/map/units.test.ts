import { describe, expect, it } from 'vitest';
import type { CrossingUnit } from '../live/contract';
import { unit_direction, unit_state, unit_words } from './units';

const unit = (change: Partial<CrossingUnit> = {}): CrossingUnit => ({ crossing: 'X1', x: 0.15, y: -0.15, state: 'online', age_ms: 90, holders: [], waiting: [], trouble: null, ...change });
const vehicle = (number: number, age_ms = 100) => ({ id: `CoSiVA/AIV${number}`, age_ms });

describe('a crossing unit', () => {
  it('is described by who is in its crossing and who waits', () => {
    expect(unit_words(unit())).toBe('Unit: free');
    const occupied = unit({ holders: [vehicle(1)], waiting: [vehicle(2), vehicle(3)] });
    expect(unit_words(occupied)).toBe('Unit: held by AIV1; waiting: AIV2, AIV3');
    expect([unit_state(unit()), unit_state(occupied)]).toEqual(['free', 'occupied']);
  });

  it('names the age of what it knows when that is old', () => {
    expect(unit_words(unit({ holders: [vehicle(1, 12_000)] }))).toMatch(/^Unit: held by AIV1, last message 12[\d.]*\Ds ago$/);
  });

  it('is unresponsive, whatever it reported last', () => {
    const dead = unit({ state: 'unresponsive', age_ms: 3_000, holders: [vehicle(1)] });
    expect(unit_state(dead)).toBe('unresponsive');
    expect(unit_words(dead)).toMatch(/^Unit unresponsive for 3[\d.]*\Ds$/);
  });

  it('is drawn away from the others', () => {
    const all = [unit(), unit({ x: -0.15 }), unit({ y: 0.15 }), unit({ x: -0.15, y: 0.15 })];
    const [x, y] = unit_direction(all[0]!, all);
    expect(x).toBeCloseTo(Math.SQRT1_2);
    expect(y).toBeCloseTo(-Math.SQRT1_2);
    expect(unit_direction(all[0]!, [all[0]!])).toEqual([Math.SQRT1_2, Math.SQRT1_2]);
  });
});
