// The recent drawn positions of a limited number of vehicles.
import { kind_aiv, flags_kind_mask } from '../live/frames';
import type { Positions } from '../live/positions';

const points_max = 90;
/** closer points are not stored [m] */
const apart_m = 0.01;
const leap_m = 0.5;
/** larger fleets have a trail for the selected vehicle only */
export const trails_max = 60;

export interface Trail {
  points: Float32Array;
  count: number;
}

export class Trails {
  private readonly trails = new Map<number, Trail>();
  private revision = -1;

  /** Adds the drawn positions; in large fleets only that of the vehicle with handle `only`. */
  leave(positions: Positions, only: number): void {
    if (positions.revision !== this.revision) {
      this.revision = positions.revision;
      for (const handle of this.trails.keys()) if (positions.slot(handle) < 0) this.trails.delete(handle);
    }
    const few = positions.count <= trails_max;
    if (!few) for (const handle of this.trails.keys()) if (handle !== only) this.trails.delete(handle);
    for (let i = 0; i < positions.count; i++) {
      if ((few || positions.handle[i] === only) && (positions.flags[i]! & flags_kind_mask) === kind_aiv) this.add(positions.handle[i]!, positions.x[i]!, positions.y[i]!);
    }
  }

  get(handle: number): Trail | undefined {
    return this.trails.get(handle);
  }
  entries(): IterableIterator<[number, Trail]> {
    return this.trails.entries();
  }

  private add(handle: number, x: number, y: number): void {
    let trail = this.trails.get(handle);
    if (!trail) this.trails.set(handle, (trail = { points: new Float32Array(2 * points_max), count: 0 }));
    const { points } = trail;
    const n = trail.count;
    if (n > 0) {
      const away = Math.hypot(x - points[2 * n - 2]!, y - points[2 * n - 1]!);
      if (away < apart_m) return;
      if (away > leap_m) trail.count = 0;
    }
    if (trail.count === points_max) {
      points.copyWithin(0, 2);
      trail.count--;
    }
    points[2 * trail.count] = x;
    points[2 * trail.count + 1] = y;
    trail.count++;
  }
}
