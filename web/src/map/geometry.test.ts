import { describe, expect, it } from 'vitest';
import type { Point, Zone } from '../live/contract';
import { inside, nearest_on_line, nearest_on_tracks, path_length, section_at, simplified, spread_out } from './geometry';
import { field } from './zone_sample';

const corner: Point[] = [[0, 0], [3, 0], [3, 4]];

describe('a polyline', () => {
  it('has the length of its pieces', () => {
    expect(path_length(corner)).toBe(7);
    expect(path_length([[1, 1]])).toBe(0);
    expect(path_length([])).toBe(0);
  });

  it('has a nearest point within a piece, at a corner and before its start', () => {
    expect(nearest_on_line(corner, 1, 1)).toEqual({ x: 1, y: 0, distance: 1, along: 1 });
    expect(nearest_on_line(corner, 4, -1)).toMatchObject({ x: 3, y: 0, along: 3 });
    expect(nearest_on_line(corner, -3, 4)).toMatchObject({ x: 0, y: 0, distance: 5, along: 0 });
    expect(nearest_on_line(corner, 2, 3)).toEqual({ x: 3, y: 3, distance: 1, along: 6 });
  });

  it('may be a single point, contain a point twice, or be empty', () => {
    expect(nearest_on_line([[1, 1]], 1, 3)).toEqual({ x: 1, y: 1, distance: 2, along: 0 });
    expect(nearest_on_line([[1, 1], [1, 1], [2, 1]], 2, 1)).toMatchObject({ distance: 0, along: 1 });
    expect(nearest_on_line([], 0, 0)).toBeNull();
  });
});

describe('a simplified polyline', () => {
  const arc = (steps: number): Point[] => Array.from({ length: steps + 1 }, (_, i) => [Math.cos((i * Math.PI) / 2 / steps), Math.sin((i * Math.PI) / 2 / steps)]);

  it('has the ends alone of a straight line', () => {
    expect(simplified([[0, 0], [1, 0.0004], [2, 0], [3, 0]], 0.001)).toEqual([[0, 0], [3, 0]]);
    expect(simplified(corner, 0.001)).toEqual(corner);
  });

  it('omits no point further away than the tolerance', () => {
    // A chord over the angle a of a unit circle is 1 - cos(a/2) from the arc: for 0.01, pieces of at most 16 degrees.
    const few = simplified(arc(90), 0.01);
    expect(few.length).toBeLessThanOrEqual(9);
    expect(few.length).toBeGreaterThanOrEqual(7);
    for (const [x, y] of arc(90)) expect(nearest_on_line(few, x, y)!.distance).toBeLessThanOrEqual(0.01 + 1e-12);
  });

  it('keeps a closed line open to the furthest point, and lines of two points as they are', () => {
    expect(simplified([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]], 0.1)).toEqual([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]);
    expect(simplified([[1, 1], [1, 1]], 0.1)).toEqual([[1, 1], [1, 1]]);
    expect(simplified([], 0.1)).toEqual([]);
  });

  it('follows a spike that returns to the chord', () => {
    expect(simplified([[0, 0], [5, 0], [1, 0]], 0.1)).toEqual([[0, 0], [5, 0], [1, 0]]);
  });
});

describe('the paths of a zone', () => {
  const zone = {
    primitives: [
      { shape: 'polyline', layer: 'road', points: [[0, 0], [10, 0]], size_m: 0.2, label: 'east' },
      { shape: 'polyline', layer: 'road', points: [[0, 2], [10, 2]], size_m: 0.2, label: 'west' },
      { shape: 'polyline', layer: 'wall', points: [[0, 0.9], [10, 0.9]], size_m: 0.2 },
    ],
  } as unknown as Zone;

  it('are the roads only', () => {
    expect(nearest_on_tracks(zone, 4, 0.9)).toMatchObject({ section: 'east', along: 4 });
    expect(nearest_on_tracks(zone, 4, 1.2)?.section).toBe('west');
    expect(nearest_on_tracks({ ...zone, primitives: [] }, 0, 0)).toBeNull();
  });
});

describe('a polygon', () => {
  it('contains its interior, also with a concave corner', () => {
    const dented: Point[] = [[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]];
    expect(inside(dented, 1, 1)).toBe(true);
    expect(inside(dented, 2, 2)).toBe(false);
    expect(inside(dented, 5, 1)).toBe(false);
  });
});

describe('hand-drawn points', () => {
  it('are merged if they are too close', () => {
    expect(spread_out([[0, 0], [0.001, 0], [1, 0], [1, 0]], 0.01)).toEqual([[0, 0], [1, 0]]);
    expect(spread_out([], 1)).toEqual([]);
  });
});

describe('the path under a point', () => {
  const zone = field(20);
  it('equals the result of a search over all paths', () => {
    for (let i = 0; i < 300; i++) {
      const x = ((i * 37) % 211) / 10;
      const y = ((i * 53) % 223) / 10;
      const all = zone.primitives.map((one) => nearest_on_line(one.points, x, y)!.distance);
      expect(nearest_on_tracks(zone, x, y)!.distance).toBeCloseTo(Math.min(...all), 12);
    }
  });
  it('is null away from all roads', () => {
    expect(section_at(zone, 3.2, 4.05, 0)).toBe('w83');
    expect(section_at(zone, 3.2, 4.5, 0)).toBe(null);
  });
});
