import { describe, expect, it } from 'vitest';
import { link_after, type Link } from './link_state';

describe('the link', () => {
  const at = (kind: 'opened' | 'frame' | 'closed' | 'tick', at_ms: number, last_frame_ms = 0) => ({ kind, at_ms, last_frame_ms });
  const start: Link = { phase: 'connecting', since_ms: 0 };

  it('is live with the first frame, not with the open socket', () => {
    const opened = link_after(start, at('opened', 10));
    expect(opened.phase).toBe('connecting');
    expect(link_after(opened, at('frame', 20)).phase).toBe('live');
  });

  it('detects a server that hangs without closing', () => {
    const live: Link = { phase: 'live', since_ms: 0 };
    expect(link_after(live, at('tick', 1_900, 1_000)).phase).toBe('live');
    expect(link_after(live, at('tick', 2_100, 1_000))).toEqual({ phase: 'unresponsive', since_ms: 1_000 });
  });

  it('measures the loss from its start, over all attempts', () => {
    let link = link_after({ phase: 'live', since_ms: 0 }, at('closed', 5_000));
    link = link_after(link, at('opened', 6_000));
    link = link_after(link, at('closed', 6_500));
    expect(link.phase).toBe('down');
    expect(link.since_ms).toBeLessThanOrEqual(6_500);
    expect(link_after(link, at('frame', 7_000))).toEqual({ phase: 'live', since_ms: 7_000 });
  });
});
