// Encodes binary frames as the server does, for tests only.
export interface SampleRecord {
  handle: number;
  kind?: number;
  flags?: number;
  status?: number;
  x: number;
  y: number;
  heading?: number;
  speed?: number;
  dx?: number;
  dy?: number;
}

export function sample_frame(key: boolean, sequence: number, key_sequence: number, time_ms: number, records: readonly SampleRecord[]): ArrayBuffer {
  const bytes = new ArrayBuffer(24 + 20 * records.length);
  const view = new DataView(bytes);
  view.setUint8(0, 0x50);
  view.setUint8(1, 1);
  view.setUint16(2, key ? 1 : 0, true);
  view.setUint32(4, sequence, true);
  view.setUint32(8, key_sequence, true);
  view.setUint32(12, records.length, true);
  view.setFloat64(16, time_ms, true);
  records.forEach((record, i) => {
    const at = 24 + 20 * i;
    view.setUint16(at, record.handle, true);
    view.setUint8(at + 2, (record.kind ?? 0) | (record.flags ?? 0));
    view.setUint8(at + 3, record.status ?? 0);
    view.setFloat32(at + 4, record.x, true);
    view.setFloat32(at + 8, record.y, true);
    view.setInt16(at + 12, Math.round((record.heading ?? 0) * 1e4), true);
    view.setInt16(at + 14, Math.round((record.speed ?? 0) * 1e3), true);
    view.setInt16(at + 16, Math.round((record.dx ?? 0) * 1e3), true);
    view.setInt16(at + 18, Math.round((record.dy ?? 0) * 1e3), true);
  });
  return bytes;
}
