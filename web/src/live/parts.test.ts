import { describe, expect, it } from 'vitest';
import type { Part } from './contract';
import { failing_parts, failing_words, restarted_words } from './parts';

const part = (change: Partial<Part>): Part => ({ name: 'gvs', state: 'running', restarts: 0, last_error: null, ...change });

describe('parts of the platform', () => {
  it('that do not stay up are listed', () => {
    expect(failing_parts(undefined)).toEqual([]);
    expect(failing_parts([part({}), part({ name: 'plant', state: 'restarting', restarts: 1 })])).toEqual([]);
    expect(failing_parts([part({}), part({ name: 'aiv3', state: 'failing' })]).map(({ name }) => name)).toEqual(['aiv3']);
  });

  it('are described with the reason of their last end and the number of restarts', () => {
    expect(failing_words(part({ state: 'failing', restarts: 12, last_error: 'exit 3' }))).toBe('gvs does not stay up (exit 3); started again 12 times');
    expect(failing_words(part({ state: 'failing', restarts: 1 }))).toBe('gvs does not stay up; started again once');
    expect(restarted_words(part({ restarts: 1, last_error: 'no response; killed (signal 9)' }))).toBe('gvs was started again: no response; killed (signal 9)');
    expect(restarted_words(part({ restarts: 3 }))).toBe('gvs was started again, 3 times so far');
  });
});
