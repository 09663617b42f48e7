import { describe, expect, it } from 'vitest';
import { between, fit, pan, scale_bar, scale_max, to_map, to_screen, zoom_at } from './view';

const size = { width: 800, height: 600 };

describe('the view', () => {
  it('shows y up and the centre in the centre', () => {
    const view = { x: 1, y: 2, scale: 100 };
    expect(to_screen(view, size, 1, 2)).toEqual({ px: 400, py: 300 });
    expect(to_screen(view, size, 1, 3)).toEqual({ px: 400, py: 200 });
    expect(to_screen(view, size, 2, 2)).toEqual({ px: 500, py: 300 });
  });

  it('converts to the screen and back to the same map point', () => {
    const view = { x: -0.3, y: 0.7, scale: 251 };
    const { px, py } = to_screen(view, size, 0.123, -0.456);
    const back = to_map(view, size, px, py);
    expect(back.x).toBeCloseTo(0.123, 12);
    expect(back.y).toBeCloseTo(-0.456, 12);
  });

  it('fits the whole zone inside the margins', () => {
    const view = fit([-1.4, -1.4, 1.4, 1.4], size, 20);
    const low = to_screen(view, size, -1.4, -1.4);
    const high = to_screen(view, size, 1.4, 1.4);
    expect(low.py).toBeCloseTo(580, 9);
    expect(high.py).toBeCloseTo(20, 9);
    expect(low.px).toBeGreaterThan(20);
  });

  it('is valid for a zone without extent and a window without size', () => {
    expect(Number.isFinite(fit([0, 0, 0, 0], size).scale)).toBe(true);
    expect(fit([0, 0, 1, 1], { width: 0, height: 0 }).scale).toBeGreaterThan(0);
  });

  it('keeps the point under the cursor while zooming', () => {
    const view = { x: 0, y: 0, scale: 200 };
    const before = to_map(view, size, 650, 120);
    const after = to_map(zoom_at(view, size, 650, 120, 1.7), size, 650, 120);
    expect(after.x).toBeCloseTo(before.x, 12);
    expect(after.y).toBeCloseTo(before.y, 12);
  });

  it('stops zooming at its limit without jumping', () => {
    const view = { x: 0.4, y: 0.4, scale: scale_max };
    const zoomed = zoom_at(view, size, 10, 10, 3);
    expect(zoomed.scale).toBe(scale_max);
    expect(zoomed.x).toBeCloseTo(0.4, 12);
  });

  it('pans with the pointer', () => {
    const view = pan({ x: 0, y: 0, scale: 100 }, 50, 20);
    expect(view.x).toBeCloseTo(-0.5);
    expect(view.y).toBeCloseTo(0.2);
  });

  it('draws a scale bar of a round length', () => {
    expect(scale_bar(250, 120).length_m).toBeCloseTo(0.2);
    expect(scale_bar(100, 120)).toEqual({ length_m: 1, pixels: 100 });
    expect(scale_bar(7, 120).length_m).toBeCloseTo(10);
  });
});

describe('the transition from one view to another', () => {
  it('starts and ends at the given views, and zooms by equal factors', () => {
    const from = { x: 0, y: 0, scale: 100 };
    const to = { x: 4, y: -2, scale: 25 };
    expect(between(from, to, 0)).toEqual({ x: 0, y: 0, scale: expect.closeTo(100, 9) });
    expect(between(from, to, 1).scale).toBeCloseTo(25, 9);
    expect(between(from, to, 0.5)).toEqual({ x: 2, y: -1, scale: expect.closeTo(50, 9) });
    expect(between(from, to, 7)).toEqual(between(from, to, 1));
  });
});
