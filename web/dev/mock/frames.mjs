// The binary frames of docs/protocols/hmi-api.md.
const record_bytes = 20;
const head_bytes = 24;

export class PositionFrames {
  sequence = 0;
  key_sequence = 0;
  key = Buffer.alloc(0);

  /** @param records [{handle, kind, status, augmented, blocked, x, y, heading, speed, dx, dy}], sorted by handle */
  encode(time_ms, records, as_key) {
    this.sequence++;
    const all = Buffer.alloc(records.length * record_bytes);
    records.forEach((record, i) => write_record(all, i * record_bytes, record));
    const same_handles = () => {
      for (let at = 0; at < all.length; at += record_bytes) if (all.readUInt16LE(at) !== this.key.readUInt16LE(at)) return false;
      return true;
    };
    const is_key = as_key || all.length !== this.key.length || !same_handles();
    if (is_key) {
      this.key = all;
      this.key_sequence = this.sequence;
      return { is_key, bytes: this.frame(1, this.sequence, time_ms, [all]) };
    }
    const changed = Buffer.allocUnsafe(all.length);
    let length = 0;
    for (let at = 0; at < all.length; at += record_bytes) {
      let same = true;
      for (let i = at + 2; same && i < at + record_bytes; i++) same = all[i] === this.key[i];
      if (!same) length += all.copy(changed, length, at, at + record_bytes);
    }
    return { is_key, bytes: this.frame(0, this.sequence, time_ms, [changed.subarray(0, length)]) };
  }
  /** What a page that has just come needs before the deltas mean anything. */
  last_key(time_ms) {
    return this.frame(1, this.key_sequence, time_ms, [this.key]);
  }
  frame(flags, sequence, time_ms, parts) {
    const head = Buffer.alloc(head_bytes);
    head.writeUInt8(0x50, 0);
    head.writeUInt8(1, 1);
    head.writeUInt16LE(flags, 2);
    head.writeUInt32LE(sequence, 4);
    head.writeUInt32LE(this.key_sequence, 8);
    head.writeUInt32LE(parts.reduce((sum, part) => sum + part.length, 0) / record_bytes, 12);
    head.writeDoubleLE(time_ms, 16);
    return Buffer.concat([head, ...parts]);
  }
}

const i16 = (value) => Math.max(-32768, Math.min(32767, Math.round(value)));
function write_record(bytes, at, { handle, kind, status, augmented, blocked, x, y, heading, speed, dx, dy }) {
  bytes.writeUInt16LE(handle, at);
  bytes.writeUInt8(kind | (augmented ? 4 : 0) | (blocked ? 8 : 0), at + 2);
  bytes.writeUInt8(status, at + 3);
  bytes.writeFloatLE(x, at + 4);
  bytes.writeFloatLE(y, at + 8);
  bytes.writeInt16LE(i16(Math.atan2(Math.sin(heading), Math.cos(heading)) * 1e4), at + 12);
  bytes.writeInt16LE(i16(speed * 1000), at + 14);
  bytes.writeInt16LE(i16(dx * 1000), at + 16);
  bytes.writeInt16LE(i16(dy * 1000), at + 18);
}
