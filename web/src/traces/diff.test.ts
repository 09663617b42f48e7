import { describe, expect, it } from 'vitest';
import { diff } from './diff';
import { lines_of } from './json_lines';

describe('the difference', () => {
  it('is empty between equal messages, however they are nested', () => {
    const value = { a: [1, { b: null }], c: 'x' };
    expect(diff(value, structuredClone(value))).toEqual([]);
  });
  it('is listed by path, with the older value', () => {
    expect(diff({ a: { b: 1 }, gone: true }, { a: { b: 2 }, fresh: [] })).toEqual([
      { path: 'a.b', what: 'changed', was: 1, within: 'a.b' },
      { path: 'fresh', what: 'added', within: 'fresh' },
      { path: 'gone', what: 'removed', was: true, within: '' },
    ]);
  });
  it('of kind is a difference of the whole value', () => {
    expect(diff({ a: [1] }, { a: { 0: 1 } })).toEqual([{ path: 'a', what: 'changed', was: [1], within: 'a' }]);
    expect(diff({ a: null }, { a: {} })).toEqual([{ path: 'a', what: 'changed', was: null, within: 'a' }]);
  });
  it('excludes nodes that moved up in the list after earlier ones were removed', () => {
    const node = (id: string, sequenceId: number, released = true) => ({ nodeId: id, sequenceId, released });
    const older = { nodeStates: [node('a', 0), node('b', 2), node('c', 4, false)] };
    const newer = { nodeStates: [node('b', 2), node('c', 4), node('d', 6)] };
    expect(diff(older, newer)).toEqual([
      { path: 'nodeStates[1].released', what: 'changed', was: false, within: 'nodeStates[1].released' },
      { path: 'nodeStates[2]', what: 'added', within: 'nodeStates[2]' },
      { path: 'nodeStates[0]', what: 'removed', was: node('a', 0), within: 'nodeStates' },
    ]);
  });
  it('between indistinguishable entries is determined by index', () => {
    expect(diff([1, 2, 3], [1, 5])).toEqual([
      { path: '[1]', what: 'changed', was: 2, within: '[1]' },
      { path: '[2]', what: 'removed', was: 3, within: '' },
    ]);
    const twice = [{ actionId: 'a', n: 1 }, { actionId: 'a', n: 2 }];
    expect(diff(twice, [{ actionId: 'a', n: 1 }, { actionId: 'a', n: 3 }])).toEqual([{ path: '[1].n', what: 'changed', was: 2, within: '[1].n' }]);
  });
});

describe('a message as lines', () => {
  const text = (value: Parameters<typeof lines_of>[0], apart?: Set<string>) => lines_of(value, apart).map((line) => '  '.repeat(line.depth) + line.tokens.map((token) => token.text).join(''));

  it('keeps short flat values on one line, and is valid JSON when joined', () => {
    const value = { id: 'a', at: { x: 0.25, y: -1 }, list: [], nodes: [{ nodeId: 'n1', actions: [{ actionId: 'p' }] }] };
    expect(text(value)).toEqual(['{', '  "id": "a",', '  "at": {"x": 0.25, "y": -1},', '  "list": [],', '  "nodes": [', '    {', '      "nodeId": "n1",', '      "actions": [', '        {"actionId": "p"}', '      ]', '    }', '  ]', '}']);
    expect(JSON.parse(text(value).join('\n'))).toEqual(value);
  });
  it('expands the parts that contain a highlighted value', () => {
    expect(text({ at: { x: 1, y: 2 } }, new Set(['at.y']))).toEqual(['{', '  "at": {', '    "x": 1,', '    "y": 2', '  }', '}']);
    expect(lines_of({ at: { x: 1, y: 2 } }, new Set(['at.y'])).map((line) => line.path)).toEqual(['', 'at', 'at.x', 'at.y', null, null]);
  });
  it('quotes where required', () => {
    expect(text({ 'a"b': 'line\nbreak' })).toEqual(['{', '  "a\\"b": "line\\nbreak"', '}']);
  });
  it('supports a message that is not an object', () => {
    expect(text('word')).toEqual(['"word"']);
    expect(text(null)).toEqual(['null']);
    expect(text([])).toEqual(['[]']);
  });
});
