// The last minute of each AIV and the last ten minutes of the fleet, in typed arrays of fixed size, so that a page open for
// a day needs no more memory than one open for ten minutes.
import type { Snapshot } from './contract';

export type Series = 'speed' | 'divergence' | 'age';
const series: readonly Series[] = ['speed', 'divergence', 'age'];
export const history_slots = 60;
const every_ms = 1_000;

class RingBuffer {
  readonly values: Readonly<Record<Series, Float32Array>> = {
    speed: new Float32Array(history_slots), divergence: new Float32Array(history_slots), age: new Float32Array(history_slots),
  };
  next = 0;
  count = 0;

  put(speed: number, divergence: number, age: number): void {
    this.values.speed[this.next] = speed;
    this.values.divergence[this.next] = divergence;
    this.values.age[this.next] = age;
    this.next = (this.next + 1) % history_slots;
    this.count = Math.min(this.count + 1, history_slots);
  }
}

export class History {
  private readonly buffers = new Map<string, RingBuffer>();
  private last_ms = -Infinity;

  accept(snapshot: Snapshot): void {
    if (snapshot.time_ms < this.last_ms) this.last_ms = -Infinity;
    if (snapshot.time_ms - this.last_ms < every_ms) return;
    this.last_ms = snapshot.time_ms;
    for (const aiv of snapshot.aivs) {
      let buffer = this.buffers.get(aiv.id);
      if (!buffer) this.buffers.set(aiv.id, (buffer = new RingBuffer()));
      buffer.put(aiv.speed, aiv.divergence_m, aiv.age_ms);
    }
    if (this.buffers.size > snapshot.aivs.length) {
      const present = new Set(snapshot.aivs.map((aiv) => aiv.id));
      for (const id of this.buffers.keys()) if (!present.has(id)) this.buffers.delete(id);
    }
  }

  /** Oldest first, at most history_slots values, one a second. */
  read(id: string, which: Series): number[] {
    const buffer = this.buffers.get(id);
    if (!buffer) return [];
    const values = buffer.values[which];
    return Array.from({ length: buffer.count }, (_, i) => values[(buffer.next - buffer.count + i + history_slots) % history_slots]!);
  }
}

export { series };

export const fleet_slots = 600;

/** One value per second over the fleet, for the charts of the bijection panel. */
export class FleetHistory {
  readonly time_s = new Float64Array(fleet_slots);
  readonly divergence_m = new Float64Array(fleet_slots);
  readonly age_ms = new Float64Array(fleet_slots);
  readonly matched = new Float64Array(fleet_slots);
  count = 0;
  private last_ms = -Infinity;
  private worst_divergence = 0;
  private worst_age = 0;

  accept(snapshot: Snapshot): void {
    if (snapshot.time_ms < this.last_ms) this.clear();
    // The worst value of each second, not that of the last snapshot in it.
    for (const aiv of snapshot.aivs) {
      if (aiv.augmented) continue;
      if (!aiv.lost) this.worst_divergence = Math.max(this.worst_divergence, aiv.divergence_m);
      if (aiv.connection !== 'OFFLINE') this.worst_age = Math.max(this.worst_age, aiv.age_ms);
    }
    if (snapshot.time_ms - this.last_ms < 1_000) return;
    this.last_ms = snapshot.time_ms;
    if (this.count === fleet_slots) {
      for (const values of [this.time_s, this.divergence_m, this.age_ms, this.matched]) values.copyWithin(0, 1);
      this.count--;
    }
    this.time_s[this.count] = snapshot.time_ms / 1000;
    this.divergence_m[this.count] = this.worst_divergence;
    this.age_ms[this.count] = this.worst_age;
    this.matched[this.count] = snapshot.bijection.matched;
    this.count++;
    this.worst_divergence = this.worst_age = 0;
  }

  private clear(): void {
    this.count = 0;
    this.last_ms = -Infinity;
  }
}
