import { describe, expect, it } from 'vitest';
import { entries_of, score_of, search } from './search';

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
    expect(search(entries, 'stop aiv2')[0]?.doing).toEqual({ kind: 'command', command: 'stop', vehicles: ['CoSiVA/AIV2'] });
  });
  it('finds a command by a few letters', () => {
    expect(first('stopall')).toBe('Stop all AIVs');
    expect(first('staiv2')).toBe('Stop AIV2');
    expect(first('st a2')).toBe('Stop AIV2');
    expect(first('followv1')).toBe('Follow V1');
  });
  it('offers removal of virtual objects only', () => {
    expect(first('remove v1')).toBe('Remove V1');
    expect(first('remove p1')).toBe('Remove P1');
    expect(entries.some((entry) => entry.text === 'Remove AIV1')).toBe(false);
  });
  it('offers to exclude physical vehicles, to include excluded ones, and to retire absent ones', () => {
    const presence = entries_of([...vehicles, { id: 'ACME/7', name: '7', augmented: false, excluded: true, absent: 'it has signed off (OFFLINE)' }], []).map((entry) => entry.text).filter((text) => /^(Exclude|Include|Retire)/.test(text));
    expect(presence).toEqual(['Exclude AIV1', 'Exclude AIV2', 'Include 7', 'Retire 7']);
  });
  it('shows the first commands without input, and none without a match', () => {
    expect(search(entries, '')[0]?.text).toBe('Stop all AIVs');
    expect(search(entries, 'qqqq')).toEqual([]);
  });
  it('prefers adjacent letters', () => expect(score_of('Stop AIV1', 'stop')!).toBeGreaterThan(score_of('Show the whole topic', 'stop') ?? -Infinity));
  it('has unique keys', () => expect(new Set(entries.map((entry) => entry.key)).size).toBe(entries.length));
  it('is fast with a thousand vehicles', () => {
    const many = entries_of(Array.from({ length: 1_000 }, (_, i) => ({ id: `CoSiVA/AIV${i}`, name: `AIV${i}`, augmented: false })), []);
    expect(search(many, 'restart aiv777')[0]?.text).toBe('Restart AIV777');
  });
});

describe('missions in the list of commands', () => {
  it('can be given by name', () => {
    const zone_items = { stations: ['dock', 'gate'], loops: ['outer'], sections: ['east', 'west'], closed: ['west'], targets: [] };
    const entries = entries_of([{ id: 'CoSiVA/AIV1', name: 'AIV1', augmented: false }], [], zone_items);
    expect(search(entries, 'send aiv1 to dock')[0]?.doing).toEqual({ kind: 'go', vehicle: 'CoSiVA/AIV1', to: 'dock' });
    expect(search(entries, 'aiv1 circulate outer')[0]?.doing).toEqual({ kind: 'circulate', vehicle: 'CoSiVA/AIV1', loop: 'outer' });
    expect(search(entries, 'close section east')[0]?.text).toBe('Close section east');
    expect(search(entries, 'open section west')[0]?.text).toBe('Open section west');
  });
  it('of a large zone are listed for the chosen vehicles', () => {
    const stations = Array.from({ length: 300 }, (_, i) => `s${i}`);
    const vehicles = Array.from({ length: 50 }, (_, i) => ({ id: `CoSiVA/AIV${i}`, name: `AIV${i}`, augmented: false }));
    const entries = entries_of(vehicles, [], { stations, loops: [], sections: [], closed: [], targets: ['CoSiVA/AIV7'] });
    expect(new Set(entries.flatMap(({ doing }) => (doing.kind === 'go' ? [doing.vehicle] : [])))).toEqual(new Set(['CoSiVA/AIV7']));
  });
});
