import { describe, expect, it } from 'vitest';
import { bindings, key_action, key_of, type KeyPress } from './keys';

const press = (key: string, change: Partial<KeyPress> = {}): KeyPress => ({
  key, shiftKey: false, ctrlKey: false, altKey: false, metaKey: false, repeat: false, target: null, ...change,
});
const button = { tagName: 'BUTTON', getAttribute: () => null } as unknown as EventTarget;
const typing = { tagName: 'TEXTAREA' } as unknown as EventTarget;

describe('keys', () => {
  it('stop all from anywhere, even while typing', () => {
    expect(key_action(press('Escape', { shiftKey: true }))).toBe('stop all');
    expect(key_action(press('Escape', { shiftKey: true, target: typing }))).toBe('stop all');
  });

  it('send one stop, however long the key is held', () => {
    expect(key_action(press('Escape', { shiftKey: true, repeat: true }))).toBeNull();
    expect(key_action(press('s', { repeat: true }))).toBeNull();
  });

  it("leave the browser's own shortcuts and typed text alone", () => {
    expect(key_action(press('s', { ctrlKey: true }))).toBeNull();
    expect(key_action(press('s', { target: typing }))).toBeNull();
    expect(key_action(press('s'))).toBe('stop selected');
  });

  it('let Space press the button that has the focus', () => {
    expect(key_action(press(' '))).toBe('play');
    expect(key_action(press(' ', { target: button }))).toBeNull();
  });

  it('open the list of commands with Ctrl K, also while typing, and select with k alone', () => {
    expect(key_action(press('k', { ctrlKey: true, target: typing }))).toBe('palette');
    expect(key_action(press('K', { metaKey: true }))).toBe('palette');
    expect(key_action(press('k'))).toBe('previous');
    expect(key_action(press('k', { target: typing }))).toBeNull();
  });

  it('can be switched off where a single character acts alone', () => {
    for (const key of ['s', 'j', '/', ' ', '1', '?', '+']) expect(key_action(press(key), false)).toBeNull();
    expect(key_action(press('Home'), false)).toBe('fit');
    expect(key_action(press('Escape'), false)).toBe('close');
    expect(key_action(press('Escape', { shiftKey: true }), false)).toBe('stop all');
    expect(key_action(press('k', { ctrlKey: true }), false)).toBe('palette');
  });

  it('fill the page with each frame by its number', () => {
    expect(['1', '2', '3', '4'].map((key) => key_action(press(key)))).toEqual(['frame 1', 'frame 2', 'frame 3', 'frame 4']);
  });

  it('repeat where motion is asked for, and only there', () => {
    expect(key_action(press('ArrowLeft', { repeat: true }))).toBe('left');
    expect(key_action(press('1', { repeat: true }))).toBeNull();
  });

  it('mean one virtual object each', () => {
    const seen = bindings.flatMap((one) => one.keys.map((key) => `${one.ctrl ? 'ctrl ' : ''}${one.shift ? 'shift ' : ''}${key}`));
    expect(new Set(seen).size).toBe(seen.length);
  });

  it('are printed as the caps say', () => {
    expect(key_of('stop all')).toBe('Shift Esc');
    expect(key_of('play')).toBe('Space');
    expect(key_of('follow')).toBe('f');
  });

  it('do nothing when unknown', () => expect(key_action(press('q'))).toBeNull());
});
