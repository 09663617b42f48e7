// Zones for tests.
import type { Point, Primitive, Zone } from '../live/contract';

const road = (label: string, points: Point[]): Primitive => ({ shape: 'polyline', layer: 'road', points, size_m: 0.18, label });

/** A zone of n × n short roads, spaced by 1 m. */
export function field(n: number): Zone {
  const primitives = Array.from({ length: n * n }, (_, i): Primitive => {
    const x = i % n;
    const y = Math.floor(i / n);
    return road(`w${i}`, [[x, y], [x + 0.5, y], [x + 0.5, y + 0.3]]);
  });
  return { name: 'field', bounds: [0, 0, n, n], vehicle: { length_m: 0.2, width_m: 0.12 }, primitives, sections: [], tags: [], beacons: null };
}
