// Plane geometry of the map: metres, y up, radians counter-clockwise.
import type { Point, Zone } from '../live/contract';

export interface OnLine {
  x: number;
  y: number;
  /** distance from the given point [m] */
  distance: number;
  /** arc length from the start of the line [m] */
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

/**
 * The polyline without the points that it would not miss: no omitted point is further than `tolerance` from the result
 * [m]. The first and the last point stay. (Ramer 1972, Douglas and Peucker 1973)
 */
export function simplified(points: readonly Point[], tolerance: number): Point[] {
  if (points.length < 3) return [...points];
  const vertex = new Uint8Array(points.length);
  vertex[0] = vertex[points.length - 1] = 1;
  const open: [number, number][] = [[0, points.length - 1]];
  for (let range = open.pop(); range; range = open.pop()) {
    const [from, to] = range;
    let furthest = -1;
    let most = tolerance;
    for (let i = from + 1; i < to; i++) {
      const off = off_chord(points[i]!, points[from]!, points[to]!);
      if (off > most) [most, furthest] = [off, i];
    }
    if (furthest < 0) continue;
    vertex[furthest] = 1;
    open.push([from, furthest], [furthest, to]);
  }
  return points.filter((_, i) => vertex[i]);
}

/** The distance from a point to the piece from `a` to `b`, which may be a single point [m]. */
function off_chord([x, y]: Point, [ax, ay]: Point, [bx, by]: Point): number {
  const square = (bx - ax) ** 2 + (by - ay) ** 2;
  const ratio = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / square)) : 0;
  return Math.hypot(ax + (bx - ax) * ratio - x, ay + (by - ay) * ratio - y);
}

/** The nearest point on an open polyline; null for a polyline without points. */
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
      const ratio = Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / (length * length)));
      const px = ax + (bx - ax) * ratio;
      const py = ay + (by - ay) * ratio;
      const off = Math.hypot(px - x, py - y);
      if (off < best.distance) best = { x: px, y: py, distance: off, along: before + ratio * length };
    }
    before += length;
  }
  return best;
}

export interface OnTrack extends OnLine {
  section: string;
}

/** A road with its bounding box, so that distant roads are skipped quickly. */
interface Track {
  points: readonly Point[];
  section: string;
  low_x: number;
  low_y: number;
  high_x: number;
  high_y: number;
}
const tracks = new WeakMap<Zone, readonly Track[]>();

function tracks_of(zone: Zone): readonly Track[] {
  let known = tracks.get(zone);
  if (!known) {
    known = zone.primitives.filter((one) => one.layer === 'road' && one.shape === 'polyline').map(({ points, label }) => ({ points, section: label ?? '', ...box_of(points) }));
    tracks.set(zone, known);
  }
  return known;
}

export function box_of(points: readonly Point[]): { low_x: number; low_y: number; high_x: number; high_y: number } {
  const box = { low_x: Infinity, low_y: Infinity, high_x: -Infinity, high_y: -Infinity };
  for (const [x, y] of points) {
    box.low_x = Math.min(box.low_x, x);
    box.low_y = Math.min(box.low_y, y);
    box.high_x = Math.max(box.high_x, x);
    box.high_y = Math.max(box.high_y, y);
  }
  return box;
}

/** The nearest point on any road of the zone. Roads are drawn along their centre lines. */
export function nearest_on_tracks(zone: Zone, x: number, y: number): OnTrack | null {
  let best: OnTrack | null = null;
  for (const track of tracks_of(zone)) {
    if (best !== null) {
      const off_x = Math.max(track.low_x - x, x - track.high_x, 0);
      const off_y = Math.max(track.low_y - y, y - track.high_y, 0);
      if (off_x * off_x + off_y * off_y >= best.distance * best.distance) continue;
    }
    const nearest = nearest_on_line(track.points, x, y);
    if (nearest && (best === null || nearest.distance < best.distance)) best = { ...nearest, section: track.section };
  }
  return best;
}

/** The section whose road contains a point; null outside all roads. */
export function section_at(zone: Zone, x: number, y: number, slack: number): string | null {
  const track = nearest_on_tracks(zone, x, y);
  return track && track.section !== '' && track.distance <= 0.75 * zone.vehicle.width_m + slack ? track.section : null;
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

/** Removes points closer than `apart` to their predecessor, such as repeated points of a hand-drawn line. */
export function spread_out(points: readonly Point[], apart: number): Point[] {
  const spread: Point[] = [];
  for (const point of points) {
    const last = spread.at(-1);
    if (!last || distance(last, point) >= apart) spread.push(point);
  }
  return spread;
}
