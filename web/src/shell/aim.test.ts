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

  it('hold still while it moves, and go on when it lies there', () => {
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
  it('go on at once when it leaves', () => {
    const aim = new Aim((now) => (held = now));
    aim.move();
    aim.leave();
    expect(held).toBe(false);
    expect(vi.getTimerCount()).toBe(0);
  });
  it('hold still as long as it is pressed, wherever it goes, and until the click has come', () => {
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
