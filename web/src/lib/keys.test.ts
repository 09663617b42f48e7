import { describe, expect, it } from 'vitest';
import { key_action, type KeyPress } from './keys';

const press = (key: string, change: Partial<KeyPress> = {}): KeyPress => ({
  key, shiftKey: false, ctrlKey: false, altKey: false, metaKey: false, repeat: false, target: null, ...change,
});
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

  it('do nothing when unknown', () => expect(key_action(press('q'))).toBeNull());
});
