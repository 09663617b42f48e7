import { describe, expect, it } from 'vitest';
import { FrameDecoder, type PositionFrame } from './frames';
import { sample_frame, type SampleRecord } from './frames_sample';
import { extrapolate_ms_max, Positions, short_turn } from './positions';

let sequence = 0;
function frame(time_ms: number, ...records: SampleRecord[]): PositionFrame {
  const decoder = new FrameDecoder();
  sequence++;
  decoder.take(sample_frame(true, sequence, sequence, time_ms, records));
  return decoder.write()!;
}
const at = (x: number, heading = 0): SampleRecord => ({ handle: 3, x, y: 0, heading });

/** A vehicle at a constant 1 m/s, reported every 33 ms; frame i arrives `late(i)` ms late. */
function drive(positions: Positions, frames: number, late: (i: number) => number, each?: (page_ms: number, x: number) => void) {
  const reports = Array.from({ length: frames }, (_, i) => ({ time_ms: 33 * i, page_ms: 33 * i + late(i) }));
  let next = 0;
  for (let page_ms = 0; page_ms < 33 * frames; page_ms += 16) {
    while (next < frames && reports[next]!.page_ms <= page_ms) positions.accept(frame(reports[next]!.time_ms, at(reports[next++]!.time_ms / 1000)), page_ms);
    if (next === 0) continue;
    positions.sample(page_ms);
    each?.(page_ms, positions.x[0]!);
  }
}

describe('positions between frames', () => {
  it('progress evenly, one frame interval behind', () => {
    const positions = new Positions();
    drive(positions, 60, () => 4, (page_ms, x) => {
      if (page_ms > 300) expect(Math.abs(x - (page_ms - 37) / 1000)).toBeLessThan(0.018);
    });
  });

  it('never go back while the vehicle drives forward, however the frames arrive', () => {
    const positions = new Positions();
    let last = -1;
    drive(positions, 90, (i) => ((i * 7) % 5) * 6, (_, x) => {
      expect(x).toBeGreaterThanOrEqual(last - 1e-6);
      last = x;
    });
  });

  it('progress as evenly with virtual time at four times the speed', () => {
    const positions = new Positions();
    const steps: number[] = [];
    for (let i = 0; i < 60; i++) {
      positions.accept(frame(i * 132, at(i * 0.04)), i * 33);
      positions.sample(i * 33 + 1);
      const x = positions.x[0]!;
      positions.sample(i * 33 + 17);
      if (i > 20) steps.push(positions.x[0]! - x);
    }
    for (const step of steps) expect(step).toBeCloseTo((0.04 * 16) / 33, 2);
  });

  it('are extrapolated briefly when a frame is late, then stop', () => {
    const positions = new Positions();
    for (let i = 0; i < 10; i++) {
      positions.accept(frame(i * 33, at(i * 0.033)), i * 33);
      positions.sample(i * 33);
    }
    positions.sample(330);
    const due = positions.x[0]!;
    positions.sample(330 + extrapolate_ms_max - 20);
    const soon = positions.x[0]!;
    positions.sample(1_000);
    const stopped_x = positions.x[0]!;
    positions.sample(9_000);
    expect(soon).toBeGreaterThan(due + 0.06);
    expect(stopped_x).toBeLessThan(0.297 + 0.102);
    expect(positions.x[0]).toBe(stopped_x);
  });

  it('rotate by the smaller angle', () => {
    const positions = new Positions();
    positions.accept(frame(0, at(0, 3.1)), 0);
    positions.sample(0);
    positions.accept(frame(33, at(0, -3.1)), 33);
    positions.sample(50);
    expect(Math.cos(positions.heading[0]!)).toBeLessThan(-0.99);
    expect(short_turn(3, -3)).toBeCloseTo(2 * Math.PI - 6);
    expect(short_turn(-3, 3)).toBeCloseTo(6 - 2 * Math.PI);
    expect(short_turn(0, Math.PI)).toBeCloseTo(Math.PI);
    expect(short_turn(20 * Math.PI, 1)).toBeCloseTo(1);
  });

  it('are not interpolated to a distant position', () => {
    const positions = new Positions();
    positions.accept(frame(0, at(0)), 0);
    positions.sample(0);
    positions.accept(frame(33, at(2)), 33);
    positions.sample(34);
    expect(positions.x[0]).toBe(2);
    positions.sample(500);
    expect(positions.x[0]).toBe(2);
  });

  it('are not interpolated after the page was suspended', () => {
    const positions = new Positions();
    for (let i = 0; i < 5; i++) positions.accept(frame(i * 33, at(0)), i * 33);
    positions.sample(140);
    positions.accept(frame(60_000, at(0.3)), 60_000);
    positions.sample(60_260);
    expect(positions.x[0]).toBeCloseTo(0.3);
  });
});

describe('the slots', () => {
  it('follow their virtual objects when others appear and disappear', () => {
    const positions = new Positions();
    positions.accept(frame(0, at(0.1), { handle: 9, x: 1, y: 1 }), 0);
    positions.sample(0);
    const before = positions.revision;
    positions.accept(frame(33, { handle: 1, x: 5, y: 5 }, at(0.12), { handle: 9, x: 1, y: 1 }), 33);
    positions.sample(34);
    expect(positions.revision).toBe(before + 1);
    expect([1, 3, 9].map((handle) => positions.slot(handle))).toEqual([0, 1, 2]);
    expect(positions.x[0]).toBe(5);
    expect(positions.x[1]).toBeGreaterThan(0.099);
    expect(positions.x[1]).toBeLessThan(0.13);
    positions.accept(frame(66, { handle: 9, x: 1, y: 1 }), 66);
    expect(positions.slot(3)).toBe(-1);
    expect(positions.slot(9)).toBe(0);
    expect(positions.count).toBe(1);
  });

  it('do not change while the virtual objects are the same', () => {
    const positions = new Positions();
    drive(positions, 5, () => 0);
    expect(positions.revision).toBe(1);
    const { x } = positions;
    positions.accept(frame(9_000, at(0)), 200);
    expect(positions.x).toBe(x);
  });

  it('support large fleets', () => {
    const positions = new Positions();
    const fleet = Array.from({ length: 10_000 }, (_, handle) => ({ handle, x: handle, y: 0 }));
    positions.accept(frame(0, ...fleet), 0);
    positions.sample(1);
    expect(positions.count).toBe(10_000);
    expect(positions.x[9_999]).toBe(9_999);
  });
});

describe('frames out of order', () => {
  it('are ignored, except after a new connection', () => {
    const positions = new Positions();
    const old = frame(0, at(0));
    positions.accept(frame(33, at(0.3)), 0);
    positions.accept(old, 10);
    positions.sample(20);
    expect(positions.x[0]).toBeCloseTo(0.3);
    positions.restart();
    positions.accept(old, 30);
    positions.sample(500);
    expect(positions.x[0]).toBe(0);
  });
});
