import { describe, expect, it } from 'vitest';
import { sorted_out } from './zone_files';

describe('the files of a zone', () => {
  it('accepts a file and its sidecar file, in any order', () => {
    expect(sorted_out(['a.x'])).toEqual({ zone: 0, sidecar: null });
    expect(sorted_out(['a.zone.t', 'a.x.y'])).toEqual({ zone: 1, sidecar: 0 });
    for (const bad of [['a.zone.t'], ['a.x', 'b.x'], ['a.x', 'a.zone.t', 'b.zone.t'], []]) expect(typeof sorted_out(bad)).toBe('string');
  });
});
