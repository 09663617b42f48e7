import { describe, expect, it } from 'vitest';
import { Curve, phase_text, plot_of, curve_text, points_max, points_of, test_text } from './battery';
import type { BatteryPoint, BatterySlot, BatteryTest, Snapshot } from '../live/contract';

const point = (s: number, charge: number): BatteryPoint => [s * 1000, charge, 7.4, 22];
const slot = (change: Partial<BatterySlot> = {}): BatterySlot => ({ id: 'CoSiVA/AIV1', battery: 'red', phase: 'running', stop: null, autonomy_s: 60, charge: 81.25, ...change });
const test = (change: Partial<BatteryTest> = {}): BatteryTest => ({
  began_ms: 0, received_ms: 60_000, run: 1, runs: 1, floor: 20, progress: 0.25, expectedEnd_ms: 240_000, done: false, vehicles: [slot()], ...change,
});

describe('a battery curve', () => {
  it('adds one point per second and covers the whole test, however long it becomes', () => {
    const curve = new Curve();
    for (let i = 0; i <= 40_000; i++) curve.add(point(i / 4, 100 - i / 800));
    expect(curve.points.length).toBeLessThanOrEqual(points_max);
    expect(curve.points.length).toBeGreaterThan(points_max / 2);
    expect(curve.points[0]).toEqual(point(0, 100));
    const gaps = curve.points.slice(1).map((one, i) => one[0] - curve.points[i]![0]);
    expect(new Set(gaps)).toEqual(new Set([64_000]));
  });

  it('starts with the curve of the server, and restarts when the clock is set back', () => {
    const curve = new Curve();
    curve.begin([point(0, 100), point(60, 99)]);
    expect(curve.add(point(60.2, 99))).toBe(false);
    expect(curve.add(point(61, 98.9))).toBe(true);
    expect(curve.points).toHaveLength(3);
    curve.add(point(1, 100));
    expect(curve.points).toEqual([point(1, 100)]);
  });
});

describe('the points of a snapshot', () => {
  const aiv = { id: 'CoSiVA/AIV1', augmented: false, lost: false, battery: 81, power: { voltage_v: 7.4, current_a: 1, temperature_c: 22 } };
  const snapshot = (change: object, test_now: BatteryTest | null = null) => ({ time_ms: 5_000, aivs: [{ ...aiv, ...change }], battery: { changes: [], test: test_now } }) as unknown as Snapshot;

  it('come from the vehicle, and with higher resolution from the test that runs on it', () => {
    expect(points_of(snapshot({})).get(aiv.id)).toEqual([5_000, 81, 7.4, 22]);
    expect(points_of(snapshot({}, test())).get(aiv.id)).toEqual([5_000, 81.25, 7.4, 22]);
    // The test is over: a service battery may be installed.
    expect(points_of(snapshot({}, test({ vehicles: [slot({ phase: 'ended', charge: 20 })] }))).get(aiv.id)?.[1]).toBe(81);
  });

  it('are absent for lost, virtual and non-reporting vehicles', () => {
    for (const change of [{ lost: true }, { augmented: true }, { power: undefined }, { battery: null }]) expect(points_of(snapshot(change)).size).toBe(0);
    expect(points_of({ time_ms: 1, aivs: [] } as unknown as Snapshot).size).toBe(0);
  });
});

describe('the plot', () => {
  it('runs from left to right and from high to low, and includes the floor', () => {
    const plot = plot_of([point(0, 100), point(30, 80), point(60, 60)], 'charge', 100, 44, 20);
    expect(plot.path).toBe('M0.0 2.0L50.0 12.0L100.0 22.0');
    expect(plot.y(20)).toBe(42);
    expect(plot.y(10)).toBeNull();
    expect(plot.last).toBe(60);
  });

  it('does not magnify small changes', () => {
    const still = plot_of([point(0, 99.9), point(1, 99.8)], 'charge', 100, 44);
    expect([still.low, still.high]).toEqual([98, 100]);
    const flat = plot_of([point(0, 50), point(1, 50)], 'temperature', 100, 44);
    expect([flat.low, flat.high]).toEqual([21, 23]);
  });

  it('is empty without points, and states this', () => {
    expect(plot_of([], 'voltage', 100, 44).path).toBe('');
    expect(plot_of([point(0, 1)], 'voltage', 100, 44).path).toBe('');
    expect(curve_text('AIV1', 'charge', [])).toBe('Charge of AIV1: nothing yet');
  });

  it('has a text alternative for screen readers', () => {
    expect(curve_text('AIV1', 'charge', [point(0, 100), point(90, 61.25)])).toMatch(/^Charge of AIV1: from 100\.0.% to 61\.3.% in 1.min 30.s$/);
  });
});

describe('the texts', () => {
  it('state the result of a battery', () => {
    expect(phase_text(slot())).toBe('running');
    expect(phase_text(slot({ phase: 'changing' }))).toBe('battery requested');
    expect(phase_text(slot({ phase: 'ended', stop: 'floor' }))).toBe('ended at the floor');
    expect(phase_text(slot({ phase: 'ended', stop: 'lost' }))).toContain('known to last longer');
  });

  it('state the progress of the test', () => {
    expect(test_text(test(), 61_000)).toMatch(/^The run should end at .*, in 2.min 59.s\.$/);
    expect(test_text(test({ runs: 4, run: 2, vehicles: [slot({ phase: 'changing' }), slot()] }), 61_000)).toBe('Run 2 of 4 waits for a battery.');
    expect(test_text(test({ expectedEnd_ms: null }), 61_000)).toContain('is not known yet');
    expect(test_text(test({ done: true, vehicles: [slot({ phase: 'ended', stop: 'floor' })] }), 999_000)).toMatch(/^Ended at .*after 1.min 00.s\.$/);
    expect(test_text(test({ done: true, vehicles: [slot({ phase: 'changing' })] }), 999_000)).toMatch(/^Given up/);
  });

  it('state that the test program has ended', () => {
    expect(test_text(test(), 90_000)).toMatch(/^No message for 30.s: .*--state/);
  });
});
