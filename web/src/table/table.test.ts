import { describe, expect, it } from 'vitest';
import { abnormal, columns, columns_of, contract_of, csv_of, holds_of, mission_of, reserved_length, sort_after, sorted, sorted_like } from './table';
import { aiv, rows } from '../live/snapshot_sample';

const column = (key: string) => columns.find((one) => one.key === key)!;
const names = (list: readonly { name: string }[]) => list.map((row) => row.name);

describe('sorting', () => {
  const fleet = rows(aiv(1, { battery: 50 }), aiv(2, { battery: null }), aiv(3, { battery: 9 }));

  it('is ascending, then descending', () => {
    expect(sort_after('number', 'battery')).toBe('battery');
    expect(sort_after('battery', 'battery')).toBe('-battery');
    expect(sort_after('-battery', 'battery')).toBe('battery');
  });
  it('is by value, not by text: 9 % is less than 50 %', () => expect(names(sorted(fleet, 'battery'))).toEqual(['AIV3', 'AIV1', 'AIV2']));
  it('puts unknown values last in both directions', () => expect(names(sorted(fleet, '-battery'))).toEqual(['AIV1', 'AIV3', 'AIV2']));
  it('preserves the order of equal values, and of an unknown column', () => {
    expect(names(sorted(fleet, 'connection'))).toEqual(['AIV1', 'AIV2', 'AIV3']);
    expect(names(sorted(fleet, '-colour'))).toEqual(['AIV1', 'AIV2', 'AIV3']);
  });
  it('keeps the order while the pointer is on the table: new values, one vehicle removed, two added', () => {
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
  it('are all shown at first', () => expect(columns_of({})).toHaveLength(columns.length));
  it('are hidden as chosen by the user', () => {
    expect(columns_of({ position: true, state: false }).map((one) => one.key)).toEqual(columns.map((one) => one.key).filter((key) => key !== 'state'));
  });
});

describe('cells', () => {
  it('name what stops a vehicle, virtual objects first', () => {
    const [brakingFor, waits, sees, free] = rows(aiv(1, { brakingFor: 'P1', waitsFor: 'X1' }), aiv(2, { waitsFor: 'X2, CoSiVA/AIV4' }), aiv(3, { fieldViolation: true }), aiv(4));
    expect([brakingFor, waits, sees, free].map((row) => holds_of(row!))).toEqual(['brakingFor P1', 'waits for X2, AIV4', 'obstacle ahead', '']);
  });
  it('name the violated part of the contract', () => {
    const [row] = rows(aiv(1, { contract: { matched: true, divergence: false, age: false } }));
    expect(contract_of(row!)).toBe('not divergence, age');
  });
  it('give the length of the reserved path along its bends', () => {
    const [row] = rows(aiv(1, { reserved: [[0, 0], [0.3, 0], [0.3, 0.4]] }));
    expect(reserved_length(row!)).toBeCloseTo(0.7);
  });
  it('are coloured only if abnormal', () => {
    const [well, far, low] = rows(aiv(1), aiv(2, { divergence_m: 0.031 }), aiv(3, { battery: 19 }));
    expect(columns.filter((one) => abnormal(one, well!))).toEqual([]);
    expect(abnormal(column('divergence'), far!)).toBe(true);
    expect(abnormal(column('battery'), low!)).toBe(true);
  });
  it('show no divergence of a lost vehicle, since there is nothing to compare', () => {
    const [row] = rows(aiv(1, { lost: true, divergence_m: 3 }));
    expect(column('divergence').text(row!)).toBe('–');
    expect(abnormal(column('divergence'), row!)).toBe(false);
  });
});

describe('missions', () => {
  it('have a column of the table', () => {
    const circling = aiv(1, { mission: { kind: 'circulate', loop: 'outer', state: 'driving' } });
    const offRoute = aiv(2, { offRoute: '0.8 m from every section' });
    expect(rows(circling, offRoute, aiv(3)).map(mission_of)).toEqual(['circulates on outer', 'offRoute', '']);
  });
});

describe('CSV', () => {
  it('has a header, exact values and a line per row', () => {
    const lines = csv_of(rows(aiv(1, { speed: 0.123456 }))).trimEnd().split('\r\n');
    expect(lines).toHaveLength(2);
    expect(lines[0]).toMatch(/^number,id,state,speed_mps,/);
    expect(lines[1]).toContain('CoSiVA/AIV1');
    expect(lines[1]).toContain('0.123456');
  });
  it('quotes values with commas, quotes or line ends', () => {
    const text = csv_of(rows(aiv(1, { orderId: 'a "b", c' })));
    expect(text).toContain('"a ""b"", c');
  });
  it('never contains a formula for a spreadsheet', () => expect(csv_of(rows(aiv(1, { id: '=HYPERLINK("x")/y' })))).toContain(`"'=HYPERLINK(""x"")/y"`));
});
