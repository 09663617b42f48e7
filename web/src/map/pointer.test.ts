import { beforeEach, describe, expect, it } from 'vitest';
import { Gestures } from './pointer';

let calls: string[];
let holds = false;
const round = (value: number) => Math.round(value * 100) / 100;
const bench = () =>
  new Gestures({
    take: () => holds,
    drag: ({ px, py }) => calls.push(`drag ${px},${py}`),
    drop: ({ px, py }, cancelled) => calls.push(cancelled ? 'back' : `drop ${px},${py}`),
    pan: (dx, dy) => calls.push(`pan ${dx},${dy}`),
    pinch: (_, factor) => calls.push(`pinch ${round(factor)}`),
    press: ({ px, py }) => calls.push(`press ${px},${py}`),
  });
const at = (px: number, py: number) => ({ px, py });

beforeEach(() => {
  calls = [];
  holds = false;
});

describe('one pointer', () => {
  it('presses, even with slight movements', () => {
    const gestures = bench();
    gestures.down(1, at(10, 10));
    gestures.move(1, at(12, 11));
    gestures.up(1, at(12, 11), false);
    expect(calls).toEqual(['press 12,11']);
  });

  it('drags the map without a press', () => {
    const gestures = bench();
    gestures.down(1, at(10, 10));
    gestures.move(1, at(20, 10));
    gestures.move(1, at(10, 10));
    gestures.up(1, at(10, 10), false);
    expect(calls).toEqual(['pan 10,0', 'pan -10,0']);
  });

  it('drags the object that it holds, and drops it', () => {
    holds = true;
    const gestures = bench();
    gestures.down(1, at(10, 10));
    gestures.move(1, at(30, 10));
    expect(gestures.dragging).toBe(true);
    gestures.up(1, at(30, 12), false);
    expect(calls).toEqual(['drag 30,10', 'drop 30,12']);
  });

  it('restores everything when the drag is cancelled', () => {
    holds = true;
    const gestures = bench();
    gestures.down(1, at(10, 10));
    gestures.move(1, at(30, 10));
    gestures.cancel();
    gestures.up(1, at(30, 10), false);
    expect(calls).toEqual(['drag 30,10', 'back']);
  });

  it('presses the object that it holds if it does not move', () => {
    holds = true;
    const gestures = bench();
    gestures.down(1, at(10, 10));
    gestures.up(1, at(10, 10), false);
    expect(calls).toEqual(['press 10,10']);
  });

  it('has no effect after a cancellation', () => {
    const gestures = bench();
    gestures.down(1, at(1, 1));
    gestures.up(1, at(1, 1), true);
    gestures.up(2, at(1, 1), false);
    expect(calls).toEqual([]);
  });
});

describe('two pointers', () => {
  it('zoom and move the map', () => {
    const gestures = bench();
    gestures.down(1, at(0, 0));
    gestures.down(2, at(100, 0));
    gestures.move(2, at(200, 0));
    gestures.up(2, at(200, 0), false);
    gestures.up(1, at(0, 0), false);
    expect(calls).toEqual(['pinch 2', 'pan 50,0']);
  });

  it('restore what the first one dragged', () => {
    holds = true;
    const gestures = bench();
    gestures.down(1, at(0, 0));
    gestures.move(1, at(10, 0));
    gestures.down(2, at(100, 0));
    expect(calls).toEqual(['drag 10,0', 'back']);
  });
});
