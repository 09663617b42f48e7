import { describe, expect, it } from 'vitest';
import { switched_text } from './zone_switch';

describe('a switch to another zone', () => {
  it('is reported with the off-route vehicles', () => {
    expect(switched_text({ at: 1, from: 'a', first_moving_ms: 431, snapped: 12, offRoute: ['CoSiVA/AIV7'] })).toBe('12 snapped, 1 off-route: AIV7; the first moved after 431\u202fms');
    expect(switched_text({ at: 1, from: 'a', first_moving_ms: null, snapped: 3, offRoute: [] })).toBe('3 snapped, no AIV off-route');
  });
});
