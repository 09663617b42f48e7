import { describe, expect, it } from 'vitest';
import { AlarmBook, causes_of } from './alarms';
import type { Aiv, Deadlock, Snapshot, ZoneState } from './contract';
import { alarms_of, rows_of } from './rows';
import { aiv, command, snapshot } from './snapshot_sample';

const board = (health: 'ok' | 'lost' | 'faulty', selfTest = 0) => ({ board: 'DOBS', health, firmware: '', uptime_ms: 0, frames: 0, framesBad: 0, framesMissed: 0, selfTest });

function alarms_after(book: AlarmBook, aivs: Aiv[], change: Partial<Snapshot> = {}) {
  const now = snapshot(aivs, change);
  book.accept(rows_of(now), now);
  return book.list();
}

describe('abnormal conditions', () => {
  it('exclude a vehicle without faults and one that waits for its turn', () => {
    expect(causes_of(aiv(1))).toEqual([]);
    expect(causes_of(aiv(1, { status: 'stopped', waitsFor: 'X2' }))).toEqual([]);
  });

  it('include a lost or faulty board and a low battery', () => {
    const texts = causes_of(aiv(1, { boards: [board('faulty', 3)], battery: 12 })).map((cause) => cause.text);
    expect(texts).toEqual(['Board DOBS faulty, self-test 3', 'Battery at 12\u202f%']);
  });

  it('include a broken link alone, without its consequences', () => {
    const gone = aiv(1, { connection: 'CONNECTIONBROKEN', lost: true, battery: 3, boards: [board('lost')] });
    expect(causes_of(gone).map((cause) => cause.code)).toEqual(['broken']);
  });
});

describe('alarms of crossing units', () => {
  const unit = { crossing: 'X1', x: 0.15, y: -0.15, state: 'online', age_ms: 90, holders: [], waiting: [], trouble: null } as const;

  it('last as long as the unit has a trouble', () => {
    const book = new AlarmBook();
    expect(alarms_after(book, [], { units: [unit] })).toEqual([]);
    expect(alarms_after(book, [], { units: [{ ...unit, state: 'unresponsive', trouble: 'no status for 2 s' }] })).toMatchObject([{ name: 'Crossing unit X1', vehicle: null, text: 'No status for 2 s', ended_ms: null }]);
    expect(alarms_after(book, [], { units: [{ ...unit, state: 'unresponsive', trouble: 'no status for 3 s' }] })).toMatchObject([{ text: 'No status for 3 s' }]);
    expect(alarms_after(book, [], { units: [unit], time_ms: 12_000 })).toMatchObject([{ ended_ms: 12_000 }]);
  });
});

describe('alarms of the platform', () => {
  const part = { name: 'gvs', state: 'failing', restarts: 12, last_error: 'exit 3' } as const;

  it('name a part that does not stay up, until it does', () => {
    const book = new AlarmBook();
    expect(alarms_after(book, [], { parts: [part] })).toMatchObject([{ name: 'Platform', vehicle: null, text: 'gvs does not stay up (exit 3); started again 12 times', ended_ms: null }]);
    expect(alarms_after(book, [], { parts: [{ ...part, restarts: 13 }] })).toMatchObject([{ text: 'gvs does not stay up (exit 3); started again 13 times', ended_ms: null }]);
    expect(alarms_after(book, [], { parts: [{ ...part, restarts: 13, state: 'running' }], time_ms: 15_000 })).toMatchObject([{ ended_ms: 15_000 }]);
  });

  it('name a part that hung and was started again, once', () => {
    const book = new AlarmBook();
    const hung = { name: 'plant', state: 'running', restarts: 1, last_error: 'no response; killed (signal 9)' } as const;
    expect(alarms_after(book, [], { parts: [hung] })).toMatchObject([{ text: 'plant was started again: no response; killed (signal 9)', ended_ms: 10_000 }]);
    book.acknowledge('*');
    expect(alarms_after(book, [], { parts: [hung] })).toEqual([]);
    expect(alarms_after(book, [], { parts: [{ ...hung, restarts: 2 }] })).toMatchObject([{ text: 'plant was started again, 2 times so far: no response; killed (signal 9)' }]);
  });

  it('name a registry that refuses vehicles', () => {
    const book = new AlarmBook();
    const registry = { vehicles: 2_000, max: 2_000, refused: 7, full: true };
    expect(alarms_after(book, [], { registry })).toMatchObject([{ name: 'Platform', text: 'The server has its limit of 2000 vehicles; further ones are refused', ended_ms: null }]);
    expect(alarms_after(book, [], { registry: { ...registry, full: false } })).toMatchObject([{ ended_ms: 10_000 }]);
  });

  it('exclude parts that run', () => {
    expect(alarms_after(new AlarmBook(), [], { parts: [{ ...part, state: 'running', restarts: 0, last_error: null }], registry: { vehicles: 4, max: 2_000, refused: 0, full: false } })).toEqual([]);
  });
});

describe('the alarm list', () => {
  it('keeps one entry while a condition lasts, whatever its values', () => {
    const book = new AlarmBook();
    alarms_after(book, [aiv(1, { lost: true, age_ms: 1_000 })]);
    const [one, ...more] = alarms_after(book, [aiv(1, { lost: true, age_ms: 2_000 })], { time_ms: 11_000 });
    expect(more).toEqual([]);
    expect(one).toMatchObject({ since_ms: 10_000, text: 'No report for 2.0\u202fs', ended_ms: null, acknowledged: false });
  });

  it('names the battery that a test requests for a vehicle, until it is installed', () => {
    const book = new AlarmBook();
    const change = { vehicle: 'CoSiVA/AIV1', battery: 'red', run: 1, reason: '', since_ms: 10_000 };
    expect(alarms_after(book, [aiv(1)], { battery: { changes: [change], test: null } })[0]).toMatchObject({ name: 'AIV1', text: 'Battery red is requested', ended_ms: null });
    const refused = { ...change, reason: 'it is not full: 80 %' };
    expect(alarms_after(book, [aiv(1)], { battery: { changes: [refused], test: null } })).toMatchObject([{ text: 'Battery red is requested: it is not full: 80 %' }]);
    expect(alarms_after(book, [aiv(1)], { time_ms: 15_000, battery: null })[0]).toMatchObject({ ended_ms: 15_000 });
  });

  it('keeps an ended alarm until it is acknowledged', () => {
    const book = new AlarmBook();
    alarms_after(book, [aiv(1, { connection: 'CONNECTIONBROKEN' })]);
    const [over] = alarms_after(book, [aiv(1)], { time_ms: 15_000 });
    expect(over).toMatchObject({ ended_ms: 15_000, acknowledged: false });
    book.acknowledge(over!.key);
    expect(book.list()).toEqual([]);
  });

  it('keeps an acknowledged alarm below the others while its condition lasts, and then removes it', () => {
    const book = new AlarmBook();
    const [first] = alarms_after(book, [aiv(1, { connection: 'CONNECTIONBROKEN' })]);
    book.acknowledge(first!.key);
    const both = alarms_after(book, [aiv(1, { connection: 'CONNECTIONBROKEN' }), aiv(2, { battery: 5 })], { time_ms: 11_000 });
    expect(both.map((alarm) => [alarm.name, alarm.acknowledged])).toEqual([['AIV2', false], ['AIV1', true]]);
    expect(alarms_after(book, [aiv(1), aiv(2, { battery: 5 })], { time_ms: 12_000 }).map((alarm) => alarm.name)).toEqual(['AIV2']);
  });

  it('adds a new entry when a condition recurs', () => {
    const book = new AlarmBook();
    alarms_after(book, [aiv(1, { lost: true })]);
    book.acknowledge('*');
    alarms_after(book, [aiv(1)], { time_ms: 11_000 });
    expect(alarms_after(book, [aiv(1, { lost: true })], { time_ms: 12_000 })).toMatchObject([{ since_ms: 12_000, acknowledged: false }]);
  });

  it('reports a failed command once, with its reason', () => {
    const book = new AlarmBook();
    const commands = [command({ state: 'failed', reason: 'offline' })];
    const [one] = alarms_after(book, [aiv(1)], { commands });
    expect(one?.text).toBe('stop failed: offline');
    book.acknowledge('*');
    expect(alarms_after(book, [aiv(1)], { commands })).toEqual([]);
  });

  const deadlocks = (change: Partial<Deadlock>): Partial<Snapshot> => ({
    deadlocks: {
      cycles: 1, detected: 1, resolved: 0, open: 1, unresolved: 0, longest_s: 0, longest_wait_s: 0,
      list: [{ number: 1, since_ms: 10_000, state: 'confirmed', members: ['CoSiVA/AIV1', 'CoSiVA/AIV2'], reason: 'CoSiVA/AIV1 waits for X1, which CoSiVA/AIV2 holds, CoSiVA/AIV2 detects CoSiVA/AIV1 in its path', how: '', ended_ms: null, ...change }],
    },
  });

  it('describes a deadlock from its beginning to its end', () => {
    const book = new AlarmBook();
    expect(alarms_after(book, [aiv(1)], deadlocks({ number: 0, state: 'forming' }))).toEqual([]);
    const confirmed = alarms_after(book, [aiv(1)], deadlocks({}));
    expect(confirmed).toMatchObject([{ name: 'Traffic', ended_ms: null, text: 'Deadlock: AIV1 waits for X1, which AIV2 holds, AIV2 detects AIV1 in its path' }]);
    const how = 'CoSiVA/AIV1 backs up 10 cm';
    expect(alarms_after(book, [aiv(1)], { ...deadlocks({ state: 'unresolved', how }), time_ms: 14_000 })[0]?.text).toMatch(/^Deadlock, unresolved: .*\. AIV1 backs up 10 cm$/);
    const over = alarms_after(book, [aiv(1)], { ...deadlocks({ state: 'resolved', how, ended_ms: 15_000 }), time_ms: 16_000 });
    expect(over).toMatchObject([{ since_ms: 10_000, ended_ms: 15_000, text: expect.stringContaining('Deadlock, resolved after 5.0\u202fs') }]);
    book.acknowledge('*');
    expect(alarms_after(book, [aiv(1)], { ...deadlocks({ state: 'resolved', how, ended_ms: 15_000 }), time_ms: 17_000 })).toEqual([]);
  });

  it('reports a deadlock that ended between two snapshots, and none of long ago', () => {
    expect(alarms_after(new AlarmBook(), [aiv(1)], { ...deadlocks({ state: 'resolved', ended_ms: 12_000 }), time_ms: 13_000 })).toHaveLength(1);
    expect(alarms_after(new AlarmBook(), [aiv(1)], { ...deadlocks({ state: 'resolved', ended_ms: 12_000 }), time_ms: 99_000 })).toEqual([]);
  });

  it('names both sides of a violated bijection', () => {
    const now = snapshot([aiv(1)]);
    const bijection = { ...now.bijection, orphans: [{ side: 'virtual' as const, id: 'CoSiVA/AIV9', reason: 'it has signed off (OFFLINE)', since_ms: 0 }] };
    expect(alarms_after(new AlarmBook(), [aiv(1)], { bijection })).toMatchObject([{ name: 'AIV9', text: 'A twin without a vehicle: it has signed off (OFFLINE)' }]);
  });

  it('names the twin of a vehicle that has signed off as long as the twin exists, though the vehicle is lost by then', () => {
    const book = new AlarmBook();
    const left = [aiv(9, { connection: 'OFFLINE', lost: true })];
    const orphans = [{ side: 'virtual' as const, id: 'CoSiVA/AIV9', reason: 'it has signed off (OFFLINE)', since_ms: 0 }];
    const alarms = alarms_after(book, left, { bijection: { ...snapshot(left).bijection, orphans }, time_ms: 12_000 });
    expect(alarms).toMatchObject([{ name: 'AIV9', ended_ms: null }]);
    expect(alarms_after(book, [], { time_ms: 13_000 })).toMatchObject([{ name: 'AIV9', ended_ms: 13_000 }]);
  });

  it('names a body that the camera sees once, by its finding', () => {
    const now = snapshot([aiv(1)]);
    const text = 'the camera sees it (tag 7) at (0.1, 0.4), and it has no twin';
    const bijection = { ...now.bijection, orphans: [{ side: 'physical' as const, id: 'ACME/7', reason: text, since_ms: 0 }], findings: [{ kind: 'no twin' as const, id: 'ACME/7', text, since_ms: 0 }] };
    expect(alarms_after(new AlarmBook(), [aiv(1)], { bijection })).toMatchObject([{ name: '7', text }]);
  });

  it('contains the findings of the camera over the zone, about an AIV or the camera itself, until they end', () => {
    const book = new AlarmBook();
    const found = (kind: 'no twin' | 'no detection', id: string, text: string) => ({ bijection: { ...snapshot([]).bijection, findings: [{ kind, id, text, since_ms: 0 }] } });
    expect(alarms_after(book, [aiv(1)], found('no twin', 'CoSiVA/AIV7', 'the camera sees it, and it has no twin'))).toMatchObject([{ vehicle: 'CoSiVA/AIV7', name: 'AIV7', text: 'the camera sees it, and it has no twin', ended_ms: null }]);
    const blind = alarms_after(book, [aiv(1)], found('no detection', 'GVS', 'no image arrives'));
    expect(blind).toMatchObject([{ vehicle: null, name: 'GVS', ended_ms: null }, { vehicle: 'CoSiVA/AIV7', ended_ms: 10_000 }]);
    expect(causes_of(aiv(1, { contract: { matched: true, divergence: true, age: true, actual: false } })).map((cause) => cause.code)).toEqual(['actual']);
  });

  it('has a bounded length, however long the page is open', () => {
    const book = new AlarmBook();
    for (let n = 0; n < 1_000; n++) alarms_after(book, [aiv(1)], { commands: [command({ id: `c${n}`, state: 'failed', time_ms: n })] });
    const listed = book.list();
    expect(listed.length).toBeLessThanOrEqual(200);
    expect(listed[0]?.since_ms).toBe(999);
  });
});

describe('the alarms of a row', () => {
  it('are empty for a vehicle without faults', () => expect(alarms_of(aiv(1))).toEqual([]));

  it('name the broken link once, without its consequences', () => {
    const broken = aiv(1, { connection: 'CONNECTIONBROKEN', lost: true, contract: { matched: true, divergence: false, age: false } });
    expect(alarms_of(broken)).toEqual(['Connection broken']);
  });

  it('name a violated contract', () => {
    const far = aiv(1, { divergence_m: 0.05, contract: { matched: true, divergence: false, age: true } });
    expect(alarms_of(far)[0]).toContain('Divergence');
  });
});

describe('missions', () => {
  it('without a route are abnormal, and so is an off-route vehicle', () => {
    expect(causes_of(aiv(1, { mission: { kind: 'go', to: 'dock', state: 'no route', why: 'east is closed' } })).map((one) => one.text)).toEqual(['east is closed']);
    expect(causes_of(aiv(1, { offRoute: 'it is 0.8 m from every section' })).map((one) => one.text)).toEqual(['Off-route: it is 0.8 m from every section']);
  });
});

describe('a switch to another zone', () => {
  const state = (change: Partial<ZoneState>): ZoneState => ({ name: 'a', revision: 1, closed: [], refused: null, switched: null, ...change });
  it('that was refused is one alarm until it is acknowledged', () => {
    const book = new AlarmBook();
    const now = snapshot([], { zone: state({ refused: { origin: 'bad', why: 'line 3 is wrong', at: 5 } }) });
    expect(book.accept([], now)).toBe(true);
    expect(book.accept([], now)).toBe(false);
    expect(book.list().map((alarm) => alarm.text)).toEqual(['bad was refused: line 3 is wrong']);
    book.acknowledge('*');
    book.accept([], now);
    expect(book.list()).toEqual([]);
    book.accept([], snapshot([], { zone: state({ refused: { origin: 'bad', why: 'line 4 is wrong', at: 9 } }) }));
    expect(book.list()).toHaveLength(1);
  });
});
