import { describe, expect, it } from 'vitest';
import type { Aiv, Snapshot } from './contract';
import { delay_ms, Motion, turn } from './motion';

function snapshot(time_ms: number, x: number, heading = 0): Snapshot {
  return { time_ms, aivs: [{ id: 'A', x, y: 0, heading } as Aiv] } as unknown as Snapshot;
}
const pose = () => ({ x: NaN, y: NaN, heading: NaN });

describe('motion between snapshots', () => {
  it('runs evenly from one snapshot to the next', () => {
    const motion = new Motion();
    motion.accept(snapshot(1000, 0), 0);
    motion.accept(snapshot(1050, 0.1), 50);
    const out = pose();
    motion.pose_at('A', 25 + delay_ms, out);
    expect(out.x).toBeCloseTo(0.05, 6);
  });

  it('goes on for a moment when a snapshot is late, then stands', () => {
    const motion = new Motion();
    motion.accept(snapshot(1000, 0), 0);
    motion.accept(snapshot(1050, 0.1), 50);
    const soon = pose();
    const late = pose();
    const later = pose();
    motion.pose_at('A', 100 + delay_ms, soon);
    motion.pose_at('A', 1_000, late);
    motion.pose_at('A', 9_000, later);
    expect(soon.x).toBeCloseTo(0.2, 6);
    expect(late.x).toBe(later.x);
    expect(late.x).toBeLessThan(0.5);
  });

  it('turns the short way', () => {
    expect(turn(3, -3)).toBeCloseTo(2 * Math.PI - 6);
    expect(turn(-3, 3)).toBeCloseTo(6 - 2 * Math.PI);
    expect(turn(0, Math.PI)).toBeCloseTo(Math.PI);
  });

  it('does not glide to a place far away', () => {
    const motion = new Motion();
    motion.accept(snapshot(1000, 0), 0);
    motion.accept(snapshot(1050, 2), 50);
    const out = pose();
    motion.pose_at('A', 25 + delay_ms, out);
    expect(out.x).toBe(2);
  });

  it('starts afresh with a server whose clock differs', () => {
    const motion = new Motion();
    motion.accept(snapshot(1000, 0), 0);
    motion.accept(snapshot(500_000, 1), 100);
    const out = pose();
    expect(motion.pose_at('A', 100 + delay_ms, out)).toBe(true);
    expect(out.x).toBe(1);
  });

  it('forgets a vehicle that left, and knows none it never saw', () => {
    const motion = new Motion();
    motion.accept(snapshot(1000, 0), 0);
    motion.accept({ ...snapshot(1050, 0), aivs: [] }, 50);
    expect(motion.pose_at('A', 60, pose())).toBe(false);
    expect(motion.trail('A')).toBeNull();
  });

  it('keeps a short trail', () => {
    const motion = new Motion();
    motion.accept(snapshot(1000, 0), 0);
    for (let i = 0; i < 500; i++) motion.leave_trail('A', { x: i * 0.02, y: 0, heading: 0 });
    const trail = motion.trail('A')!;
    expect(trail.length).toBeLessThan(400);
    expect(trail.at(-2)).toBeCloseTo(499 * 0.02);
  });
});
