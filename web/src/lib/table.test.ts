import { describe, expect, it } from 'vitest';
import { abnormal, columns, columns_in, contract_of, csv_of, holds_of, matches, reserved_length, sort_after, sorted, sorted_like } from './table';
import { FleetHistory, History, fleet_slots, history_slots } from './table_history';
import { aiv, rows, snapshot } from './table_sample';
import { scroll_to_show, window_of } from './table_window';

const column = (key: string) => columns.find((one) => one.key === key)!;
const names = (list: readonly { name: string }[]) => list.map((row) => row.name);

describe('search', () => {
  const [east, west] = rows(aiv(1, { section: 'east' }), aiv(12, { section: 'west', status: 'stopped', errors: ['wheel blocked'] })) as [ReturnType<typeof rows>[0], ReturnType<typeof rows>[0]];

  it('finds by name, number, state and place, whatever the case', () => {
    for (const word of ['aiv12', '12', 'STOPPED', 'west', 'alarm']) expect([matches(east, word), matches(west, word)]).toEqual([false, true]);
  });
  it('wants all words', () => {
    expect(matches(west, 'stopped west')).toBe(true);
    expect(matches(west, 'stopped east')).toBe(false);
  });
  it('wants nothing when nothing is typed', () => expect(matches(east, '  ')).toBe(true));
});

describe('sorting', () => {
  const fleet = rows(aiv(1, { battery: 50 }), aiv(2, { battery: null }), aiv(3, { battery: 9 }));

  it('goes up, then down', () => {
    expect(sort_after('number', 'battery')).toBe('battery');
    expect(sort_after('battery', 'battery')).toBe('-battery');
    expect(sort_after('-battery', 'battery')).toBe('battery');
  });
  it('is by value, not by text: 9 % is less than 50 %', () => expect(names(sorted(fleet, 'battery'))).toEqual(['AIV3', 'AIV1', 'AIV2']));
  it('leaves the unknown at the end both ways', () => expect(names(sorted(fleet, '-battery'))).toEqual(['AIV1', 'AIV3', 'AIV2']));
  it('keeps the order of equals, and of an unknown column', () => {
    expect(names(sorted(fleet, 'connection'))).toEqual(['AIV1', 'AIV2', 'AIV3']);
    expect(names(sorted(fleet, '-colour'))).toEqual(['AIV1', 'AIV2', 'AIV3']);
  });
  it('stays as it was while somebody points: new values, one gone, two that came', () => {
    const before = sorted(fleet, 'battery'); // 3, 1, 2
    const after = rows(aiv(5, { battery: 1 }), aiv(1, { battery: 2 }), aiv(4, { battery: 3 }), aiv(3, { battery: 60 }));
    expect(names(sorted_like(before, after))).toEqual(['AIV3', 'AIV1', ...names(after).filter((name) => /[45]/.test(name))]);
  });
  it('is by distance within a section: 2 m before 10 m', () => {
    const list = rows(aiv(1, { s: 10 }), aiv(2, { s: 2 }), aiv(3, { section: null, s: null }));
    expect(names(sorted(list, 'section'))).toEqual(['AIV2', 'AIV1', 'AIV3']);
  });
});

describe('columns', () => {
  it('are all there when there is room', () => expect(columns_in(5_000, {})).toHaveLength(columns.length));
  it('leave in the order of their importance, never the first three', () => {
    expect(columns_in(0, {}).map((one) => one.key)).toEqual(['number', 'name', 'state']);
    const some = columns_in(800, {}).map((one) => one.key);
    expect(some).toContain('battery');
    expect(some).not.toContain('position');
  });
  it('stay or go as somebody chose', () => {
    const chosen = columns_in(0, { position: true, state: false }).map((one) => one.key);
    expect(chosen).toEqual(['number', 'name', 'position']);
  });
});

describe('cells', () => {
  it('say what holds a vehicle, the virtual before the rest', () => {
    const [feels, waits, sees, free] = rows(aiv(1, { feels: 'P1', waitsFor: 'X1' }), aiv(2, { waitsFor: 'X2, CoSiVA/AIV4' }), aiv(3, { fieldViolation: true }), aiv(4));
    expect([feels, waits, sees, free].map((row) => holds_of(row!))).toEqual(['feels P1', 'waits for X2, AIV4', 'obstacle ahead', '']);
  });
  it('name what of the contract is broken', () => {
    const [row] = rows(aiv(1, { contract: { matched: true, divergence: false, age: false } }));
    expect(contract_of(row!)).toBe('not divergence, age');
  });
  it('measure the reserved way along its bends', () => {
    const [row] = rows(aiv(1, { reserved: [[0, 0], [0.3, 0], [0.3, 0.4]] }));
    expect(reserved_length(row!)).toBeCloseTo(0.7);
  });
  it('have a colour only where they are abnormal', () => {
    const [well, far, low] = rows(aiv(1), aiv(2, { divergence_m: 0.031 }), aiv(3, { battery: 19 }));
    expect(columns.filter((one) => abnormal(one, well!))).toEqual([]);
    expect(abnormal(column('divergence'), far!)).toBe(true);
    expect(abnormal(column('battery'), low!)).toBe(true);
  });
  it('show no divergence of a vehicle that is lost: there is nothing to compare', () => {
    const [row] = rows(aiv(1, { lost: true, divergence_m: 3 }));
    expect(column('divergence').text(row!)).toBe('–');
    expect(abnormal(column('divergence'), row!)).toBe(false);
  });
});

describe('CSV', () => {
  it('has a head, exact values and a line per row', () => {
    const lines = csv_of(rows(aiv(1, { speed: 0.123456 }))).trimEnd().split('\r\n');
    expect(lines).toHaveLength(2);
    expect(lines[0]).toMatch(/^number,id,state,speed_mps,/);
    expect(lines[1]).toContain('CoSiVA/AIV1');
    expect(lines[1]).toContain('0.123456');
  });
  it('quotes what has commas, quotes or ends of lines', () => {
    const text = csv_of(rows(aiv(1, { orderId: 'a "b", c' })));
    expect(text).toContain('"a ""b"", c');
  });
  it('never hands a formula to a spreadsheet', () => expect(csv_of(rows(aiv(1, { id: '=HYPERLINK("x")/y' })))).toContain(`"'=HYPERLINK(""x"")/y"`));
});

describe('a long list', () => {
  it('is whole while it is short', () => expect(window_of(500, 300, 30, 100)).toEqual({ first: 0, last: 100, before_px: 0, after_px: 0 }));
  it('has in the document what is in sight, and keeps its height', () => {
    const seen = window_of(30_000, 300, 30, 10_000);
    expect(seen.last - seen.first).toBeLessThan(30);
    expect(seen.first).toBeLessThanOrEqual(1_000);
    expect(seen.before_px + (seen.last - seen.first) * 30 + seen.after_px).toBe(300_000);
  });
  it('ends at its end, also when it has just become shorter', () => {
    expect(window_of(1e9, 300, 30, 200).last).toBe(200);
    expect(window_of(1e9, 300, 30, 200).first).toBeLessThan(200);
  });
  it('scrolls no further than it must', () => {
    expect(scroll_to_show(5, 0, 300, 30)).toBe(0);
    expect(scroll_to_show(20, 0, 300, 30)).toBe(330);
    expect(scroll_to_show(2, 330, 300, 30)).toBe(60);
  });
});

describe('history', () => {
  it('keeps the last minute of each, oldest first', () => {
    const history = new History();
    for (let second = 0; second < 100; second++) history.accept(snapshot([aiv(1, { speed: second })], { time_ms: second * 1_000 }));
    const kept = history.read('CoSiVA/AIV1', 'speed');
    expect(kept).toHaveLength(history_slots);
    expect([kept[0], kept.at(-1)]).toEqual([100 - history_slots, 99]);
  });
  it('forgets who is gone', () => {
    const history = new History();
    history.accept(snapshot([aiv(1), aiv(2)], { time_ms: 0 }));
    history.accept(snapshot([aiv(2)], { time_ms: 1_000 }));
    expect(history.read('CoSiVA/AIV1', 'age')).toEqual([]);
    expect(history.read('CoSiVA/AIV2', 'age')).toEqual([40, 40]);
  });
  it("keeps the worst of each second of the fleet, and drops the oldest", () => {
    const fleet = new FleetHistory();
    for (let n = 0; n <= fleet_slots * 2; n++) fleet.accept(snapshot([aiv(1, { divergence_m: n % 2 ? 0.02 : 0.001 })], { time_ms: n * 500 }));
    for (let n = 0; n < 10; n++) fleet.accept(snapshot([aiv(1)], { time_ms: (fleet_slots + 1 + n) * 1_000 }));
    expect(fleet.count).toBe(fleet_slots);
    expect(fleet.divergence_m[100]).toBeCloseTo(0.02);
    expect(fleet.time_s[fleet.count - 1]).toBe(fleet_slots + 10);
  });
  it('starts anew when the clock goes back: it is another run', () => {
    const fleet = new FleetHistory();
    for (const time_ms of [5_000, 6_000, 1_000]) fleet.accept(snapshot([aiv(1)], { time_ms }));
    expect([fleet.count, fleet.time_s[0]]).toEqual([1, 1]);
  });
});
