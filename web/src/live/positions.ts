// Drawn positions at a given instant. Frames arrive 10 or 30 times a second and the screen is painted 60 times. Drawing
// therefore lags by one frame interval: it interpolates from the position drawn when the newest frame arrived to the position
// in that frame, so that no object jumps back. If the next frame is late, the motion is extrapolated briefly and then stops.
// Nothing is allocated per frame.
import { value_count, type PositionFrame } from './frames';

export const extrapolate_ms_max = 100;
/** An object further than this from its drawn position has been relocated and is not interpolated [m]. */
const leap_m = 0.5;
/** Frames further apart than this are not interpolated: a step of paused virtual time, or a suspended page. */
const interval_ms_max = 250;
const interval_ms_min = 5;
/** A frame that deviates more than this from its expected arrival restarts the pace estimate. */
const off_ms_max = 150;

export class Positions {
  count = 0;
  /** drawn positions; valid after `sample`. Slot i of all arrays belongs to one object while `revision` is unchanged */
  x = new Float32Array(0);
  y = new Float32Array(0);
  heading = new Float32Array(0);
  /** from the newest frame */
  speed = new Float32Array(0);
  /** offset from the twin to the last report [m] */
  reported_dx = new Float32Array(0);
  reported_dy = new Float32Array(0);
  handle = new Uint16Array(0);
  flags = new Uint16Array(0);
  /** incremented when slots are reassigned */
  revision = 0;
  /** incremented with each frame */
  frames = 0;

  private from_x = new Float32Array(0);
  private from_y = new Float32Array(0);
  private from_heading = new Float32Array(0);
  private to_x = new Float32Array(0);
  private to_y = new Float32Array(0);
  private to_heading = new Float32Array(0);
  private turn = new Float32Array(0);
  /** change per millisecond between the last two frames */
  private rate_x = new Float32Array(0);
  private rate_y = new Float32Array(0);
  private rate_heading = new Float32Array(0);
  private spare_x = new Float32Array(0);
  private spare_y = new Float32Array(0);
  private spare_heading = new Float32Array(0);
  private readonly slots = new Int32Array(65_536).fill(-1);
  private sequence = -1;
  private server_ms = 0;
  /** smoothed page time at which the newest frame was expected */
  private due_ms = 0;
  private came_ms = 0;
  private mean_gap_ms = 33;
  private mean_passed_ms = 33;
  private interval_ms = 33;
  private from_ms = 0;
  private to_ms = 1;
  private sampled_ms = 0;

  /** The slot of a handle, or −1. */
  slot(handle: number): number {
    return this.slots[handle] ?? -1;
  }

  /** Resets the sequence for a new connection. Drawn positions stay until the first new frame. */
  restart(): void {
    this.sequence = -1;
  }

  /** @param page_ms  performance.now() at the arrival of the frame */
  accept(frame: PositionFrame, page_ms: number): void {
    if (frame.sequence <= this.sequence) return;
    const passed_ms = frame.time_ms - this.server_ms;
    const first = this.sequence < 0;
    this.sequence = frame.sequence;
    this.server_ms = frame.time_ms;
    const moves = this.schedule(passed_ms, page_ms, first);
    const same = this.unchanged(frame);
    if (same) this.start_from_drawn();
    else this.take_slots(frame);
    this.aim(frame, same && moves);
    this.frames++;
  }

  /** Computes the drawn positions at this instant. */
  sample(page_ms: number): void {
    const { count, x, y, heading, to_x, to_y } = this;
    if (page_ms <= this.to_ms) {
      const { from_x, from_y, from_heading, turn } = this;
      const ratio = Math.max(0, (page_ms - this.from_ms) / (this.to_ms - this.from_ms));
      for (let i = 0; i < count; i++) {
        const fx = from_x[i]!;
        const fy = from_y[i]!;
        x[i] = fx + (to_x[i]! - fx) * ratio;
        y[i] = fy + (to_y[i]! - fy) * ratio;
        heading[i] = from_heading[i]! + turn[i]! * ratio;
      }
    } else {
      const { rate_x, rate_y, rate_heading, from_heading, turn } = this;
      const late_ms = Math.min(page_ms - this.to_ms, extrapolate_ms_max);
      for (let i = 0; i < count; i++) {
        x[i] = to_x[i]! + rate_x[i]! * late_ms;
        y[i] = to_y[i]! + rate_y[i]! * late_ms;
        heading[i] = from_heading[i]! + turn[i]! + rate_heading[i]! * late_ms;
      }
    }
    this.sampled_ms = page_ms;
  }

  /**
   * Estimates when the positions of this frame are due. Server time may run faster or slower than page time, and arrivals
   * jitter: the pace is estimated from both, and the due time is the paced time, corrected a little towards the arrival.
   * Returns whether the frame continues the motion of the previous one.
   */
  private schedule(passed_ms: number, page_ms: number, first: boolean): boolean {
    const gap_ms = Math.min(interval_ms_max, Math.max(1, page_ms - this.came_ms));
    this.came_ms = page_ms;
    const steady = !first && passed_ms > 0 && passed_ms < 100_000;
    if (steady) {
      this.mean_gap_ms += 0.1 * (gap_ms - this.mean_gap_ms);
      this.mean_passed_ms += 0.1 * (passed_ms - this.mean_passed_ms);
    }
    const paced_ms = steady ? (passed_ms * this.mean_gap_ms) / this.mean_passed_ms : gap_ms;
    this.interval_ms = Math.min(interval_ms_max, Math.max(interval_ms_min, paced_ms));
    const off_ms = page_ms - (this.due_ms + this.interval_ms);
    this.due_ms = Math.abs(off_ms) > off_ms_max ? page_ms : this.due_ms + this.interval_ms + 0.15 * off_ms;
    this.from_ms = Math.max(Math.min(this.sampled_ms, page_ms), page_ms - interval_ms_max);
    this.to_ms = Math.max(this.due_ms + this.interval_ms, this.from_ms + 0.5 * this.interval_ms);
    return steady && gap_ms < interval_ms_max;
  }

  private unchanged(frame: PositionFrame): boolean {
    if (frame.count !== this.count) return false;
    const { words } = frame;
    const { handle } = this;
    for (let i = 0; i < this.count; i++) if (words[2 * i] !== handle[i]) return false;
    return true;
  }

  private start_from_drawn(): void {
    this.from_x.set(this.x);
    this.from_y.set(this.y);
    this.from_heading.set(this.heading);
  }

  /** Reassigns the slots after objects appeared or disappeared; each remaining object keeps its drawn position. */
  private take_slots(frame: PositionFrame): void {
    const { count, words } = frame;
    if (count > this.x.length) this.grow(Math.ceil(count * 1.25) + 8);
    this.spare_x.set(this.x);
    this.spare_y.set(this.y);
    this.spare_heading.set(this.heading);
    for (let i = 0; i < count; i++) {
      const old = this.slots[words[2 * i]!]!;
      const known = old >= 0;
      this.from_x[i] = known ? this.spare_x[old]! : NaN;
      this.from_y[i] = known ? this.spare_y[old]! : NaN;
      this.from_heading[i] = known ? this.spare_heading[old]! : 0;
    }
    for (let i = 0; i < this.count; i++) this.slots[this.handle[i]!] = -1;
    for (let i = 0; i < count; i++) {
      this.handle[i] = words[2 * i]!;
      this.slots[words[2 * i]!] = i;
    }
    this.count = count;
    this.revision++;
  }

  private aim(frame: PositionFrame, moves: boolean): void {
    const { values, words } = frame;
    const per_ms = moves ? 1 / this.interval_ms : 0;
    for (let i = 0; i < frame.count; i++) {
      const at = i * value_count;
      const x = values[at]!;
      const y = values[at + 1]!;
      const heading = values[at + 2]!;
      const dx = x - this.from_x[i]!;
      const dy = y - this.from_y[i]!;
      // NaN denotes a new object, which starts at its reported position.
      const leaps = !(dx * dx + dy * dy <= leap_m * leap_m);
      const rate = leaps ? 0 : per_ms;
      this.rate_x[i] = rate === 0 ? 0 : (x - this.to_x[i]!) * rate;
      this.rate_y[i] = rate === 0 ? 0 : (y - this.to_y[i]!) * rate;
      this.rate_heading[i] = rate === 0 ? 0 : short_turn(this.to_heading[i]!, heading) * rate;
      if (leaps) {
        this.x[i] = this.from_x[i] = x;
        this.y[i] = this.from_y[i] = y;
        this.heading[i] = this.from_heading[i] = heading;
      }
      this.to_x[i] = x;
      this.to_y[i] = y;
      this.to_heading[i] = heading;
      this.turn[i] = short_turn(this.from_heading[i]!, heading);
      this.speed[i] = values[at + 3]!;
      this.reported_dx[i] = values[at + 4]!;
      this.reported_dy[i] = values[at + 5]!;
      this.flags[i] = words[2 * i + 1]!;
    }
  }

  private grow(size: number): void {
    const grown = (old: Float32Array) => {
      const next = new Float32Array(size);
      next.set(old);
      return next;
    };
    const columns = [
      'x', 'y', 'heading', 'speed', 'reported_dx', 'reported_dy', 'from_x', 'from_y', 'from_heading', 'to_x', 'to_y', 'to_heading', 'turn', 'rate_x', 'rate_y', 'rate_heading',
    ] as const;
    for (const name of columns) this[name] = grown(this[name]);
    for (const name of ['spare_x', 'spare_y', 'spare_heading'] as const) this[name] = new Float32Array(size);
    for (const name of ['handle', 'flags'] as const) {
      const next = new Uint16Array(size);
      next.set(this[name]);
      this[name] = next;
    }
  }
}

/** The signed difference between two headings, in (−π, π]. */
export function short_turn(from: number, to: number): number {
  const full = 2 * Math.PI;
  let turn = to - from;
  // Headings may have accumulated several turns; a few subtractions suffice, and usually none is needed.
  if (turn > Math.PI || turn <= -Math.PI) {
    turn -= full * Math.floor(turn / full);
    if (turn > Math.PI) turn -= full;
  }
  return turn;
}
