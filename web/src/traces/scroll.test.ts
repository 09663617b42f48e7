import { describe, expect, it } from 'vitest';
import { Scroll, tall_max_px } from './scroll';

describe('scrolling', () => {
  it('shows the visible rows and not one more than needed', () => {
    const scroll = new Scroll(1000, 24, 240);
    expect(scroll.rows_at(0)).toEqual({ first: 0, last: 11, shift_px: 0 });
    expect(scroll.rows_at(36)).toEqual({ first: 1, last: 13, shift_px: 12 });
    expect(scroll.rows_at(1e9)).toEqual({ first: 990, last: 1000, shift_px: 0 });
  });
  it('is one to one while the list is short enough for any browser', () => {
    expect(new Scroll(300_000, 24, 240).scale).toBe(1);
  });
  it('reaches the last of a million rows with a scroll bar of bounded length', () => {
    const scroll = new Scroll(1_000_000, 24, 300);
    expect(scroll.bar_px).toBe(tall_max_px);
    const lowest = scroll.bar_px - 300;
    expect(lowest * scroll.scale).toBeCloseTo(scroll.end_px, 3);
    expect(scroll.rows_at(lowest * scroll.scale).last).toBe(1_000_000);
  });
  it('moves only as far as needed to make a row visible', () => {
    const scroll = new Scroll(100, 20, 100);
    expect(scroll.to_show(3, 0)).toBe(0);
    expect(scroll.to_show(5, 0)).toBe(20);
    expect(scroll.to_show(2, 60)).toBe(40);
  });
  it('has nothing to scroll in an empty list', () => {
    const scroll = new Scroll(0, 24, 300);
    expect([scroll.end_px, scroll.scale, scroll.rows_at(50).last]).toEqual([0, 1, 0]);
  });
});
