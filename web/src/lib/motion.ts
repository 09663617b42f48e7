// Where each AIV is drawn at a given instant. Snapshots come 20 times a second; the screen is painted 60 times. The
// picture is shown a little late (delay_ms), so that there is nearly always a snapshot on either side of the instant
// drawn, and motion is interpolated; when the next one is late, the last motion goes on for a moment, then stands.
import type { Pose, Snapshot } from './contract';

export const delay_ms = 80;
const extrapolate_ms_max = 150;
const samples_max = 8;
/** A twin that jumps further than this between two snapshots was placed anew: do not glide through walls. */
const jump_m = 0.5;
const trail_points_max = 90;

interface Track {
  times: number[];
  poses: Pose[];
  trail: Float64Array;
  trail_count: number;
}

export class Motion {
  private readonly tracks = new Map<string, Track>();
  /** server clock − page clock, the smallest transit seen lately [ms] */
  private offset: number | null = null;

  accept(snapshot: Snapshot, page_ms: number): void {
    const seen = snapshot.time_ms - page_ms;

    // The least delayed frame tells the offset best; it is forgotten slowly, as clocks drift and servers restart.
    if (this.offset === null || Math.abs(seen - this.offset) > 2_000) this.forget(seen);
    else this.offset = Math.max(seen, this.offset - 0.2);

    const present = new Set<string>();
    for (const aiv of snapshot.aivs) {
      present.add(aiv.id);
      let track = this.tracks.get(aiv.id);
      if (!track) {
        track = { times: [], poses: [], trail: new Float64Array(2 * trail_points_max), trail_count: 0 };
        this.tracks.set(aiv.id, track);
      }
      const last_ms = track.times.at(-1);
      const last = track.poses.at(-1);
      if (last_ms !== undefined && snapshot.time_ms <= last_ms) continue;
      if (last && Math.hypot(aiv.x - last.x, aiv.y - last.y) > jump_m) {
        track.times.length = track.poses.length = track.trail_count = 0;
      }
      track.times.push(snapshot.time_ms);
      track.poses.push({ x: aiv.x, y: aiv.y, heading: aiv.heading });
      if (track.times.length > samples_max) {
        track.times.shift();
        track.poses.shift();
      }
    }
    for (const id of this.tracks.keys()) if (!present.has(id)) this.tracks.delete(id);
  }

  /** The pose to draw now; nothing for an unknown vehicle. `out` is filled to spare an object per frame. */
  pose_at(id: string, page_ms: number, out: Pose): boolean {
    const track = this.tracks.get(id);
    const count = track?.times.length ?? 0;
    if (!track || count === 0 || this.offset === null) return false;
    const time = page_ms + this.offset - delay_ms;
    let right = count - 1;
    while (right > 0 && track.times[right - 1]! >= time) right--;
    const b = track.poses[right]!;
    const a = track.poses[right - 1];
    if (!a) {
      Object.assign(out, b);
      return true;
    }
    const from = track.times[right - 1]!;
    const to = track.times[right]!;
    const until = Math.min(time, to + extrapolate_ms_max);
    const share = (until - from) / (to - from);
    out.x = a.x + (b.x - a.x) * share;
    out.y = a.y + (b.y - a.y) * share;
    out.heading = a.heading + turn(a.heading, b.heading) * share;
    return true;
  }

  /** Adds where it is drawn now to its trail; points closer than 1 cm are not worth keeping. */
  leave_trail(id: string, pose: Pose): void {
    const track = this.tracks.get(id);
    if (!track) return;
    const { trail } = track;
    const n = track.trail_count;
    if (n > 0 && Math.hypot(pose.x - trail[2 * n - 2]!, pose.y - trail[2 * n - 1]!) < 0.01) return;
    if (n === trail_points_max) {
      trail.copyWithin(0, 2);
      track.trail_count--;
    }
    trail[2 * track.trail_count] = pose.x;
    trail[2 * track.trail_count + 1] = pose.y;
    track.trail_count++;
  }

  trail(id: string): Float64Array | null {
    const track = this.tracks.get(id);
    return track ? track.trail.subarray(0, 2 * track.trail_count) : null;
  }

  private forget(offset: number): void {
    this.offset = offset;
    this.tracks.clear();
  }
}

/** The short way round from one heading to another, in (−π, π]. */
export function turn(from: number, to: number): number {
  const full = 2 * Math.PI;
  const difference = (((to - from) % full) + full) % full;
  return difference > Math.PI ? difference - full : difference;
}
