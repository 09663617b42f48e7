import { describe, expect, it } from 'vitest';
import { body_size } from './scene';
import { packed } from './renderer';

describe('a colour of the style sheet', () => {
  it('is packed red first, in either notation', () => {
    expect(packed('#123456')).toBe(0x563412);
    expect(packed(' #fa0 ')).toBe(0x00aaff);
  });
  it('is grey if it cannot be read', () => {
    expect(packed('rebeccapurple')).toBe(0x888888);
  });
});

describe('a vehicle on the map', () => {
  const vehicle = { length_m: 0.2, width_m: 0.12 };
  it('is drawn to scale', () => {
    expect(body_size(vehicle, { x: 0, y: 0, scale: 500 }, 4)).toMatchObject({ half_length: 50, half_width: 30 });
  });
  it('is never too small to be visible, and keeps its proportions', () => {
    const small = body_size(vehicle, { x: 0, y: 0, scale: 2 }, 4);
    expect(small.half_width).toBeCloseTo(3.5);
    expect(small.half_length / small.half_width).toBeCloseTo(0.2 / 0.12);
    expect(body_size(vehicle, { x: 0, y: 0, scale: 2 }, 10_000).half_width).toBeLessThan(small.half_width);
  });
  it('shows the shape of its state as long as it is readable', () => {
    expect(body_size(vehicle, { x: 0, y: 0, scale: 100 }, 4).shape_radius).toBeGreaterThan(3);
    expect(body_size(vehicle, { x: 0, y: 0, scale: 2 }, 10_000).shape_radius).toBe(0);
  });
});
