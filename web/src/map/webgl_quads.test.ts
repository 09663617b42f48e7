import { beforeEach, describe, expect, it } from 'vitest';
import { FrameDecoder } from '../live/frames';
import { sample_frame, type SampleRecord } from '../live/frames_sample';
import { Positions } from '../live/positions';
import type { Colours } from './renderer';
import { Quads, words_per_quad, words_per_vertex } from './webgl_quads';

class Open extends Quads {
  set(width: number, height: number, ratio: number): void {
    this.size = { width, height };
    this.ratio = ratio;
  }
  get counts() {
    return { quads: this.quads, from: this.bodies_from, to: this.bodies_to, spots: this.spots };
  }
  corner(quad: number, corner: number) {
    const at = quad * words_per_quad + corner * words_per_vertex;
    const [px, py, along, across] = this.floats.subarray(at, at + 4);
    return { px: px!, py: py!, along: along!, across: across!, style: this.words[at + 6]!, tint: this.words[at + 7]! };
  }
}

const colours = { states: ['#010000', '#020000', '#030000', '#040000', '#050000', '#060000'], person: '#aa0000', obstacle: '#bb0000', virtual: '#cc0000', ground: '#ffffff' } as unknown as Colours;
const body = { half_length: 20, half_width: 12, shape_behind: 5, shape_radius: 3 };
const show = { persons: true, obstacles: true };

function positions(...records: SampleRecord[]): Positions {
  const decoder = new FrameDecoder();
  decoder.take(sample_frame(true, 1, 1, 0, records));
  const made = new Positions();
  made.accept(decoder.write()!, 0);
  made.sample(1);
  return made;
}

let quads: Open;
beforeEach(() => {
  quads = new Open();
  quads.set(800, 600, 2);
  quads.set_colours(colours);
  quads.begin({ x: 0, y: 0, scale: 100 }, body, false);
});

describe('vehicles', () => {
  it('are one quad each, in device pixels, y down, in the colour of their state', () => {
    quads.bodies(positions({ handle: 0, x: 1, y: 1, status: 2 }), show, () => 0.1);
    expect(quads.counts).toMatchObject({ quads: 1, from: 0, to: 1, spots: 0 });
    // The centre is 100 px right of and above the centre of the screen, at two device pixels each.
    expect(quads.corner(0, 0)).toMatchObject({ px: 1000 - 41, py: 400 - 25, tint: 3 });
    expect(quads.corner(0, 2)).toMatchObject({ px: 1000 + 41, py: 400 + 25 });
    expect(quads.corner(0, 0).style & 0xff).toBe(2);
  });

  it('heading up the map point up on the screen', () => {
    quads.bodies(positions({ handle: 0, x: 0, y: 0, heading: Math.PI / 2 }), show, () => 0.1);
    const front = quads.corner(0, 1);
    expect(front.along).toBeGreaterThan(0);
    expect(front.py).toBeLessThan(600 - 40);
  });

  it('outside the view cost nothing', () => {
    quads.bodies(positions({ handle: 0, x: 50, y: 0 }, { handle: 1, x: 0, y: -50 }, { handle: 2, x: 0, y: 0 }), show, () => 0.1);
    expect(quads.counts.quads).toBe(1);
  });

  it('that are tiny are one triangle each', () => {
    quads.begin({ x: 0, y: 0, scale: 1 }, { half_length: 3, half_width: 1.6, shape_behind: 0, shape_radius: 0 }, false);
    quads.bodies(positions(...Array.from({ length: 5 }, (_, handle) => ({ handle, x: handle, y: 0 }))), show, () => 0.1);
    expect(quads.counts).toEqual({ quads: 4, from: 0, to: 4, spots: 5 });
  });

  it('are supported by the thousand', () => {
    quads.bodies(positions(...Array.from({ length: 9_000 }, (_, handle) => ({ handle, x: 0, y: 0 }))), show, () => 0.1);
    expect(quads.counts.quads).toBe(9_000);
    expect(quads.corner(8_999, 0).tint).toBe(1);
  });

  it('are drawn above the bands and below the persons', () => {
    quads.band([0, 0, 1, 0], 2, 0.1, 1, '#000000', 1);
    quads.bodies(positions({ handle: 0, x: 0, y: 0 }, { handle: 1, kind: 1, flags: 4, x: 0, y: 0 }), show, () => 0.1);
    expect(quads.counts).toMatchObject({ from: 1, to: 2 });
    expect(quads.corner(2, 0).tint).toBe(0xcc);
    expect(quads.corner(3, 0).tint).toBe(0xaa);
  });
});

describe('a hidden layer', () => {
  it('is not drawn', () => {
    const both = positions({ handle: 1, kind: 1, x: 0, y: 0 }, { handle: 2, kind: 2, x: 0, y: 0 });
    quads.bodies(both, { persons: false, obstacles: false }, () => 0.1);
    expect(quads.counts.quads).toBe(0);
  });
});

describe('a band', () => {
  it('has neither gap nor overlap at a bend', () => {
    quads.band([0, 0, 1, 0, 1, 1], 3, 0.2, 1, '#000000', 0.5);
    expect(quads.counts.quads).toBe(2);
    const rounded = ({ px, py }: { px: number; py: number }) => [Math.round(px), Math.round(py)];
    expect(rounded(quads.corner(0, 1))).toEqual(rounded(quads.corner(1, 0)));
    expect(rounded(quads.corner(0, 2))).toEqual(rounded(quads.corner(1, 3)));
  });

  it('skips coincident points, and is empty with fewer than two', () => {
    quads.band([0, 0, 0, 0, 1, 0], 3, 0.2, 1, '#000000', 1);
    expect(quads.counts.quads).toBe(1);
    quads.band([0, 0], 1, 0.2, 1, '#000000', 1);
    quads.band([], 0, 0.2, 1, '#000000', 1);
    expect(quads.counts.quads).toBe(1);
  });
});
