// Decodes the binary position frames of docs/protocols/hmi-api.md into one buffer, which is transferred between threads and
// reused. A delta frame holds the differences from the last key frame, so that only the newest delta matters.

/** The positions of all objects at one instant: a struct of arrays over one buffer. */
export interface PositionFrame {
  buffer: ArrayBuffer;
  sequence: number;
  /** server time, Unix milliseconds */
  time_ms: number;
  count: number;
  /** six values per record: x, y [m], heading [rad], speed [m/s], offset from the twin to the last report x, y [m] */
  values: Float32Array;
  /** two per record: the handle, then the appearance */
  words: Uint16Array;
}

export const value_count = 6;
const word_count = 2;
const record_bytes = 20;
const head_bytes = 24;
const magic = 0x50;
const version = 1;
/** A frame with more records than there are handles is damaged. */
export const records_max = 65_536;

/** The appearance of a record: kind in bits 0-1, augmented, blocked, and the status from bit 8 on. */
export const flags_kind_mask = 3;
export const flag_augmented = 4;
export const flag_blocked = 8;
export const flags_status_shift = 8;
export const kind_aiv = 0;
export const kind_person = 1;
export const kind_obstacle = 2;
export const status_count = 6;

export function bytes_for(count: number): number {
  return count * (4 * value_count + 2 * word_count);
}

/** A view of a buffer as a frame. The buffer may be larger than needed. */
export function frame_over(buffer: ArrayBuffer, count: number, sequence: number, time_ms: number): PositionFrame {
  return {
    buffer, sequence, time_ms, count,
    values: new Float32Array(buffer, 0, count * value_count),
    words: new Uint16Array(buffer, count * 4 * value_count, count * word_count),
  };
}

export class FrameDecoder {
  private key_sequence: number | null = null;
  private key_time_ms = 0;
  private count = 0;
  private values = new Float32Array(0);
  private words = new Uint16Array(0);
  private readonly slots = new Int32Array(records_max).fill(-1);
  private delta: DataView | null = null;
  private fresh = false;

  /** Whether `write` would return a frame that has not been returned yet. */
  get ready(): boolean {
    return this.fresh;
  }

  /** Discards the state of the previous connection. */
  reset(): void {
    this.key_sequence = null;
    this.delta = null;
    this.fresh = false;
  }

  /** Decodes a frame; false if it is damaged, of another version, or a delta without its key frame. */
  take(bytes: ArrayBuffer): boolean {
    if (bytes.byteLength < head_bytes) return false;
    const view = new DataView(bytes);
    if (view.getUint8(0) !== magic || view.getUint8(1) !== version) return false;
    const count = view.getUint32(12, true);
    if (count > records_max || bytes.byteLength < head_bytes + count * record_bytes) return false;
    if (!Number.isFinite(view.getFloat64(16, true))) return false;
    if ((view.getUint16(2, true) & 1) === 0) {
      if (view.getUint32(8, true) !== this.key_sequence) return false;
      this.delta = view;
      this.fresh = true;
      return true;
    }
    this.take_key(view, count);
    return true;
  }

  /** Writes the newest positions, into `room` if it is large enough; null if they were already returned. */
  write(room?: ArrayBuffer): PositionFrame | null {
    if (!this.fresh || this.key_sequence === null) return null;
    this.fresh = false;
    const needed = bytes_for(this.count);
    // Spare capacity, so that each additional object does not allocate again.
    const buffer = room && room.byteLength >= needed ? room : new ArrayBuffer(Math.ceil(needed * 1.25) + 256);
    const { delta } = this;
    const sequence = delta ? delta.getUint32(4, true) : this.key_sequence;
    const frame = frame_over(buffer, this.count, sequence, delta ? delta.getFloat64(16, true) : this.key_time_ms);
    frame.values.set(this.values.subarray(0, this.count * value_count));
    frame.words.set(this.words.subarray(0, this.count * word_count));
    if (delta) {
      const changed = delta.getUint32(12, true);
      for (let i = 0; i < changed; i++) {
        const at = head_bytes + i * record_bytes;
        const slot = this.slots[delta.getUint16(at, true)]!;
        if (slot >= 0) read_record(delta, at, frame.values, frame.words, slot);
      }
    }
    return frame;
  }

  private take_key(view: DataView, count: number): void {
    for (let i = 0; i < this.count; i++) this.slots[this.words[word_count * i]!] = -1;
    if (this.words.length < count * word_count) {
      this.values = new Float32Array(count * value_count);
      this.words = new Uint16Array(count * word_count);
    }
    this.count = 0;
    for (let i = 0; i < count; i++) {
      const at = head_bytes + i * record_bytes;
      const handle = view.getUint16(at, true);
      if (this.slots[handle]! >= 0 || !read_record(view, at, this.values, this.words, this.count)) continue;
      this.slots[handle] = this.count++;
    }
    this.key_sequence = view.getUint32(4, true);
    this.key_time_ms = view.getFloat64(16, true);
    this.delta = null;
    this.fresh = true;
  }
}

/** False if a record has no finite position; such an object is not drawn. */
function read_record(view: DataView, at: number, values: Float32Array, words: Uint16Array, slot: number): boolean {
  const x = view.getFloat32(at + 4, true);
  const y = view.getFloat32(at + 8, true);
  if (!Number.isFinite(x) || !Number.isFinite(y)) return false;
  const value = slot * value_count;
  values[value] = x;
  values[value + 1] = y;
  values[value + 2] = view.getInt16(at + 12, true) * 1e-4;
  values[value + 3] = view.getInt16(at + 14, true) * 1e-3;
  values[value + 4] = view.getInt16(at + 16, true) * 1e-3;
  values[value + 5] = view.getInt16(at + 18, true) * 1e-3;
  words[slot * word_count] = view.getUint16(at, true);
  const status = Math.min(view.getUint8(at + 3), status_count - 1);
  words[slot * word_count + 1] = (view.getUint8(at + 2) & 0x0f) | (status << flags_status_shift);
  return true;
}
