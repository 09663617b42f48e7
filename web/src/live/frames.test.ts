import { describe, expect, it } from 'vitest';
import { bytes_for, FrameDecoder, look_augmented, look_blocked } from './frames';
import { sample_frame } from './frames_sample';

const key = (sequence = 1) =>
  sample_frame(true, sequence, sequence, 1000, [
    { handle: 0, x: 1, y: 2, heading: 1.5, speed: 0.35, dx: -0.01, dy: 0.004, status: 2 },
    { handle: 7, x: 3, y: 4, flags: look_augmented | look_blocked },
    { handle: 32768, kind: 1, x: 5, y: 6 },
  ]);
const decoder_with_key = () => {
  const decoder = new FrameDecoder();
  decoder.take(key());
  return decoder;
};

describe('a key frame', () => {
  it('tells of everything, in its order, in metres and radians', () => {
    const frame = decoder_with_key().write()!;
    expect(frame.count).toBe(3);
    expect(frame.time_ms).toBe(1000);
    expect([...frame.values.subarray(0, 6)].map((v) => Number(v.toFixed(4)))).toEqual([1, 2, 1.5, 0.35, -0.01, 0.004]);
    expect([...frame.words]).toEqual([0, 2 << 8, 7, 12, 32768, 1]);
  });

  it('replaces all that was before it', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(true, 2, 2, 1033, [{ handle: 7, x: 9, y: 9 }]));
    const frame = decoder.write()!;
    expect(frame.count).toBe(1);
    expect([...frame.words]).toEqual([7, 0]);
  });

  it('may hold nothing', () => {
    const decoder = new FrameDecoder();
    expect(decoder.take(sample_frame(true, 1, 1, 0, []))).toBe(true);
    expect(decoder.write()!.count).toBe(0);
  });
});

describe('a delta frame', () => {
  it('changes what it names and leaves the rest as in the key', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 1033, [{ handle: 7, x: 3.5, y: 4 }]));
    const frame = decoder.write()!;
    expect(frame.sequence).toBe(2);
    expect(frame.time_ms).toBe(1033);
    expect([frame.values[0], frame.values[6], frame.values[12]]).toEqual([1, 3.5, 5]);
  });

  it('builds on the key and not on the delta before it, so that any one may be missed', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 1033, [{ handle: 0, x: 100, y: 2 }]));
    decoder.write();
    decoder.take(sample_frame(false, 3, 1, 1066, [{ handle: 7, x: 3.6, y: 4 }]));
    const frame = decoder.write()!;
    expect([frame.values[0], frame.values[6]!.toFixed(1)]).toEqual([1, '3.6']);
  });

  it('is refused without the key that it builds on', () => {
    expect(new FrameDecoder().take(sample_frame(false, 2, 1, 0, []))).toBe(false);
    const decoder = decoder_with_key();
    decoder.write();
    expect(decoder.take(sample_frame(false, 9, 8, 0, [{ handle: 0, x: 5, y: 5 }]))).toBe(false);
    expect(decoder.write()).toBeNull();
  });

  it('does not bring in virtual objects that the key does not have', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 0, [{ handle: 55, x: 8, y: 8 }]));
    expect(decoder.write()!.count).toBe(3);
  });
});

describe('the decoder', () => {
  it('gives each picture once', () => {
    const decoder = decoder_with_key();
    expect(decoder.ready).toBe(true);
    expect(decoder.write()).not.toBeNull();
    expect(decoder.ready).toBe(false);
    expect(decoder.write()).toBeNull();
  });

  it('writes into the memory it is given, if that is large enough', () => {
    const room = new ArrayBuffer(bytes_for(3));
    expect(decoder_with_key().write(room)!.buffer).toBe(room);
    const small = new ArrayBuffer(8);
    expect(decoder_with_key().write(small)!.buffer).not.toBe(small);
  });

  it('forgets its key when the connection is new', () => {
    const decoder = decoder_with_key();
    decoder.reset();
    expect(decoder.write()).toBeNull();
    expect(decoder.take(sample_frame(false, 2, 1, 0, []))).toBe(false);
  });

  it('refuses what is damaged, cut short or of another version', () => {
    const decoder = new FrameDecoder();
    const wrong = (change: (bytes: Uint8Array) => void) => {
      const bytes = key();
      change(new Uint8Array(bytes));
      return decoder.take(bytes);
    };
    expect(decoder.take(new ArrayBuffer(0))).toBe(false);
    expect(decoder.take(key().slice(0, 60))).toBe(false);
    expect(wrong((bytes) => (bytes[0] = 0x51))).toBe(false);
    expect(wrong((bytes) => (bytes[1] = 2))).toBe(false);
    expect(wrong((bytes) => bytes.fill(255, 12, 16))).toBe(false);
    expect(wrong((bytes) => bytes.fill(255, 16, 24))).toBe(false);
  });

  it('leaves out a virtual object without a place, or named twice', () => {
    const decoder = new FrameDecoder();
    decoder.take(sample_frame(true, 1, 1, 0, [{ handle: 1, x: NaN, y: 0 }, { handle: 2, x: 1, y: 1 }, { handle: 2, x: 2, y: 2 }]));
    const frame = decoder.write()!;
    expect(frame.count).toBe(1);
    expect(frame.words[0]).toBe(2);
  });

  it('keeps the last place of a virtual object whose next one is no place', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 0, [{ handle: 0, x: Infinity, y: 0 }]));
    expect(decoder.write()!.values[0]).toBe(1);
  });

  it('reads a status it does not know as the last one it knows', () => {
    const decoder = new FrameDecoder();
    decoder.take(sample_frame(true, 1, 1, 0, [{ handle: 1, x: 0, y: 0, status: 99 }]));
    expect(decoder.write()!.words[1]! >> 8).toBe(5);
  });
});
