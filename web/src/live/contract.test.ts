import { describe, expect, it } from 'vitest';
import { parse_live } from './contract';

describe('the live stream', () => {
  it('ignores unknown messages', () => {
    expect(parse_live('nonsense')).toBeNull();
    expect(parse_live('{"type":"other"}')).toBeNull();
    expect(parse_live('{"type":"zone","zone":null}')).toEqual({ type: 'zone', zone: null });
  });
});
