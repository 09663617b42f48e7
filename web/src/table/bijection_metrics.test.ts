import { describe, expect, it } from 'vitest';
import type { Bijection } from '../live/contract';
import { figures_of } from './bijection_metrics';

const statistics = (p99: number, count = 100) => ({ count, mean: p99 / 3, p50: p99 / 3, p99, max: p99 * 1.1 });

const well: Bijection['held'] = { divergence: true, age: true, actual: true, commands: true, events: true, effects: true };
function bijection(change: Partial<Bijection> = {}): Bijection {
  return {
    physical: 4, virtual: 4, matched: 4, matched_ratio: 1, orphans: [],
    divergence_m: statistics(0.012), divergence_rad: statistics(0.02), age_ms: statistics(110),
    commands: { issued: 2, accepted: 2, materialised: 2, failed: 0, latency_ms: statistics(640, 2) },
    events: { count: 10, latency_ms: statistics(90, 10), by_kind: {} }, held_ratio: 1, augmented: 0, held: well,
    effects: { perceived_ms: statistics(8, 10), brakes_ms: statistics(9, 10), shown_ms: statistics(80, 10) }, ...change,
  };
}

describe('bijection metrics', () => {
  const verdicts = (b: Bijection) => Object.fromEntries(figures_of(b).map((f) => [f.key, f.verdict]));

  it('are within the limits in a good run', () => {
    expect(verdicts(bijection())).toEqual({ matched: 'kept', divergence: 'kept', age: 'kept', commands: 'kept', events: 'kept', perceived: 'kept', brakes: 'kept', shown: 'kept' });
  });

  it('are violated by an orphan, and by what the server reports as violated now', () => {
    const bad = bijection({
      matched: 3, virtual: 3, orphans: [{ side: 'physical', id: 'CoSiVA/AIV4' }], held: { ...well, divergence: false, age: false, commands: false, effects: false },
      commands: { issued: 1, accepted: 0, materialised: 0, failed: 1, latency_ms: statistics(0, 0) },
      effects: { perceived_ms: statistics(201), brakes_ms: statistics(181), shown_ms: statistics(0, 0) },
    });
    expect(verdicts(bad)).toEqual({ matched: 'broken', divergence: 'broken', age: 'broken', commands: 'broken', events: 'kept', perceived: 'broken', brakes: 'kept', shown: 'open' });
  });

  it('are undecided while nothing was measured', () => {
    const fresh = bijection({
      physical: 0, virtual: 0, matched: 0, divergence_m: statistics(0, 0), age_ms: statistics(0, 0),
      commands: { issued: 0, accepted: 0, materialised: 0, failed: 0, latency_ms: statistics(0, 0) },
      events: { count: 0, latency_ms: statistics(0, 0), by_kind: {} },
      effects: { perceived_ms: statistics(0, 0), brakes_ms: statistics(0, 0), shown_ms: statistics(0, 0) },
    });
    expect(new Set(Object.values(verdicts(fresh)))).toEqual(new Set(['open']));
  });

  it('omit effects that the server does not report', () => {
    const { effects: _, ...older } = bijection();
    expect(Object.keys(verdicts(older as Bijection))).toEqual(['matched', 'divergence', 'age', 'commands', 'events']);
  });

  it('are within the limits again after an overload, which the figures of the run still show', () => {
    const after = bijection({ divergence_m: statistics(0.2), age_ms: statistics(700), events: { count: 10, latency_ms: statistics(900, 10), by_kind: {} } });
    expect(verdicts(after)).toEqual(verdicts(bijection()));
    expect(figures_of(after).find(({ key }) => key === 'age')!.value).toBe('700\u202fms');
  });

  it('state the limits of the server if it reports them', () => {
    expect(figures_of(bijection({ contract: { divergence_p99_m: 0.01 } })).find(({ key }) => key === 'divergence')!.limit).toMatch(/^≤ (10|1.0|0.01)/);
  });
});
