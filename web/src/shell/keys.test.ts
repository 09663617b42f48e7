import { describe, expect, it } from 'vitest';
import { bindings, key_action, key_of, type KeyPress } from './keys';

const press = (key: string, change: Partial<KeyPress> = {}): KeyPress => ({
  key, shiftKey: false, ctrlKey: false, altKey: false, metaKey: false, repeat: false, target: null, ...change,
});
const button = { tagName: 'BUTTON', getAttribute: () => null } as unknown as EventTarget;
const typing = { tagName: 'TEXTAREA' } as unknown as EventTarget;

describe('keys', () => {
  it('stop all from anywhere, even during text input', () => {
    expect(key_action(press('Escape', { shiftKey: true }))).toBe('stop all');
    expect(key_action(press('Escape', { shiftKey: true, target: typing }))).toBe('stop all');
  });

  it('send one stop, however long the key is held', () => {
    expect(key_action(press('Escape', { shiftKey: true, repeat: true }))).toBeNull();
    expect(key_action(press('s', { repeat: true }))).toBeNull();
  });

  it("do not affect shortcuts of the browser and text input", () => {
    expect(key_action(press('s', { ctrlKey: true }))).toBeNull();
    expect(key_action(press('s', { target: typing }))).toBeNull();
    expect(key_action(press('s'))).toBe('stop selected');
  });

  it('let Space press the focused button', () => {
    expect(key_action(press(' '))).toBe('play');
    expect(key_action(press(' ', { target: button }))).toBeNull();
  });

  it('open the list of commands with Ctrl K, also during text input, and select with k alone', () => {
    expect(key_action(press('k', { ctrlKey: true, target: typing }))).toBe('palette');
    expect(key_action(press('K', { metaKey: true }))).toBe('palette');
    expect(key_action(press('k'))).toBe('previous');
    expect(key_action(press('k', { target: typing }))).toBeNull();
  });

  it('can be disabled where a single character acts alone', () => {
    for (const key of ['s', 'j', '/', ' ', '1', '?', '+']) expect(key_action(press(key), false)).toBeNull();
    expect(key_action(press('Home'), false)).toBe('fit');
    expect(key_action(press('Escape'), false)).toBe('close');
    expect(key_action(press('Escape', { shiftKey: true }), false)).toBe('stop all');
    expect(key_action(press('k', { ctrlKey: true }), false)).toBe('palette');
  });

  it('maximise each frame by its number', () => {
    expect(['1', '2', '3', '4'].map((key) => key_action(press(key)))).toEqual(['frame 1', 'frame 2', 'frame 3', 'frame 4']);
  });

  it('repeat for motion only', () => {
    expect(key_action(press('ArrowLeft', { repeat: true }))).toBe('left');
    expect(key_action(press('1', { repeat: true }))).toBeNull();
  });

  it('select one virtual object each', () => {
    const bound = bindings.flatMap((one) => one.keys.map((key) => `${one.ctrl ? 'ctrl ' : ''}${one.shift ? 'shift ' : ''}${key}`));
    expect(new Set(bound).size).toBe(bound.length);
  });

  it('are shown as their caps are labelled', () => {
    expect(key_of('stop all')).toBe('Shift Esc');
    expect(key_of('play')).toBe('Space');
    expect(key_of('follow')).toBe('f');
  });

  it('have no effect when unknown', () => expect(key_action(press('q'))).toBeNull());
});
