import { describe, expect, it } from 'vitest';
import { by_priority, moved, priorities_for, priority_of } from './priority';
import { aiv, rows } from '../live/snapshot_sample';

const names = (list: readonly { name: string }[]) => list.map((row) => row.name);

describe('priorities', () => {
  const fleet = rows(aiv(1), aiv(2, { priority: 7 }), aiv(3, { priority: 7 }), aiv(4, { priority: 9 }));

  it('put the highest first, equal ones by number', () => expect(names(by_priority(fleet))).toEqual(['AIV4', 'AIV2', 'AIV3', 'AIV1']));

  it('are distinct after a row was dragged, the topmost row the highest', () => {
    const order = moved(by_priority(fleet), 3, 0);
    expect(names(order)).toEqual(['AIV1', 'AIV4', 'AIV2', 'AIV3']);
    const wanted = priorities_for(order);
    const after = order.map((row) => wanted[row.id] ?? row.aiv.priority);
    expect(after).toEqual([4, 3, 2, 1]);
  });

  it('are sent only for changed rows', () => {
    const unchanged = rows(aiv(1, { priority: 2 }), aiv(2, { priority: 1 }));
    expect(priorities_for(by_priority(unchanged))).toEqual({});
  });

  it('stay within 0 to 999 for more than a thousand rows', () => {
    const many = rows(...Array.from({ length: 1_200 }, (_, i) => aiv(i + 1)));
    const numbers = Object.values(priorities_for(many));
    expect(Math.max(...numbers)).toBe(999);
    expect(Math.min(...numbers)).toBeGreaterThanOrEqual(0);
    expect(new Set(numbers).size).toBe(numbers.length);
  });

  it('can be entered as whole numbers only', () => {
    expect(['0', '999', ' 12 '].map(priority_of)).toEqual([0, 999, 12]);
    expect(['', '-1', '1000', '1.5', 'high', '1e2'].map(priority_of)).toEqual([null, null, null, null, null, null]);
  });

  it('move a row no further than the ends of the list', () => {
    expect(moved(['a', 'b', 'c'], 1, -5)).toEqual(['b', 'a', 'c']);
    expect(moved(['a', 'b', 'c'], 0, 9)).toEqual(['b', 'c', 'a']);
  });
});
