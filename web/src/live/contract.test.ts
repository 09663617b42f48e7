import { describe, expect, it } from 'vitest';
import { parse_live } from './contract';

describe('the live stream', () => {
  it('skips what it does not know', () => {
    expect(parse_live('nonsense')).toBeNull();
    expect(parse_live('{"type":"other"}')).toBeNull();
    expect(parse_live('{"type":"zone","zone":null}')).toEqual({ type: 'zone', zone: null });
  });
});
