// Plane geometry of the map: metres, y up, radians counter-clockwise.
import type { Point, Zone } from './contract';

export interface OnLine {
  x: number;
  y: number;
  /** from the point asked for [m] */
  distance: number;
  /** along the line from its start [m] */
  along: number;
}

export function distance(a: Point, b: Point): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

export function path_length(points: readonly Point[]): number {
  let sum = 0;
  for (let i = 1; i < points.length; i++) sum += distance(points[i - 1]!, points[i]!);
  return sum;
}

/** The place on an open line of straight pieces that is nearest to a point; null for no points. */
export function nearest_on_line(points: readonly Point[], x: number, y: number): OnLine | null {
  const first = points[0];
  if (!first) return null;
  let best: OnLine = { x: first[0], y: first[1], distance: Math.hypot(first[0] - x, first[1] - y), along: 0 };
  let before = 0;
  for (let i = 1; i < points.length; i++) {
    const [ax, ay] = points[i - 1]!;
    const [bx, by] = points[i]!;
    const length = Math.hypot(bx - ax, by - ay);
    if (length > 0) {
      const share = Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / (length * length)));
      const px = ax + (bx - ax) * share;
      const py = ay + (by - ay) * share;
      const off = Math.hypot(px - x, py - y);
      if (off < best.distance) best = { x: px, y: py, distance: off, along: before + share * length };
    }
    before += length;
  }
  return best;
}

export interface OnWay extends OnLine {
  section: string;
}

/** The nearest place on any way of the zone, as far as its drawing tells: roads are drawn along their middles. */
export function nearest_on_ways(zone: Zone, x: number, y: number): OnWay | null {
  let best: OnWay | null = null;
  for (const primitive of zone.primitives) {
    if (primitive.layer !== 'road' || primitive.shape !== 'polyline') continue;
    const place = nearest_on_line(primitive.points, x, y);
    if (place && (best === null || place.distance < best.distance)) best = { ...place, section: primitive.label ?? '' };
  }
  return best;
}

/** Whether a point lies in a closed polygon (even-odd rule). */
export function inside(points: readonly Point[], x: number, y: number): boolean {
  let within = false;
  for (let i = 0, j = points.length - 1; i < points.length; j = i++) {
    const [ax, ay] = points[i]!;
    const [bx, by] = points[j]!;
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) within = !within;
  }
  return within;
}

/** Points of a line that are no nearer than `apart` to the one before: what a hand drew twice is one point. */
export function spread_out(points: readonly Point[], apart: number): Point[] {
  const kept: Point[] = [];
  for (const point of points) {
    const last = kept.at(-1);
    if (!last || distance(last, point) >= apart) kept.push(point);
  }
  return kept;
}
