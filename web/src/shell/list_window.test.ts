import { describe, expect, it } from 'vitest';
import { scroll_to_show, window_of } from './list_window';

describe('a long list', () => {
  it('is complete while it is short', () => expect(window_of(500, 300, 30, 100)).toEqual({ first: 0, last: 100, before_px: 0, after_px: 0 }));
  it('contains only the visible rows, and keeps its height', () => {
    const visible = window_of(30_000, 300, 30, 10_000);
    expect(visible.last - visible.first).toBeLessThan(30);
    expect(visible.first).toBeLessThanOrEqual(1_000);
    expect(visible.before_px + (visible.last - visible.first) * 30 + visible.after_px).toBe(300_000);
  });
  it('ends at its end, also when it has just become shorter', () => {
    expect(window_of(1e9, 300, 30, 200).last).toBe(200);
    expect(window_of(1e9, 300, 30, 200).first).toBeLessThan(200);
  });
  it('scrolls no further than necessary', () => {
    expect(scroll_to_show(5, 0, 300, 30)).toBe(0);
    expect(scroll_to_show(20, 0, 300, 30)).toBe(330);
    expect(scroll_to_show(2, 330, 300, 30)).toBe(60);
  });
});
