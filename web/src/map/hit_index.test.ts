import { describe, expect, it } from 'vitest';
import type { Snapshot, Zone } from '../live/contract';
import { FrameDecoder } from '../live/frames';
import { sample_frame } from '../live/frames_sample';
import { hit_at, label_of, MapIndex, type Field } from './hit_index';
import { Positions } from '../live/positions';

const aiv = (id: string, handle: number, augmented = false) => ({ id, handle, number: handle + 1, augmented, reserved: [[0, 0], [1, 0]] });
const snapshot = {
  aivs: [aiv('CoSiVA/AIV1', 0), aiv('CoSiVA.virtual/V1', 1, true)],
  virtualObjects: [{ id: 'P1', handle: 32768, kind: 'person', radius: 0.06, path: [[0, 0], [1, 0], [1, 1]], repeat: 'loop' }],
  obstacles: [{ id: 'S1', handle: 49152, radius: 0.05 }],
} as unknown as Snapshot;
const zone = {
  vehicle: { length_m: 0.2, width_m: 0.12 },
  primitives: [
    { shape: 'polygon', layer: 'crossing', points: [[4, 4], [5, 4], [5, 5], [4, 5]], size_m: 0, label: 'X1' },
    { shape: 'disc', layer: 'crossing', points: [[7, 7]], size_m: 0.2, label: 'X2' },
  ],
  stations: [{ name: 'dock', kind: 'stop', x: 9, y: 0, section: 'east', s: 3 }],
  tags: [{ number: 3, section: 'east', s: 1, x: 0.05, y: 0 }, { number: 4, section: 'east', s: 2, x: 3, y: 0 }],
} as unknown as Zone;

function field(): Field {
  const decoder = new FrameDecoder();
  decoder.take(
    sample_frame(true, 1, 1, 0, [
      { handle: 0, x: 0, y: 0 },
      { handle: 1, x: 1, y: 0, flags: 4 },
      { handle: 32768, kind: 1, x: 0.2, y: 0 },
      { handle: 49152, kind: 2, x: 2, y: 0 },
    ]),
  );
  const positions = new Positions();
  positions.accept(decoder.write()!, 0);
  positions.sample(1);
  const index = new MapIndex();
  index.accept(snapshot);
  return { positions, index, zone, hidden: new Set(), ground_truth: { vehicles: [], obstacles: [{ id: 'box1', x: 6, y: 0, radius: 0.05 }] } };
}
const at = (given: Field, x: number, y: number, prefer_tags = false) => {
  const hit = hit_at(given, x, y, 0.02, prefer_tags);
  return hit && `${hit.kind} ${hit.id}`;
};

describe('the object under a point', () => {
  it('is a station, on the ground', () => {
    expect(at(field(), 9.03, 0.02)).toBe('station dock');
    expect(at({ ...field(), hidden: new Set(['station']) }, 9.03, 0.02)).toBe(null);
  });

  it('is the nearest body, before objects on the ground', () => {
    expect(at(field(), 0.03, 0)).toBe('aiv CoSiVA/AIV1');
    expect(at(field(), 0.19, 0)).toBe('person P1');
    expect(at(field(), 2.04, 0)).toBe('detected S1');
  });

  it('is the tag while tags are edited', () => {
    expect(at(field(), 0.05, 0, true)).toBe('tag 3');
    expect(at(field(), 3.01, 0)).toBe('tag 4');
  });

  it('is a physical obstacle, a crossing of either shape, or nothing', () => {
    expect(at(field(), 6.04, 0)).toBe('plant box1');
    expect(at(field(), 4.5, 4.5)).toBe('crossing X1');
    expect(at(field(), 7.1, 7)).toBe('crossing X2');
    expect(at(field(), 9, 9)).toBeNull();
  });

  it('is not an object of a hidden layer', () => {
    const hidden = new Set(['persons', 'obstacles', 'tag', 'crossing']);
    for (const [x, y] of [[0.31, 0], [2, 0], [3, 0], [6, 0], [4.5, 4.5]] as const) expect(at({ ...field(), hidden }, x, y)).toBeNull();
  });

  it('can be moved if it is virtual', () => {
    const given = field();
    expect(hit_at(given, 0, 0, 0)?.movable).toBe(false);
    expect(hit_at(given, 1, 0, 0)?.movable).toBe(true);
    expect(hit_at(given, 0.2, 0, 0)?.movable).toBe(true);
    expect(hit_at(given, 2, 0, 0)?.movable).toBe(false);
  });
});

describe('the index', () => {
  it('finds handles by id, and radii by handle', () => {
    const { index } = field();
    expect(index.handle('P1')).toBe(32768);
    expect(index.handle('CoSiVA.virtual/V1')).toBe(1);
    expect([index.handle('unknown'), index.handle(null)]).toEqual([-1, -1]);
    expect(index.radius(49152)).toBe(0.05);
  });

  it('closes the path of a person that walks in a loop', () => {
    const entry = field().index.by_id.get('P1');
    expect(entry?.kind === 'person' && [...entry.path!]).toEqual([0, 0, 1, 0, 1, 1, 0, 0]);
  });

  it('keeps an entry while its vehicle exists, and removes it with the vehicle', () => {
    const index = new MapIndex();
    index.accept(snapshot);
    const before = index.by_id.get('CoSiVA/AIV1');
    index.accept({ ...snapshot, aivs: [snapshot.aivs[0]!] });
    expect(index.by_id.get('CoSiVA/AIV1')).toBe(before);
    expect(index.by_id.has('CoSiVA.virtual/V1')).toBe(false);
    expect(index.by_handle.has(1)).toBe(false);
  });

  it('distinguishes virtual AIVs from physical ones of the same number', () => {
    expect(snapshot.aivs.map(label_of)).toEqual(['1', 'V1']);
  });
});
