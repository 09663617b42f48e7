import { describe, expect, it } from 'vitest';
import type { Zone } from '../live/contract';
import type { Hit } from './hit_index';
import { drop_tag, empty_sketch, enter, erase, finish, hint, next_tag_number, press, renumber } from './tools';
import { field } from './zone_sample';

const zone = {
  primitives: [{ shape: 'polyline', layer: 'road', points: [[0, 0], [10, 0]], size_m: 0.2, label: 'east' }],
  tags: [{ number: 1, section: 'east', s: 1, x: 1, y: 0 }, { number: 3, section: 'east', s: 3, x: 3, y: 0 }],
} as unknown as Zone;
const tag_hit: Hit = { kind: 'tag', id: '3', x: 3, y: 0, movable: false };

describe('a tool that adds one virtual object', () => {
  it('adds it at the first press, and ends', () => {
    for (const tool of ['add aiv', 'add person', 'add obstacle', 'add plant obstacle', 'move object'] as const) {
      expect(press(tool, empty_sketch, [1, 2], null, zone)).toEqual({ sketch: empty_sketch, doing: { what: tool, at: [1, 2] }, done: true });
    }
  });
});

describe('a walking path', () => {
  it('grows by each press and ends with the path', () => {
    let sketch = press('draw walk', empty_sketch, [0, 0], null, zone).sketch;
    sketch = press('draw walk', sketch, [1, 0], null, zone).sketch;
    expect(finish('draw walk', sketch)).toEqual({ sketch: empty_sketch, doing: { what: 'add walk', path: [[0, 0], [1, 0]] }, done: true });
  });

  it('treats a double press as one point', () => {
    let sketch = press('draw walk', empty_sketch, [0, 0], null, zone).sketch;
    sketch = press('draw walk', sketch, [0.001, 0], null, zone).sketch;
    expect(sketch.points).toHaveLength(1);
  });

  it('does not end with fewer than two points; the page states what is missing', () => {
    expect(finish('draw walk', empty_sketch).doing).toMatchObject({ what: 'report' });
    const one = press('draw walk', empty_sketch, [0, 0], null, zone).sketch;
    expect(finish('draw walk', one)).toMatchObject({ sketch: one, doing: { what: 'report' } });
    expect(finish('draw walk', one).done).toBeUndefined();
  });

  it('can be drawn with Enter, and ended by Enter twice at one position', () => {
    let sketch = enter('draw walk', empty_sketch, [0, 0], null, zone).sketch;
    sketch = enter('draw walk', sketch, [1, 0], null, zone).sketch;
    expect(enter('draw walk', sketch, [1, 0], null, zone).doing).toEqual({ what: 'add walk', path: [[0, 0], [1, 0]] });
  });

  it('loses its last point to Delete', () => {
    expect(erase('draw walk', { points: [[0, 0], [1, 0]], tag: null }).sketch.points).toEqual([[0, 0]]);
    expect(erase('draw walk', empty_sketch).sketch.points).toEqual([]);
  });
});

describe('tags', () => {
  it('are selected by a press', () => {
    expect(press('edit tags', empty_sketch, [3, 0], tag_hit, zone)).toEqual({ sketch: { points: [], tag: 3 } });
  });

  it('are added on the pressed path, with the next free number', () => {
    const step = press('edit tags', empty_sketch, [5, 0.1], null, zone);
    expect(step).toEqual({ sketch: { points: [], tag: 2 }, doing: { what: 'edit zone', edit: { addTags: [{ number: 2, x: 5, y: 0 }] } } });
  });

  it('are deselected by a press away from every path', () => {
    expect(press('edit tags', { points: [], tag: 3 }, [5, 2], null, zone)).toEqual({ sketch: { points: [], tag: null } });
    expect(press('edit tags', empty_sketch, [5, 2], null, null)).toEqual({ sketch: empty_sketch });
  });

  it('are dragged along the circuit and not off it', () => {
    expect(drop_tag(3, [4, 0.2], zone)).toEqual({ position: [4, 0], doing: { what: 'edit zone', edit: { moveTags: [{ number: 3, x: 4, y: 0 }] } } });
    expect(drop_tag(3, [4, 0.5], zone)).toMatchObject({ position: null, doing: { what: 'report' } });
  });

  it('are removed by Delete, when one is selected', () => {
    expect(erase('edit tags', { points: [], tag: 3 })).toEqual({ sketch: { points: [], tag: null }, doing: { what: 'edit zone', edit: { removeTags: [3] } } });
    expect(erase('edit tags', empty_sketch)).toEqual({ sketch: empty_sketch });
  });

  it('can be renumbered in position, if the number is free and valid', () => {
    expect(renumber(zone, 3, 7)).toEqual({ what: 'edit zone', edit: { removeTags: [3], addTags: [{ number: 7, section: 'east', s: 3 }] } });
    for (const to of [1, 0, 1.5, NaN]) expect(renumber(zone, 3, to)).toMatchObject({ what: 'report' });
    expect(renumber(zone, 99, 5)).toMatchObject({ what: 'report' });
  });

  it('are numbered from one, with gaps first', () => {
    expect(next_tag_number(zone)).toBe(2);
    expect(next_tag_number({ ...zone, tags: [] })).toBe(1);
  });
});

describe('the measuring tool', () => {
  it('gives the length of all pieces and restarts with Enter', () => {
    const points = [[0, 0], [3, 0], [3, 4]] as const;
    expect(hint('measure', { points, tag: null }, null)).toContain('7.000 m');
    expect(finish('measure', { points, tag: null })).toEqual({ sketch: empty_sketch });
  });
});

describe('the hint', () => {
  it('exists for every tool except the default one', () => {
    expect(hint('none', empty_sketch, null)).toBe('');
    for (const tool of ['add aiv', 'add person', 'draw walk', 'add obstacle', 'add plant obstacle', 'edit tags', 'measure'] as const) {
      expect(hint(tool, empty_sketch, null)).toMatch(/^Press .*\.$/);
    }
    expect(hint('move object', empty_sketch, 'CoSiVA.virtual/V1')).toBe('Press where V1 goes.');
  });
});

describe('the tool for closing sections', () => {
  it('closes the section under the pointer, and nothing elsewhere', () => {
    const zone = field(3);
    expect(press('close sections', empty_sketch, [1.2, 1.02], null, zone).doing).toEqual({ what: 'close or open', section: 'w4' });
    expect(press('close sections', empty_sketch, [1.2, 1.6], null, zone).doing).toBeUndefined();
    expect(press('close sections', empty_sketch, [0, 0], null, null).doing).toBeUndefined();
  });
});
