// Pure functions of the battery panel: curves reduced to the points that a plot has room for, and texts.
import type { BatteryPoint, BatterySlot, BatteryTest, Snapshot } from '../live/contract';
import * as format from '../live/format';

export const points_max = 240;

/** A curve of at most points_max points, at least `every_ms` apart. A full curve drops every other point, as on the server. */
export class Curve {
  points: BatteryPoint[] = [];
  private every_ms = 1_000;

  /** Starts the curve with the points that the server has stored. */
  begin(points: readonly BatteryPoint[]): void {
    this.points = [];
    this.every_ms = 1_000;
    for (const point of points) this.add(point);
  }

  /** Appends a point; false if it is too close to the last one. */
  add(point: BatteryPoint): boolean {
    const last = this.points.at(-1);
    if (last && point[0] < last[0]) this.points = [];
    else if (last && point[0] - last[0] < this.every_ms) return false;
    if (this.points.length >= points_max) {
      this.points = this.points.filter((_, i) => i % 2 === 0);
      this.every_ms *= 2;
    }
    this.points = [...this.points, point];
    return true;
  }
}

/** One point per vehicle of a snapshot; vehicles that report no battery have none. */
export function points_of(snapshot: Snapshot): Map<string, BatteryPoint> {
  const finer = new Map((snapshot.battery?.test?.vehicles ?? []).map((slot) => [slot.id, slot]));
  const points = new Map<string, BatteryPoint>();
  for (const aiv of snapshot.aivs) {
    if (!aiv.power || aiv.augmented || aiv.lost) continue;
    const slot = finer.get(aiv.id);
    const charge = (slot?.phase === 'running' || slot?.phase === 'paused' ? slot.charge : null) ?? aiv.battery;
    if (charge !== null) points.set(aiv.id, [snapshot.time_ms, charge, aiv.power.voltage_v, aiv.power.temperature_c]);
  }
  return points;
}

export type Quantity = 'charge' | 'voltage' | 'temperature';
const column = { charge: 1, voltage: 2, temperature: 3 } as const;
/** The least span of a plot; a smaller one would exaggerate the steps of the gauge. */
const span_min = { charge: 2, voltage: 0.2, temperature: 2 } as const;

export interface Plot {
  /** an SVG path; empty for fewer than two points */
  path: string;
  low: number;
  high: number;
  last: number | null;
  /** vertical position of a value, from the top; null outside the plot */
  y(value: number): number | null;
}

/** Plots a curve in a box of `width` by `height`; the scale includes the value `also`. */
export function plot_of(points: readonly BatteryPoint[], quantity: Quantity, width: number, height: number, also: number | null = null): Plot {
  const at = column[quantity];
  const values = points.map((point) => point[at]);
  let low = Math.min(...values, also ?? Infinity);
  let high = Math.max(...values, also ?? -Infinity);
  if (values.length === 0) [low, high] = [0, 1];
  const lacking = span_min[quantity] - (high - low);
  if (lacking > 0) [low, high] = quantity === 'charge' && high + lacking / 2 > 100 ? [100 - span_min.charge, 100] : [low - lacking / 2, high + lacking / 2];
  const begin = points[0]?.[0] ?? 0;
  const span = Math.max(1, (points.at(-1)?.[0] ?? 0) - begin);
  const down = (value: number) => 2 + ((height - 4) * (high - value)) / (high - low);
  const coordinates = (point: BatteryPoint) => `${(((point[0] - begin) / span) * width).toFixed(1)} ${down(point[at]).toFixed(1)}`;
  return {
    path: points.length < 2 ? '' : `M${points.map(coordinates).join('L')}`,
    low, high,
    last: values.at(-1) ?? null,
    y: (value) => (value < low || value > high ? null : down(value)),
  };
}

const digits = { charge: 1, voltage: 2, temperature: 1 } as const;
const units = { charge: '%', voltage: 'V', temperature: '°C' } as const;
export const value_of = (quantity: Quantity, value: number | null): string => (value === null ? format.none : `${value.toFixed(digits[quantity])}\u202f${units[quantity]}`);

/** The text alternative of a plot, for screen readers. */
export function curve_text(name: string, quantity: Quantity, points: readonly BatteryPoint[]): string {
  const title = `${quantity[0]!.toUpperCase()}${quantity.slice(1)} of ${name}`;
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last || points.length < 2) return `${title}: nothing yet`;
  const at = column[quantity];
  return `${title}: from ${value_of(quantity, first[at])} to ${value_of(quantity, last[at])} in ${format.lasting(last[0] - first[0])}`;
}

const stop_text: Record<string, string> = {
  floor: 'at the floor', 'cut-off': 'cut off by itself', fault: 'by a fault', operator: 'by the operator', lost: 'lost: known to last longer',
};
export function phase_text({ phase, stop }: BatterySlot): string {
  if (phase === 'changing') return 'battery requested';
  if (phase === 'ready') return 'ready, waits for the others';
  if (phase === 'ended') return `ended${stop ? ` ${stop_text[stop] ?? stop}` : ''}`;
  return phase;
}

/** Without a report for this time, the test program is taken as terminated [ms]. */
export const unresponsive_ms = 10_000;

/** A sentence on the state of the test; `now_ms` on the server's clock. */
export function test_text(test: BatteryTest, now_ms: number): string {
  const run = test.runs > 1 ? `Run ${test.run} of ${test.runs}` : 'The run';
  if (test.done) {
    const given_up = test.vehicles.some((slot) => slot.phase !== 'ended' || slot.stop === 'operator');
    return `${given_up ? 'Given up' : 'Ended'} at ${format.clock(test.received_ms)}, after ${format.lasting(test.received_ms - test.began_ms)}.`;
  }
  if (now_ms - test.received_ms > unresponsive_ms) return `No message for ${format.lasting(now_ms - test.received_ms)}: its program has ended, or cannot reach the broker. The same command with its --state continues the test.`;
  const wanted = test.vehicles.filter((slot) => slot.phase === 'changing').length;
  if (wanted > 0) return `${run} waits for ${wanted === 1 ? 'a battery' : `${wanted} batteries`}.`;
  if (test.expectedEnd_ms === null) return `${run} has begun; its end is not known yet.`;
  return `${run} should end at ${format.clock(test.expectedEnd_ms)}, in ${format.lasting(test.expectedEnd_ms - now_ms)}.`;
}
