// Pointer gestures on the map, without the DOM: one pointer drags the map or an object, two pinch, and a pointer that does not
// move presses.
import type { Pixel } from './view';

/** Movement below this still counts as a press [px]. */
export const tremble_px = 4;

export interface Deeds {
  /** Whether a drag from this pixel moves an object instead of the map. */
  take(at: Pixel): boolean;
  drag(at: Pixel): void;
  drop(at: Pixel, cancelled: boolean): void;
  pan(dx: number, dy: number): void;
  pinch(at: Pixel, factor: number): void;
  press(at: Pixel): void;
}

interface Held {
  from: Pixel;
  last: Pixel;
}

export class Gestures {
  private readonly held = new Map<number, Held>();
  private moved = false;
  private taken = false;

  constructor(private readonly deeds: Deeds) {}

  get busy(): boolean {
    return this.held.size > 0;
  }
  get dragging(): boolean {
    return this.taken && this.moved;
  }

  down(id: number, at: Pixel): void {
    // A second finger always pinches the map, even if the first one dragged an object.
    if (this.held.size > 0 && this.taken) this.deeds.drop(at, true);
    this.taken = this.held.size === 0 && this.deeds.take(at);
    if (this.held.size === 0) this.moved = false;
    this.held.set(id, { from: at, last: at });
  }

  move(id: number, at: Pixel): void {
    const held = this.held.get(id);
    if (!held) return;
    const { from, last } = held;
    held.last = at;
    if (Math.hypot(at.px - from.px, at.py - from.py) > tremble_px) this.moved = true;
    if (!this.moved) return;
    if (this.taken) return this.deeds.drag(at);
    const other = [...this.held].find(([key]) => key !== id)?.[1].last;
    if (other) {
      const spread = (p: Pixel) => Math.max(1, Math.hypot(p.px - other.px, p.py - other.py));
      this.deeds.pinch({ px: (at.px + other.px) / 2, py: (at.py + other.py) / 2 }, spread(at) / spread(last));
    }
    this.deeds.pan((at.px - last.px) / this.held.size, (at.py - last.py) / this.held.size);
  }

  up(id: number, at: Pixel, cancelled: boolean): void {
    if (!this.held.delete(id)) return;
    const { taken } = this;
    if (this.held.size > 0) return;
    this.taken = false;
    if (taken && this.moved) this.deeds.drop(at, cancelled);
    else if (!this.moved && !cancelled) this.deeds.press(at);
  }

  /** Cancels a drag (Escape) without moving anything. */
  cancel(): void {
    if (this.taken) this.deeds.drop({ px: 0, py: 0 }, true);
    this.taken = false;
    this.held.clear();
  }
}
