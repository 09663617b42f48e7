import { describe, expect, it } from 'vitest';
import { bytes_for, FrameDecoder, flag_augmented, flag_blocked } from './frames';
import { sample_frame } from './frames_sample';

const key = (sequence = 1) =>
  sample_frame(true, sequence, sequence, 1000, [
    { handle: 0, x: 1, y: 2, heading: 1.5, speed: 0.35, dx: -0.01, dy: 0.004, status: 2 },
    { handle: 7, x: 3, y: 4, flags: flag_augmented | flag_blocked },
    { handle: 32768, kind: 1, x: 5, y: 6 },
  ]);
const decoder_with_key = () => {
  const decoder = new FrameDecoder();
  decoder.take(key());
  return decoder;
};

describe('a key frame', () => {
  it('contains all objects, in order, in metres and radians', () => {
    const frame = decoder_with_key().write()!;
    expect(frame.count).toBe(3);
    expect(frame.time_ms).toBe(1000);
    expect([...frame.values.subarray(0, 6)].map((v) => Number(v.toFixed(4)))).toEqual([1, 2, 1.5, 0.35, -0.01, 0.004]);
    expect([...frame.words]).toEqual([0, 2 << 8, 7, 12, 32768, 1]);
  });

  it('replaces the previous frames', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(true, 2, 2, 1033, [{ handle: 7, x: 9, y: 9 }]));
    const frame = decoder.write()!;
    expect(frame.count).toBe(1);
    expect([...frame.words]).toEqual([7, 0]);
  });

  it('may be empty', () => {
    const decoder = new FrameDecoder();
    expect(decoder.take(sample_frame(true, 1, 1, 0, []))).toBe(true);
    expect(decoder.write()!.count).toBe(0);
  });
});

describe('a delta frame', () => {
  it('changes the listed objects and leaves the others as in the key frame', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 1033, [{ handle: 7, x: 3.5, y: 4 }]));
    const frame = decoder.write()!;
    expect(frame.sequence).toBe(2);
    expect(frame.time_ms).toBe(1033);
    expect([frame.values[0], frame.values[6], frame.values[12]]).toEqual([1, 3.5, 5]);
  });

  it('is based on the key frame and not on the previous delta, so that any delta may be missed', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 1033, [{ handle: 0, x: 100, y: 2 }]));
    decoder.write();
    decoder.take(sample_frame(false, 3, 1, 1066, [{ handle: 7, x: 3.6, y: 4 }]));
    const frame = decoder.write()!;
    expect([frame.values[0], frame.values[6]!.toFixed(1)]).toEqual([1, '3.6']);
  });

  it('is rejected without its key frame', () => {
    expect(new FrameDecoder().take(sample_frame(false, 2, 1, 0, []))).toBe(false);
    const decoder = decoder_with_key();
    decoder.write();
    expect(decoder.take(sample_frame(false, 9, 8, 0, [{ handle: 0, x: 5, y: 5 }]))).toBe(false);
    expect(decoder.write()).toBeNull();
  });

  it('does not add virtual objects that are not in the key frame', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 0, [{ handle: 55, x: 8, y: 8 }]));
    expect(decoder.write()!.count).toBe(3);
  });
});

describe('the decoder', () => {
  it('returns each frame once', () => {
    const decoder = decoder_with_key();
    expect(decoder.ready).toBe(true);
    expect(decoder.write()).not.toBeNull();
    expect(decoder.ready).toBe(false);
    expect(decoder.write()).toBeNull();
  });

  it('writes into the given memory if it is large enough', () => {
    const room = new ArrayBuffer(bytes_for(3));
    expect(decoder_with_key().write(room)!.buffer).toBe(room);
    const small = new ArrayBuffer(8);
    expect(decoder_with_key().write(small)!.buffer).not.toBe(small);
  });

  it('discards its key frame on a new connection', () => {
    const decoder = decoder_with_key();
    decoder.reset();
    expect(decoder.write()).toBeNull();
    expect(decoder.take(sample_frame(false, 2, 1, 0, []))).toBe(false);
  });

  it('rejects damaged, truncated and other-version frames', () => {
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

  it('omits a virtual object without a position, or listed twice', () => {
    const decoder = new FrameDecoder();
    decoder.take(sample_frame(true, 1, 1, 0, [{ handle: 1, x: NaN, y: 0 }, { handle: 2, x: 1, y: 1 }, { handle: 2, x: 2, y: 2 }]));
    const frame = decoder.write()!;
    expect(frame.count).toBe(1);
    expect(frame.words[0]).toBe(2);
  });

  it('keeps the last position of a virtual object whose next position is invalid', () => {
    const decoder = decoder_with_key();
    decoder.take(sample_frame(false, 2, 1, 0, [{ handle: 0, x: Infinity, y: 0 }]));
    expect(decoder.write()!.values[0]).toBe(1);
  });

  it('maps an unknown status to the last known one', () => {
    const decoder = new FrameDecoder();
    decoder.take(sample_frame(true, 1, 1, 0, [{ handle: 1, x: 0, y: 0, status: 99 }]));
    expect(decoder.write()!.words[1]! >> 8).toBe(5);
  });
});
