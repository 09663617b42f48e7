import { describe, expect, it } from 'vitest';
import { FrameDecoder } from '../live/frames';
import { sample_frame } from '../live/frames_sample';
import { Trails, trails_max } from './trails';
import { Positions } from '../live/positions';

let sequence = 0;
function show(positions: Positions, records: { handle: number; x: number; kind?: number }[]): void {
  const decoder = new FrameDecoder();
  sequence++;
  decoder.take(sample_frame(true, sequence, sequence, sequence, records.map((record) => ({ y: 0, ...record }))));
  positions.accept(decoder.write()!, 1e6 * sequence);
  positions.sample(1e6 * sequence + 1e5);
}

describe('trails', () => {
  it('are short, and end at the vehicle', () => {
    const positions = new Positions();
    const trails = new Trails();
    for (let i = 0; i < 300; i++) {
      show(positions, [{ handle: 5, x: 0.02 * i }]);
      trails.leave(positions, -1);
    }
    const trail = trails.get(5)!;
    expect(trail.count).toBeLessThanOrEqual(90);
    expect(trail.points[2 * trail.count - 2]).toBeCloseTo(299 * 0.02);
  });

  it('do not grow while a vehicle is stopped, and restart after a relocation', () => {
    const positions = new Positions();
    const trails = new Trails();
    for (const x of [0, 0.001, 0.02, 3]) {
      show(positions, [{ handle: 5, x }]);
      trails.leave(positions, -1);
    }
    expect(trails.get(5)!.count).toBe(1);
  });

  it('end with their vehicle, and persons have none', () => {
    const positions = new Positions();
    const trails = new Trails();
    show(positions, [{ handle: 5, x: 0 }, { handle: 6, x: 0, kind: 1 }]);
    trails.leave(positions, -1);
    expect(trails.get(6)).toBeUndefined();
    show(positions, [{ handle: 6, x: 0, kind: 1 }]);
    trails.leave(positions, -1);
    expect(trails.get(5)).toBeUndefined();
  });

  it('of large fleets are stored for the chosen vehicle only', () => {
    const positions = new Positions();
    const trails = new Trails();
    show(positions, Array.from({ length: trails_max + 1 }, (_, handle) => ({ handle, x: handle })));
    trails.leave(positions, 7);
    expect([...trails.entries()].map(([handle]) => handle)).toEqual([7]);
  });
});
