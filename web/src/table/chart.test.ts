import { describe, expect, it } from 'vitest';
import { path_of, step_of, ticks_of, time_step_of } from './chart';

describe('the scales of a chart', () => {
  it('have round steps of values, few enough to be read', () => {
    expect(step_of(0.036, 4)).toBeCloseTo(0.01, 12);
    expect(step_of(180, 4)).toBe(50);
    expect(step_of(2400, 4)).toBe(1000);
    for (const span of [1e-6, 0.0299, 0.03, 7, 99, 1e9]) expect(span / step_of(span, 4)).toBeLessThanOrEqual(4);
  });
  it('have steps of whole seconds or minutes', () => {
    expect(time_step_of(600, 4)).toBe(300);
    expect(time_step_of(7, 4)).toBe(2);
    expect(time_step_of(86_400, 4)).toBe(86_400);
  });
  it('begin and end within the scale, its ends included', () => {
    expect(ticks_of(0, 150, 50)).toEqual([0, 50, 100, 150]);
    expect(ticks_of(101, 149, 50)).toEqual([]);
    expect(ticks_of(0, 0.03, 0.01).map((tick) => tick.toFixed(2))).toEqual(['0.00', '0.01', '0.02', '0.03']);
  });
});

describe('the path of a chart', () => {
  it('is one line through all points', () => expect(path_of([[0, 1], [2, 3.25]], false)).toBe('M0.0 1.0L2.0 3.3'));
  it('is a dot at each event', () => expect(path_of([[0, 1], [2, 3]], true)).toBe('M0.0 1.0h0M2.0 3.0h0'));
  it('is empty without points', () => expect(path_of([], false)).toBe(''));
});
