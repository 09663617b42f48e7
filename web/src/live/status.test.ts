import { describe, expect, it } from 'vitest';
import { state_key } from './status';

describe('states of AIVs', () => {
  it("are the five words of A7, case-insensitively", () => {
    const words = ['Normal', 'stopped', 'slow speed', 'Medium speed', 'fast speed'];
    expect(words.map((word) => state_key(word, false, 'ONLINE'))).toEqual(['normal', 'stopped', 'slow', 'medium', 'fast']);
  });

  it('are lost when the connection broke, whatever the vehicle reported last', () => {
    expect(state_key('Normal', false, 'CONNECTIONBROKEN')).toBe('lost');
    expect(state_key('Normal', true, 'ONLINE')).toBe('lost');
  });
});
