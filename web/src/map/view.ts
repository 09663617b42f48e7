// The transformation between the map (metres, y up) and the screen (CSS pixels, y down).

export interface View {
  /** map point at the centre of the screen [m] */
  x: number;
  y: number;
  /** pixels per metre */
  scale: number;
}

export interface Size {
  width: number;
  height: number;
}

export interface Pixel {
  px: number;
  py: number;
}

export const scale_min = 0.2;
export const scale_max = 20_000;

export function to_screen(view: View, size: Size, x: number, y: number): Pixel {
  return { px: size.width / 2 + (x - view.x) * view.scale, py: size.height / 2 - (y - view.y) * view.scale };
}

export function to_map(view: View, size: Size, px: number, py: number): { x: number; y: number } {
  return { x: view.x + (px - size.width / 2) / view.scale, y: view.y - (py - size.height / 2) / view.scale };
}

/** The view that shows all of `bounds` with a margin [px]. */
export function fit(bounds: readonly [number, number, number, number], size: Size, margin = 28): View {
  const [x0, y0, x1, y1] = bounds;
  const width = Math.max(x1 - x0, 1e-3);
  const height = Math.max(y1 - y0, 1e-3);
  const scale = Math.min((size.width - 2 * margin) / width, (size.height - 2 * margin) / height);
  return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale: clamp_scale(scale) };
}

/** Zooms by `factor` around the cursor. */
export function zoom_at(view: View, size: Size, px: number, py: number, factor: number): View {
  const scale = clamp_scale(view.scale * factor);
  const under = to_map(view, size, px, py);
  return {
    x: under.x - (px - size.width / 2) / scale,
    y: under.y + (py - size.height / 2) / scale,
    scale,
  };
}

/** Pans the map by (dx, dy) pixels. */
export function pan(view: View, dx: number, dy: number): View {
  return { ...view, x: view.x - dx / view.scale, y: view.y + dy / view.scale };
}

/** Interpolates between two views at `ratio` 0…1, with easing at both ends and a geometric scale. */
export function between(from: View, to: View, ratio: number): View {
  const t = Math.min(1, Math.max(0, ratio));
  const eased = t * t * (3 - 2 * t);
  const mix = (a: number, b: number) => a + (b - a) * eased;
  return { x: mix(from.x, to.x), y: mix(from.y, to.y), scale: Math.exp(mix(Math.log(from.scale), Math.log(to.scale))) };
}

function clamp_scale(scale: number): number {
  return Math.min(scale_max, Math.max(scale_min, scale));
}

/** The greatest length of 1, 2 or 5 times a power of ten whose bar is at most `pixels_max` wide. */
export function scale_bar(scale: number, pixels_max: number): { length_m: number; pixels: number } {
  const longest = pixels_max / scale;
  const decade = 10 ** Math.floor(Math.log10(longest));
  const step = [5, 2, 1].find((n) => n * decade <= longest) ?? 1;
  return { length_m: step * decade, pixels: step * decade * scale };
}
