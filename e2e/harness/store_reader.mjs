// Reads a store by its description alone (docs/protocols/store.md, docs/protocols/journal.md). `cosiva journal` is not
// asked: the harness compares its own reading with it.
import { readdirSync, readFileSync, statSync } from 'node:fs';
import path from 'node:path';
import { blake2b256, crc32c, xxh3_128 } from './hashes.mjs';

const segment_name = /^\d{20}\.segment$/;
const header_bytes = 60;
const batch_header_bytes = 32;
const hash_bytes = 32;
const record_overhead_bytes = 8; // length and CRC
const kinds = ['?', 'configure', 'message', 'link', 'bytes', 'port', 'command', 'tick', 'restore', 'proposal', 'persisted'];

function damage(file, offset, what) {
  return new Error(`${file}, byte ${offset}: ${what}`);
}

function read_header(file, bytes) {
  if (bytes.length < header_bytes) return null; // a start that was cut short
  const format = ['COSIVAS1', 'COSIVAS2'].indexOf(bytes.toString('latin1', 0, 8)) + 1;
  if (format === 0) throw damage(file, 0, 'not a segment');
  if (crc32c(bytes.subarray(0, 56)) !== bytes.readUInt32LE(56)) throw damage(file, 56, 'CRC of the header');
  const first = bytes.readBigUInt64LE(16);
  if (first !== BigInt(file.slice(0, 20))) throw damage(file, 16, `first record ${first}`);
  return { format, store: bytes.readBigUInt64LE(8), first, hash: bytes.subarray(24, 56) };
}

/** The records of one batch: {kind, flag, at_ms, source, payload}. */
function read_records(file, bytes, offset, count) {
  const records = [];
  let at = 0;
  while (at < bytes.length) {
    const length = bytes.readUInt32LE(at);
    const end = at + length + record_overhead_bytes;
    if (length < 12 || end > bytes.length) throw damage(file, offset + at, `a record of ${length} bytes`);
    if (crc32c(bytes.subarray(at, end - 4)) !== bytes.readUInt32LE(end - 4)) throw damage(file, offset + at, 'CRC of a record');
    const source_bytes = bytes.readUInt16LE(at + 14);
    records.push({
      kind: kinds[bytes[at + 4]] ?? 'unknown',
      flag: bytes[at + 5],
      at_ms: Number(bytes.readBigInt64LE(at + 6) / 1000n) / 1000,
      source: bytes.toString('utf8', at + 16, at + 16 + source_bytes),
      payload: bytes.subarray(at + 16 + source_bytes, end - 4),
    });
    at = end;
  }
  if (records.length !== count) throw damage(file, offset, `${records.length} records instead of ${count}`);
  return records;
}

/** One batch at `at`, or null where the file ends within it. */
function read_batch(file, bytes, at, header, hash) {
  if (bytes.length - at < batch_header_bytes) return null;
  const fields = bytes.subarray(at, at + batch_header_bytes);
  if (fields.every((byte) => byte === 0)) return null;
  if (fields.toString('latin1', 0, 4) !== 'BTCH') throw damage(file, at, 'no batch begins here');
  if (crc32c(fields.subarray(0, 28)) !== fields.readUInt32LE(28)) throw damage(file, at, 'CRC of a batch');
  if (fields.readBigUInt64LE(8) !== header.store) throw damage(file, at, 'a batch of another store');
  const length = fields.readUInt32LE(4);
  const end = at + batch_header_bytes + length + hash_bytes;
  if (end > bytes.length) return null;
  const records = bytes.subarray(at + batch_header_bytes, end - hash_bytes);
  const chained = blake2b256(Buffer.concat([hash, fields, header.format === 1 ? records : xxh3_128(records)]));
  if (!chained.equals(bytes.subarray(end - hash_bytes, end))) throw damage(file, at, 'hash of a batch');
  return { first: fields.readBigUInt64LE(16), end, hash: chained, records: read_records(file, records, at + batch_header_bytes, fields.readUInt32LE(24)) };
}

/** Reads one segment from its header on, up to the record `limit`; the last segment has no limit. */
function read_segment(name, bytes, header, limit) {
  const read = { records: [], next: header.first, hash: header.hash, torn: false };
  let at = header_bytes;
  while (at < bytes.length && (limit === undefined || read.next < limit)) {
    const batch = read_batch(name, bytes, at, header, read.hash);
    if (!batch) {
      read.torn = limit === undefined;
      break;
    }
    if (batch.first !== read.next) throw damage(name, at, `a batch with record ${batch.first} instead of ${read.next}`);
    for (const record of batch.records) read.records.push({ number: Number(read.next++), ...record });
    read.hash = batch.hash;
    at = batch.end;
  }
  if (limit !== undefined && read.next !== limit) throw damage(name, at, `ends before record ${limit}`);
  return read;
}

/**
 * All records of the store in `folder`, in order, with their numbers: {records, count, torn, hash}. Throws where the store is
 * damaged. `torn`: the last segment ends within a write.
 *
 * @param keep   which records the result contains; all are checked
 * @param cache  a Map of one folder; segments that did not change since the reading before are not read again
 */
export function read_store(folder, { keep = () => true, cache = new Map() } = {}) {
  const files = readdirSync(folder).filter((name) => segment_name.test(name)).sort();
  const result = { records: [], count: 0, torn: false, hash: Buffer.alloc(hash_bytes) };
  let number = null;
  for (const [index, name] of files.entries()) {
    const last = index === files.length - 1;
    // The next segment's name is what counts: its header may not have been written yet.
    const limit = last ? undefined : BigInt(files[index + 1].slice(0, 20));
    const { size, mtimeMs } = statSync(path.join(folder, name));
    const version = `${size} ${mtimeMs} ${limit}`;
    let segment = cache.get(name);
    if (segment?.version !== version) {
      const bytes = readFileSync(path.join(folder, name));
      const header = read_header(name, bytes);
      if (!header) {
        if (!last) throw damage(name, 0, 'the header is cut short');
        result.torn = true;
        break;
      }
      const { records, ...read } = read_segment(name, bytes, header, limit);
      segment = { version, first: header.first, before: header.hash, ...read, records: records.filter(keep) };
      cache.set(name, segment);
    }
    if (number !== null && segment.first !== number) throw damage(name, 16, `begins with record ${segment.first} instead of ${number}`);
    if (number !== null && !segment.before.equals(result.hash)) throw damage(name, 24, 'the hash of the records before');
    number = segment.next;
    result.count += Number(segment.next - segment.first);
    result.records.push(...segment.records);
    result.hash = segment.hash;
    result.torn ||= segment.torn;
  }
  return result;
}

const command_bytes_max = 1 << 16; // of a body, docs/protocols/hmi-api.md; a zone that is switched to is larger

/** Is the record one of those that commands_of() evaluates? */
export function is_command({ kind, payload }) {
  return (kind === 'command' || kind === 'proposal') && payload.length <= command_bytes_max;
}

/** The commands of `records` in the order of their execution: {at_ms, number, source, executed, json}. */
export function commands_of(records) {
  const commands = [];
  const waiting = new Map(); // accepted, and not executed yet
  for (const record of records) {
    if (!is_command(record)) continue;
    const text = record.payload.toString('utf8');
    const entry = { at_ms: record.at_ms, number: record.number, source: record.source, executed: record.kind === 'command', json: JSON.parse(text) };
    if (record.kind === 'proposal') {
      waiting.set(text, [...(waiting.get(text) ?? []), entry]);
      continue;
    }
    const accepted = waiting.get(text)?.shift();
    commands.push({ ...entry, accepted_ms: accepted?.at_ms ?? entry.at_ms });
  }
  // What was accepted last and not executed is executed at the next start.
  return [...commands, ...[...waiting.values()].flat().map((entry) => ({ ...entry, accepted_ms: entry.at_ms }))];
}
