// Snapshots, vehicles and commands for tests.
import type { Aiv, Bijection, Command, Snapshot } from './contract';
import { rows_of, type Row } from './rows';

export function aiv(number: number, change: Partial<Aiv> = {}): Aiv {
  return {
    id: `CoSiVA/AIV${number}`, handle: number - 1, number, augmented: false, connection: 'ONLINE', lost: false, status: 'Normal', x: 0, y: 0,
    heading: 0, speed: 0.3, section: 'east', s: 0.5, priority: 0, reported: null, age_ms: 40, divergence_m: 0.001, battery: 90, lastTag: 1,
    sinceTag_m: 0.1, lastNode: 'east@300', orderId: 'o', orderUpdateId: 0, driving: true, paused: false, fieldViolation: false, waitsFor: null,
    brakingFor: null, errors: [], reserved: [], contract: { matched: true, divergence: true, age: true }, ...change,
  };
}

const none = { count: 0, mean: 0, p50: 0, p99: 0, max: 0 };

export function snapshot(aivs: readonly Aiv[], change: Partial<Snapshot> = {}): Snapshot {
  const n = aivs.length;
  const bijection: Bijection = {
    physical: n, virtual: n, matched: n, matched_ratio: 1, orphans: [], augmented: 0, divergence_m: none, divergence_rad: none, age_ms: none,
    commands: { issued: 0, accepted: 0, materialised: 0, failed: 0, latency_ms: none }, events: { count: 0, latency_ms: none, by_kind: {} },
    effects: { perceived_ms: none, brakes_ms: none, shown_ms: none }, held_ratio: 1, held: { divergence: true, age: true, actual: true, commands: true, events: true, effects: true },
  };
  return {
    time: '', time_ms: 10_000, zoneRevision: 1, zoneEdits: { undo: 0, redo: 0, unsaved: false }, aivs, virtualObjects: [], obstacles: [], crossings: [],
    bijection, commands: [], ...change,
  };
}

export const rows = (...aivs: readonly Aiv[]): Row[] => rows_of(snapshot(aivs));

export function command(change: Partial<Command> = {}): Command {
  return { id: 'c1', vehicle: 'CoSiVA/AIV1', command: 'stop', state: 'issued', time_ms: 9_000, accepted_ms: null, materialised_ms: null, reason: '', ...change };
}
