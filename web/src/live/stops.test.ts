import { describe, expect, it } from 'vitest';
import type { Command } from './contract';
import { unconfirmed_stops } from './stops';

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
