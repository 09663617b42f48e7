import { describe, expect, it } from 'vitest';
import { by_priority, moved, priorities_for, priority_of } from './command_priority';
import { entries_of, score_of, search } from './command_search';
import { aiv, rows } from './table_sample';

const names = (list: readonly { name: string }[]) => list.map((row) => row.name);

describe('priorities', () => {
  const fleet = rows(aiv(1), aiv(2, { priority: 7 }), aiv(3, { priority: 7 }), aiv(4, { priority: 9 }));

  it('put the highest on top, equals by number', () => expect(names(by_priority(fleet))).toEqual(['AIV4', 'AIV2', 'AIV3', 'AIV1']));

  it('are distinct after a row was carried to its place, the topmost the highest', () => {
    const order = moved(by_priority(fleet), 3, 0);
    expect(names(order)).toEqual(['AIV1', 'AIV4', 'AIV2', 'AIV3']);
    const wanted = priorities_for(order);
    const after = order.map((row) => wanted[row.id] ?? row.aiv.priority);
    expect(after).toEqual([4, 3, 2, 1]);
  });

  it('are sent only where they change', () => {
    const settled = rows(aiv(1, { priority: 2 }), aiv(2, { priority: 1 }));
    expect(priorities_for(by_priority(settled))).toEqual({});
  });

  it('stay within 0 to 999 for a thousand and more', () => {
    const many = rows(...Array.from({ length: 1_200 }, (_, i) => aiv(i + 1)));
    const numbers = Object.values(priorities_for(many));
    expect(Math.max(...numbers)).toBe(999);
    expect(Math.min(...numbers)).toBeGreaterThanOrEqual(0);
    expect(new Set(numbers).size).toBe(numbers.length);
  });

  it('can be typed as whole numbers, and as nothing else', () => {
    expect(['0', '999', ' 12 '].map(priority_of)).toEqual([0, 999, 12]);
    expect(['', '-1', '1000', '1.5', 'high', '1e2'].map(priority_of)).toEqual([null, null, null, null, null, null]);
  });

  it('carry a row no further than the ends', () => {
    expect(moved(['a', 'b', 'c'], 1, -5)).toEqual(['b', 'a', 'c']);
    expect(moved(['a', 'b', 'c'], 0, 9)).toEqual(['b', 'c', 'a']);
  });
});

describe('the list of commands', () => {
  const vehicles = [
    { id: 'CoSiVA/AIV1', name: 'AIV1', augmented: false },
    { id: 'CoSiVA/AIV2', name: 'AIV2', augmented: false },
    { id: 'CoSiVA.virtual/V1', name: 'V1', augmented: true },
  ];
  const entries = entries_of(vehicles, [{ id: 'P1' }]);
  const first = (typed: string) => search(entries, typed)[0]?.text;

  it('finds a command to one vehicle by its words', () => {
    expect(first('stop AIV2')).toBe('Stop AIV2');
    expect(first('slow aiv1')).toBe('Slow AIV1');
    expect(search(entries, 'stop aiv2')[0]?.doing).toEqual({ kind: 'command', verb: 'stop', vehicles: ['CoSiVA/AIV2'] });
  });
  it('finds by a few letters', () => {
    expect(first('stopall')).toBe('Stop all AIVs');
    expect(first('staiv2')).toBe('Stop AIV2');
    expect(first('st a2')).toBe('Stop AIV2');
    expect(first('followv1')).toBe('Follow V1');
  });
  it('removes what is virtual only', () => {
    expect(first('remove v1')).toBe('Remove V1');
    expect(first('remove p1')).toBe('Remove P1');
    expect(entries.some((entry) => entry.text === 'Remove AIV1')).toBe(false);
  });
  it('shows the first when nothing is typed, and nothing when nothing fits', () => {
    expect(search(entries, '')[0]?.text).toBe('Stop all AIVs');
    expect(search(entries, 'qqqq')).toEqual([]);
  });
  it('prefers letters that stand together', () => expect(score_of('Stop AIV1', 'stop')!).toBeGreaterThan(score_of('Show the whole topic', 'stop') ?? -Infinity));
  it('has each key once', () => expect(new Set(entries.map((entry) => entry.key)).size).toBe(entries.length));
  it('stays quick with a thousand vehicles', () => {
    const many = entries_of(Array.from({ length: 1_000 }, (_, i) => ({ id: `CoSiVA/AIV${i}`, name: `AIV${i}`, augmented: false })), []);
    expect(search(many, 'restart aiv777')[0]?.text).toBe('Restart AIV777');
  });
});
