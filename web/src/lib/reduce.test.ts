import { describe, expect, it } from 'vitest';
import { parse_live, type Aiv, type Bijection, type Command, type Snapshot } from './contract';
import { alarms_of, figures_of, link_after, rows_of, type Link } from './reduce';
import { state_key } from './status';

const statistics = (p99: number, count = 100) => ({ count, mean: p99 / 3, p50: p99 / 3, p99, max: p99 * 1.1 });

function bijection(change: Partial<Bijection> = {}): Bijection {
  return {
    physical: 4, virtual: 4, matched: 4, matched_share: 1, orphans: [],
    divergence_m: statistics(0.012), divergence_rad: statistics(0.02), age_ms: statistics(110),
    commands: { issued: 2, accepted: 2, materialised: 2, failed: 0, latency_ms: statistics(640, 2) },
    events: { count: 10, latency_ms: statistics(90, 10), by_kind: {} }, held_share: 1, augmented: 0,
    effects: { felt_ms: statistics(8, 10), brakes_ms: statistics(9, 10), shown_ms: statistics(80, 10) }, ...change,
  };
}

function aiv(change: Partial<Aiv> = {}): Aiv {
  return {
    id: 'CoSiVA/AIV1', handle: 0, number: 1, augmented: false, priority: 0, feels: null, reserved: [], connection: 'ONLINE', lost: false, status: 'Normal', x: 0, y: 0, heading: 0, speed: 0.3,
    section: 'east', s: 0.5, reported: null, age_ms: 40, divergence_m: 0.001, battery: 90, lastTag: 1, sinceTag_m: 0.1,
    lastNode: 'east@300', orderId: 'o', orderUpdateId: 0, driving: true, paused: false, fieldViolation: false,
    waitsFor: null, errors: [], contract: { matched: true, divergence: true, age: true }, ...change,
  };
}

function command(change: Partial<Command>): Command {
  return { id: 'c1', vehicle: 'CoSiVA/AIV1', command: 'stop', state: 'issued', time_ms: 0, accepted_ms: null, materialised_ms: null, reason: '', ...change };
}

function snapshot(aivs: Aiv[], commands: Command[] = [], time_ms = 10_000): Snapshot {
  return { time: '', time_ms, zoneRevision: 1, zoneEdits: { undo: 0, redo: 0, unsaved: false }, aivs, things: [], obstacles: [], crossings: [], bijection: bijection(), commands };
}

describe('states of AIVs', () => {
  it("are A7's five words, whatever their case", () => {
    const words = ['Normal', 'stopped', 'slow speed', 'Medium speed', 'fast speed'];
    expect(words.map((word) => state_key(word, false, 'ONLINE'))).toEqual(['normal', 'stopped', 'slow', 'medium', 'fast']);
  });

  it('are lost when the connection broke, whatever the vehicle last said', () => {
    expect(state_key('Normal', false, 'CONNECTIONBROKEN')).toBe('lost');
    expect(state_key('Normal', true, 'ONLINE')).toBe('lost');
  });

  it('are listed by number', () => {
    const rows = rows_of(snapshot([aiv({ id: 'CoSiVA/AIV10', number: 10 }), aiv({ id: 'CoSiVA/AIV2', number: 2 })]));
    expect(rows.map((row) => row.mark)).toEqual(['2', '10']);
  });

  it('list the virtual ones behind the physical ones', () => {
    const rows = rows_of(snapshot([aiv({ id: 'CoSiVA.virtual/V1', number: 1, augmented: true }), aiv({ id: 'CoSiVA/AIV7', number: 7 })]));
    expect(rows.map((row) => row.name)).toEqual(['AIV7', 'V1']);
  });

  it('say what virtual thing a vehicle brakes for', () => {
    const [row] = rows_of(snapshot([aiv({ status: 'stopped', feels: 'P1', fieldViolation: true })]));
    expect(row?.note).toBe('feels P1');
  });

  it('say why a vehicle stands', () => {
    const [row] = rows_of(snapshot([aiv({ status: 'stopped', waitsFor: 'X2, CoSiVA/AIV4' })]));
    expect(row?.note).toBe('waits: X2, AIV4');
    expect(row?.alarms).toEqual([]);
  });
});

describe('alarms', () => {
  it('are silent about a vehicle that is well', () => expect(alarms_of(aiv())).toEqual([]));

  it('name the broken link once, not its consequences', () => {
    const broken = aiv({ connection: 'CONNECTIONBROKEN', lost: true, contract: { matched: true, divergence: false, age: false } });
    expect(alarms_of(broken)).toEqual(['Connection broken']);
  });

  it('name a broken contract', () => {
    const far = aiv({ divergence_m: 0.05, contract: { matched: true, divergence: false, age: true } });
    expect(alarms_of(far)[0]).toContain('Divergence');
  });
});

describe('commands', () => {
  it('show on their row while they are under way, then for a moment', () => {
    const open = command({ time_ms: 0 });
    expect(rows_of(snapshot([aiv()], [open], 60_000))[0]?.command).toBe(open);
    const done = command({ state: 'materialised', time_ms: 0 });
    expect(rows_of(snapshot([aiv()], [done], 7_000))[0]?.command).toBe(done);
    expect(rows_of(snapshot([aiv()], [done], 9_000))[0]?.command).toBeNull();
  });

  it('given to all show on every row', () => {
    const all = command({ vehicle: '*', time_ms: 9_900 });
    expect(rows_of(snapshot([aiv()], [all]))[0]?.command).toBe(all);
  });
});

describe('bijection figures', () => {
  const verdicts = (b: Bijection) => Object.fromEntries(figures_of(b).map((f) => [f.key, f.verdict]));

  it('are kept in a good run', () => {
    expect(verdicts(bijection())).toEqual({ matched: 'kept', divergence: 'kept', age: 'kept', commands: 'kept', events: 'kept', felt: 'kept', brakes: 'kept', shown: 'kept' });
  });

  it('break on an orphan, on drift, on age and on a failed command', () => {
    const bad = bijection({
      matched: 3, virtual: 3, orphans: [{ side: 'physical', id: 'CoSiVA/AIV4' }], divergence_m: statistics(0.031), age_ms: statistics(151),
      commands: { issued: 1, accepted: 0, materialised: 0, failed: 1, latency_ms: statistics(0, 0) },
      effects: { felt_ms: statistics(201), brakes_ms: statistics(199), shown_ms: statistics(0, 0) },
    });
    expect(verdicts(bad)).toEqual({ matched: 'broken', divergence: 'broken', age: 'broken', commands: 'broken', events: 'kept', felt: 'broken', brakes: 'kept', shown: 'open' });
  });

  it('stay open while nothing was measured', () => {
    const fresh = bijection({
      physical: 0, virtual: 0, matched: 0, divergence_m: statistics(0, 0), age_ms: statistics(0, 0),
      commands: { issued: 0, accepted: 0, materialised: 0, failed: 0, latency_ms: statistics(0, 0) },
      events: { count: 0, latency_ms: statistics(0, 0), by_kind: {} },
      effects: { felt_ms: statistics(0, 0), brakes_ms: statistics(0, 0), shown_ms: statistics(0, 0) },
    });
    expect(new Set(Object.values(verdicts(fresh)))).toEqual(new Set(['open']));
  });

  it('leave out the effects of a server that does not tell them', () => {
    const { effects: _, ...older } = bijection();
    expect(Object.keys(verdicts(older as Bijection))).toEqual(['matched', 'divergence', 'age', 'commands', 'events']);
  });

  it("use the server's limits when it says them", () => {
    expect(verdicts(bijection({ contract: { divergence_p99_m: 0.01 } }))['divergence']).toBe('broken');
  });
});

describe('the link', () => {
  const at = (kind: 'opened' | 'frame' | 'closed' | 'tick', at_ms: number, last_frame_ms = 0) => ({ kind, at_ms, last_frame_ms });
  const start: Link = { phase: 'connecting', since_ms: 0 };

  it('is live with the first frame, not with the open socket', () => {
    const opened = link_after(start, at('opened', 10));
    expect(opened.phase).toBe('connecting');
    expect(link_after(opened, at('frame', 20)).phase).toBe('live');
  });

  it('notices a server that hangs without closing', () => {
    const live: Link = { phase: 'live', since_ms: 0 };
    expect(link_after(live, at('tick', 1_900, 1_000)).phase).toBe('live');
    expect(link_after(live, at('tick', 2_100, 1_000))).toEqual({ phase: 'silent', since_ms: 1_000 });
  });

  it('counts the loss from its start, over all attempts', () => {
    let link = link_after({ phase: 'live', since_ms: 0 }, at('closed', 5_000));
    link = link_after(link, at('opened', 6_000));
    link = link_after(link, at('closed', 6_500));
    expect(link.phase).toBe('down');
    expect(link.since_ms).toBeLessThanOrEqual(6_500);
    expect(link_after(link, at('frame', 7_000))).toEqual({ phase: 'live', since_ms: 7_000 });
  });
});

describe('the live stream', () => {
  it('skips what it does not know', () => {
    expect(parse_live('nonsense')).toBeNull();
    expect(parse_live('{"type":"other"}')).toBeNull();
    expect(parse_live('{"type":"zone","zone":null}')).toEqual({ type: 'zone', zone: null });
  });
});
