import { describe, expect, it } from 'vitest';
import { AlarmBook, causes_of } from './alarms';
import { entries_of, search } from './command_search';
import type { Point, Primitive, Zone, ZoneState } from './contract';
import { nearest_on_line, nearest_on_ways, section_at } from './geometry';
import { empty_sketch, press } from './map_tools';
import { gathered } from './map_zone';
import { mission_note, rows_of } from './reduce';
import { aiv, snapshot } from './table_sample';
import { mission_of } from './table';
import { between } from './view';
import { sorted_out } from './zone_files';
import { switched_text } from './zone_switch';

const road = (label: string, points: Point[]): Primitive => ({ shape: 'polyline', layer: 'road', points, size_m: 0.18, label });
/** A field of n × n short ways, each 1 m from the next. */
function field(n: number): Zone {
  const primitives = Array.from({ length: n * n }, (_, i): Primitive => {
    const x = i % n;
    const y = Math.floor(i / n);
    return road(`w${i}`, [[x, y], [x + 0.5, y], [x + 0.5, y + 0.3]]);
  });
  return { name: 'field', bounds: [0, 0, n, n], vehicle: { length_m: 0.2, width_m: 0.12 }, primitives, sections: [], tags: [], beacons: null };
}

describe('the way under a point', () => {
  const zone = field(20);
  it('is the one that a look at every way finds', () => {
    for (let i = 0; i < 300; i++) {
      const x = ((i * 37) % 211) / 10;
      const y = ((i * 53) % 223) / 10;
      const all = zone.primitives.map((one) => nearest_on_line(one.points, x, y)!.distance);
      expect(nearest_on_ways(zone, x, y)!.distance).toBeCloseTo(Math.min(...all), 12);
    }
  });
  it('is nothing beside all roads', () => {
    expect(section_at(zone, 3.2, 4.05, 0)).toBe('w83');
    expect(section_at(zone, 3.2, 4.5, 0)).toBe(null);
  });
});

describe('a large zone’s picture', () => {
  it('gathers what is painted alike, and loses nothing', () => {
    const zone = field(30);
    const groups = gathered(zone.primitives, zone.bounds);
    expect(groups.length).toBeLessThanOrEqual(144);
    expect(groups.flat().map((one) => one.label).sort()).toEqual(zone.primitives.map((one) => one.label).sort());
  });
  it('leaves a small one as it is', () => {
    const zone = field(4);
    expect(gathered(zone.primitives, zone.bounds)).toEqual(zone.primitives.map((one) => [one]));
  });
  it('keeps one layer below the next', () => {
    const below = field(30).primitives;
    const above = below.map((one): Primitive => ({ ...one, layer: 'line' }));
    const layers = gathered([...below, ...above], [0, 0, 30, 30]).map((group) => group[0]!.layer);
    expect(layers.indexOf('line')).toBe(layers.lastIndexOf('road') + 1);
  });
});

describe('the tool that closes sections', () => {
  it('closes the one under the pointer, and nothing beside', () => {
    const zone = field(3);
    expect(press('close sections', empty_sketch, [1.2, 1.02], null, zone).doing).toEqual({ what: 'close or open', section: 'w4' });
    expect(press('close sections', empty_sketch, [1.2, 1.6], null, zone).doing).toBeUndefined();
    expect(press('close sections', empty_sketch, [0, 0], null, null).doing).toBeUndefined();
  });
});

describe('missions', () => {
  it('are said of who was sent somewhere', () => {
    const sent = (state: 'driving' | 'arrived' | 'no way') => aiv(1, { mission: { kind: 'go', to: 'dock', state } });
    expect([sent('driving'), sent('arrived'), sent('no way')].map(mission_note)).toEqual(['to dock', 'at dock', 'no way to dock']);
    expect(mission_note(aiv(1, { mission: { kind: 'circulate', loop: 'outer', state: 'driving' } }))).toBe('');
    expect(mission_note(aiv(1))).toBe('');
  });
  it('have a column of the table', () => {
    const circling = aiv(1, { mission: { kind: 'circulate', loop: 'outer', state: 'driving' } });
    const parked = aiv(2, { parked: 'stands 0.8 m beside every way' });
    expect(rows_of(snapshot([circling, parked, aiv(3)])).map(mission_of)).toEqual(['circulates on outer', 'parked', '']);
  });
  it('that cannot be followed are abnormal, and so is a parked vehicle', () => {
    expect(causes_of(aiv(1, { mission: { kind: 'go', to: 'dock', state: 'no way', why: 'east is closed' } })).map((one) => one.text)).toEqual(['east is closed']);
    expect(causes_of(aiv(1, { parked: 'it stands 0.8 m beside every way' })).map((one) => one.text)).toEqual(['Parked: it stands 0.8 m beside every way']);
  });
  it('can be given by name', () => {
    const places = { stations: ['dock', 'gate'], loops: ['outer'], sections: ['east', 'west'], closed: ['west'], targets: [] };
    const entries = entries_of([{ id: 'CoSiVA/AIV1', name: 'AIV1', augmented: false }], [], places);
    expect(search(entries, 'send aiv1 to dock')[0]?.doing).toEqual({ kind: 'go', vehicle: 'CoSiVA/AIV1', to: 'dock' });
    expect(search(entries, 'aiv1 circulate outer')[0]?.doing).toEqual({ kind: 'circulate', vehicle: 'CoSiVA/AIV1', loop: 'outer' });
    expect(search(entries, 'close section east')[0]?.text).toBe('Close section east');
    expect(search(entries, 'open section west')[0]?.text).toBe('Open section west');
  });
  it('of a large zone are listed for those that are chosen', () => {
    const stations = Array.from({ length: 300 }, (_, i) => `s${i}`);
    const vehicles = Array.from({ length: 50 }, (_, i) => ({ id: `CoSiVA/AIV${i}`, name: `AIV${i}`, augmented: false }));
    const entries = entries_of(vehicles, [], { stations, loops: [], sections: [], closed: [], targets: ['CoSiVA/AIV7'] });
    expect(new Set(entries.flatMap(({ doing }) => (doing.kind === 'go' ? [doing.vehicle] : [])))).toEqual(new Set(['CoSiVA/AIV7']));
  });
});

describe('a switch to another zone', () => {
  const state = (change: Partial<ZoneState>): ZoneState => ({ name: 'a', revision: 1, closed: [], refused: null, switched: null, ...change });
  it('is said with whom it parked', () => {
    expect(switched_text({ at: 1, from: 'a', first_moving_ms: 431, anchored: 12, parked: ['CoSiVA/AIV7'] })).toBe('12 anchored, 1 parked: AIV7; the first moved after 431\u202fms');
    expect(switched_text({ at: 1, from: 'a', first_moving_ms: null, anchored: 3, parked: [] })).toBe('3 anchored, nobody parked');
  });
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
  it('leads the eye: it begins and ends where it should, and zooms by equal factors', () => {
    const from = { x: 0, y: 0, scale: 100 };
    const to = { x: 4, y: -2, scale: 25 };
    expect(between(from, to, 0)).toEqual({ x: 0, y: 0, scale: expect.closeTo(100, 9) });
    expect(between(from, to, 1).scale).toBeCloseTo(25, 9);
    expect(between(from, to, 0.5)).toEqual({ x: 2, y: -1, scale: expect.closeTo(50, 9) });
    expect(between(from, to, 7)).toEqual(between(from, to, 1));
  });
  it('takes a file and what stands beside it, in any order', () => {
    expect(sorted_out(['a.x'])).toEqual({ zone: 0, companion: null });
    expect(sorted_out(['a.zone.t', 'a.x.y'])).toEqual({ zone: 1, companion: 0 });
    for (const bad of [['a.zone.t'], ['a.x', 'b.x'], ['a.x', 'a.zone.t', 'b.zone.t'], []]) expect(typeof sorted_out(bad)).toBe('string');
  });
});
