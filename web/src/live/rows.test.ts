import { describe, expect, it } from 'vitest';
import { matches, mission_note, rows_of } from './rows';
import { aiv, command, rows, snapshot } from './snapshot_sample';

describe('the rows', () => {
  it('are listed by number', () => {
    const rows = rows_of(snapshot([aiv(10), aiv(2)]));
    expect(rows.map((row) => row.label)).toEqual(['2', '10']);
  });

  it('have the virtual vehicles after the physical ones', () => {
    const rows = rows_of(snapshot([aiv(1, { id: 'CoSiVA.virtual/V1', augmented: true }), aiv(7)]));
    expect(rows.map((row) => row.name)).toEqual(['AIV7', 'V1']);
  });

  it('name the virtual object that a vehicle brakes for', () => {
    const [row] = rows_of(snapshot([aiv(1, { status: 'stopped', brakingFor: 'P1', fieldViolation: true })]));
    expect(row?.note).toBe('brakingFor P1');
  });

  it('name an excluded vehicle as such while it reports', () => {
    const notes = (change: object) => rows_of(snapshot([aiv(1, { excluded: true, ...change })]))[0]?.note;
    expect(notes({})).toBe('excluded');
    expect(notes({ connection: 'OFFLINE' })).toBe('signed off');
  });

  it('name the reason why a vehicle is stopped', () => {
    const [row] = rows_of(snapshot([aiv(1, { status: 'stopped', waitsFor: 'X2, CoSiVA/AIV4' })]));
    expect(row?.note).toBe('waits: X2, AIV4');
    expect(row?.alarms).toEqual([]);
  });
});

describe('notes of missions', () => {
  it('are shown for vehicles that were sent to a station', () => {
    const sent = (state: 'driving' | 'arrived' | 'no route') => aiv(1, { mission: { kind: 'go', to: 'dock', state } });
    expect([sent('driving'), sent('arrived'), sent('no route')].map(mission_note)).toEqual(['to dock', 'at dock', 'no route to dock']);
    expect(mission_note(aiv(1, { mission: { kind: 'circulate', loop: 'outer', state: 'driving' } }))).toBe('');
    expect(mission_note(aiv(1))).toBe('');
  });
});

describe('commands', () => {
  it('are shown on their row while in progress, then briefly', () => {
    const open = command({ time_ms: 0 });
    expect(rows_of(snapshot([aiv(1)], { commands: [open], time_ms: 60_000 }))[0]?.command).toBe(open);
    const done = command({ state: 'materialised', time_ms: 0 });
    expect(rows_of(snapshot([aiv(1)], { commands: [done], time_ms: 7_000 }))[0]?.command).toBe(done);
    expect(rows_of(snapshot([aiv(1)], { commands: [done], time_ms: 9_000 }))[0]?.command).toBeNull();
  });

  it('given to all are shown on every row', () => {
    const all = command({ vehicle: '*', time_ms: 9_900 });
    expect(rows_of(snapshot([aiv(1)], { commands: [all] }))[0]?.command).toBe(all);
  });
});

describe('search', () => {
  const [east, west] = rows(aiv(1, { section: 'east' }), aiv(12, { section: 'west', status: 'stopped', errors: ['wheel blocked'] })) as [ReturnType<typeof rows>[0], ReturnType<typeof rows>[0]];

  it('finds vehicles by name, number, state and section, case-insensitively', () => {
    for (const word of ['aiv12', '12', 'STOPPED', 'west', 'alarm']) expect([matches(east, word), matches(west, word)]).toEqual([false, true]);
  });
  it('requires all words', () => {
    expect(matches(west, 'stopped west')).toBe(true);
    expect(matches(west, 'stopped east')).toBe(false);
  });
  it('matches everything without input', () => expect(matches(east, '  ')).toBe(true));
});
