// A canvas of the map: its 2D context, and its size in device pixels.
import type { Size } from './view';

export function context_2d(canvas: HTMLCanvasElement, settings?: CanvasRenderingContext2DSettings): CanvasRenderingContext2D {
  const context = canvas.getContext('2d', settings);
  if (!context) throw new Error('this browser has no Canvas2D');
  return context;
}

/** @param size  in CSS pixels */
export function resize_canvas(canvas: HTMLCanvasElement, size: Size, pixel_ratio: number): void {
  canvas.width = Math.max(1, Math.round(size.width * pixel_ratio));
  canvas.height = Math.max(1, Math.round(size.height * pixel_ratio));
}
