import { describe, expect, it } from 'vitest';
import type { Primitive } from '../live/contract';
import { gathered, level_of, tolerance_of } from './zone_drawing';
import { field } from './zone_sample';

describe('the drawing of a large zone', () => {
  it('merges primitives of the same style, and loses none', () => {
    const zone = field(30);
    const groups = gathered(zone.primitives, zone.bounds);
    expect(groups.length).toBeLessThanOrEqual(144);
    expect(groups.flat().map((one) => one.label).sort()).toEqual(zone.primitives.map((one) => one.label).sort());
  });
  it('is unchanged for a small zone', () => {
    const zone = field(4);
    expect(gathered(zone.primitives, zone.bounds)).toEqual(zone.primitives.map((one) => [one]));
  });
  it('preserves the order of the layers', () => {
    const below = field(30).primitives;
    const above = below.map((one): Primitive => ({ ...one, layer: 'line' }));
    const layers = gathered([...below, ...above], [0, 0, 30, 30]).map((group) => group[0]!.layer);
    expect(layers.indexOf('line')).toBe(layers.lastIndexOf('road') + 1);
  });
});

describe('the level of detail of lines', () => {
  it('deviates by an eighth to a quarter of a pixel at any scale', () => {
    for (const scale of [0.03, 0.5, 1, 1.68, 2, 37, 512, 900]) {
      const deviation_px = tolerance_of(level_of(scale)) * scale;
      expect(deviation_px).toBeLessThanOrEqual(0.25);
      expect(deviation_px).toBeGreaterThan(0.125 - 1e-12);
    }
  });
});
