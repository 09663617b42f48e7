import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Aim, aiming_ms } from './aim';

describe('rows under the pointer', () => {
  let held = false;
  const listeners = new Map<string, Set<() => void>>();
  const release = () => [...(listeners.get('pointerup') ?? [])].forEach((one) => one());
  beforeEach(() => {
    held = false;
    vi.useFakeTimers();
    vi.stubGlobal('window', globalThis);
    vi.stubGlobal('addEventListener', (name: string, on: () => void) => void listeners.set(name, (listeners.get(name) ?? new Set()).add(on)));
    vi.stubGlobal('removeEventListener', (name: string, on: () => void) => void listeners.get(name)?.delete(on));
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it('are fixed while the pointer moves, and updated when it rests', () => {
    const aim = new Aim((now) => (held = now));
    expect(held).toBe(false);
    aim.move();
    vi.advanceTimersByTime(aiming_ms - 1);
    expect(held).toBe(true);
    aim.move();
    vi.advanceTimersByTime(aiming_ms - 1);
    expect(held).toBe(true);
    vi.advanceTimersByTime(1);
    expect(held).toBe(false);
  });
  it('are updated as soon as the pointer leaves', () => {
    const aim = new Aim((now) => (held = now));
    aim.move();
    aim.leave();
    expect(held).toBe(false);
    expect(vi.getTimerCount()).toBe(0);
  });
  it('are fixed while the pointer is pressed, wherever it moves, and until the click', () => {
    const aim = new Aim((now) => (held = now));
    aim.press();
    vi.advanceTimersByTime(60_000);
    aim.leave();
    expect(held).toBe(true);
    release();
    expect(held).toBe(true);
    vi.advanceTimersByTime(aiming_ms);
    expect(held).toBe(false);
    expect([...listeners.values()].every((each) => each.size === 0)).toBe(true);
  });
});
