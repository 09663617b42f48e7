import { describe, expect, it } from 'vitest';
import type { Command } from './contract';
import { few_names, reasons_of_stops, unconfirmed_of, unconfirmed_stops, updated, type Stop } from './stops';

const stop = (more: Partial<Command>): Command => ({ id: 'c1', vehicle: 'CoSiVA/AIV1', command: 'stop', state: 'issued', time_ms: 1_000, reason: '', ...more }) as Command;

describe('unconfirmed stops', () => {
  it('are those open for longer than half a second', () => {
    expect(unconfirmed_stops([stop({})], 1_500)).toEqual([]);
    expect(unconfirmed_stops([stop({})], 1_501)).toEqual(['CoSiVA/AIV1']);
    expect(unconfirmed_stops([stop({ state: 'accepted' })], 1_501)).toEqual(['CoSiVA/AIV1']);
  });
  it('are none of those that ended, and none of other commands', () => {
    for (const state of ['materialised', 'failed'] as const) expect(unconfirmed_stops([stop({ state })], 9_000)).toEqual([]);
    expect(unconfirmed_stops([stop({ command: 'slow' })], 9_000)).toEqual([]);
  });
  it('name each vehicle once', () => {
    expect(unconfirmed_stops([stop({}), stop({ id: 'c2', vehicle: 'CoSiVA/AIV2' }), stop({ id: 'c3' })], 9_000)).toEqual(['CoSiVA/AIV1', 'CoSiVA/AIV2']);
  });
});

describe('the Stops of this page', () => {
  const sent = (more: Partial<Stop>): Stop => ({ id: 'S-1', durable: false, reason: 'not yet durable', sent_ms: 1_000, ...more });

  it('are listed until they are durable and confirmed', () => {
    let stops = updated([], sent({}));
    expect(stops.map(({ id }) => id)).toEqual(['S-1']);
    stops = updated(stops, sent({ durable: true, unconfirmed: ['CoSiVA/AIV1'] }));
    expect(stops).toHaveLength(1);
    stops = updated(stops, sent({ durable: false, unconfirmed: [] }));
    expect(stops).toHaveLength(1);
    expect(updated(stops, sent({ durable: true, unconfirmed: [] }))).toEqual([]);
  });
  it('are listed after the first response, which does not name the vehicles', () => {
    expect(updated([], sent({ durable: true }))).toHaveLength(1);
  });
  it('show that they are not yet durable once a disk should have finished', () => {
    expect(reasons_of_stops([sent({})], 1_250)).toEqual([]);
    expect(reasons_of_stops([sent({}), sent({ id: 'S-2' })], 1_251)).toEqual(['not yet durable']);
    expect(reasons_of_stops([sent({ durable: true })], 9_000)).toEqual([]);
    expect(reasons_of_stops([sent({ reason: 'no vehicle is known' })], 9_000)).toEqual(['no vehicle is known']);
  });
  it('name the vehicles that have not confirmed after half a second, each once', () => {
    const open = [sent({ unconfirmed: ['a/b', 'c/d'] }), sent({ id: 'S-2', unconfirmed: ['a/b'] })];
    expect(unconfirmed_of(open, 1_500)).toEqual([]);
    expect(unconfirmed_of(open, 1_501)).toEqual(['a/b', 'c/d']);
  });
});

describe('the text of vehicles', () => {
  const ids = (count: number) => Array.from({ length: count }, (_, i) => `CoSiVA/AIV${i + 1}`);

  it('names a few', () => {
    expect(few_names(ids(2))).toBe('CoSiVA/AIV1, CoSiVA/AIV2');
    expect(few_names(ids(8))).toMatch(/, CoSiVA\/AIV8$/);
    expect(few_names([])).toBe('');
  });
  it('counts the rest of many', () => {
    expect(few_names(ids(9))).toMatch(/, CoSiVA\/AIV8 and 1 more$/);
    expect(few_names(ids(500))).toMatch(/, CoSiVA\/AIV8 and 492 more$/);
  });
});
