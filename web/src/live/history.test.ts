import { describe, expect, it } from 'vitest';
import { FleetHistory, History, fleet_slots, history_slots } from './history';
import { aiv, snapshot } from './snapshot_sample';

describe('the history', () => {
  it('keeps the last minute of each vehicle, oldest first', () => {
    const history = new History();
    for (let second = 0; second < 100; second++) history.accept(snapshot([aiv(1, { speed: second })], { time_ms: second * 1_000 }));
    const values = history.read('CoSiVA/AIV1', 'speed');
    expect(values).toHaveLength(history_slots);
    expect([values[0], values.at(-1)]).toEqual([100 - history_slots, 99]);
  });
  it('discards removed vehicles', () => {
    const history = new History();
    history.accept(snapshot([aiv(1), aiv(2)], { time_ms: 0 }));
    history.accept(snapshot([aiv(2)], { time_ms: 1_000 }));
    expect(history.read('CoSiVA/AIV1', 'age')).toEqual([]);
    expect(history.read('CoSiVA/AIV2', 'age')).toEqual([40, 40]);
  });
  it("keeps the worst value of each second of the fleet, and drops the oldest", () => {
    const fleet = new FleetHistory();
    for (let n = 0; n <= fleet_slots * 2; n++) fleet.accept(snapshot([aiv(1, { divergence_m: n % 2 ? 0.02 : 0.001 })], { time_ms: n * 500 }));
    for (let n = 0; n < 10; n++) fleet.accept(snapshot([aiv(1)], { time_ms: (fleet_slots + 1 + n) * 1_000 }));
    expect(fleet.count).toBe(fleet_slots);
    expect(fleet.divergence_m[100]).toBeCloseTo(0.02);
    expect(fleet.time_s[fleet.count - 1]).toBe(fleet_slots + 10);
  });
  it('restarts when the clock goes back, which means another run', () => {
    const fleet = new FleetHistory();
    for (const time_ms of [5_000, 6_000, 1_000]) fleet.accept(snapshot([aiv(1)], { time_ms }));
    expect([fleet.count, fleet.time_s[0]]).toEqual([1, 1]);
  });
});
