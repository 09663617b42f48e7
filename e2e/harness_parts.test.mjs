// The parts of scripts/chaos against known values: a harness that reads wrongly would find nothing.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { connect, createServer } from 'node:net';
import os from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { CommandStates, differences, differences_or_stopped, missing_commands, settings_after } from './harness/checks.mjs';
import { blake2b256, crc32c, xxh3_128 } from './harness/hashes.mjs';
import { client_of, LossyProxy } from './harness/lossy_proxy.mjs';
import { make_plan } from './harness/plan.mjs';
import { commands_of, read_store } from './harness/store_reader.mjs';
import { Witness } from './harness/witness.mjs';
import { sleep } from './lib/platform.mjs';

test('hashes are those of the standards', () => {
  assert.equal(crc32c(Buffer.from('123456789')), 0xe3069283);
  assert.equal(blake2b256(Buffer.alloc(0)).toString('hex'), '0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8');
  assert.equal(blake2b256(Buffer.from('abc')).toString('hex'), 'bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319');
  // 128 bytes are one block, 129 are two.
  assert.notDeepEqual(blake2b256(Buffer.alloc(128)), blake2b256(Buffer.alloc(129)));
  assert.equal(xxh3_128(Buffer.alloc(0)).toString('hex'), '99aa06d3014798d86001c324468d497f');
  assert.equal(xxh3_128(Buffer.from('abc')).toString('hex'), '06b05ab6733a618578af5f94892f3950');
});

/** A record, a batch and a segment as docs/protocols/store.md describes them. */
function record(kind, at_ms, source, payload) {
  const body = Buffer.alloc(12);
  body.writeUInt8(kind, 0);
  body.writeBigInt64LE(BigInt(at_ms) * 1_000_000n, 2);
  body.writeUInt16LE(source.length, 10);
  const content = Buffer.concat([body, Buffer.from(source), Buffer.from(payload)]);
  const length = Buffer.alloc(4);
  length.writeUInt32LE(content.length);
  const crc = Buffer.alloc(4);
  crc.writeUInt32LE(crc32c(Buffer.concat([length, content])));
  return Buffer.concat([length, content, crc]);
}

function segment(first, hash, batches, format = 2) {
  const header = Buffer.alloc(60);
  header.write(`COSIVAS${format}`, 'latin1');
  header.writeBigUInt64LE(7n, 8);
  header.writeBigUInt64LE(BigInt(first), 16);
  hash.copy(header, 24);
  header.writeUInt32LE(crc32c(header.subarray(0, 56)), 56);
  const parts = [header];
  for (const records of batches) {
    const fields = Buffer.alloc(32);
    const bytes = Buffer.concat(records);
    fields.write('BTCH', 'latin1');
    fields.writeUInt32LE(bytes.length, 4);
    fields.writeBigUInt64LE(7n, 8);
    fields.writeBigUInt64LE(BigInt(first), 16);
    fields.writeUInt32LE(records.length, 24);
    fields.writeUInt32LE(crc32c(fields.subarray(0, 28)), 28);
    hash = blake2b256(Buffer.concat([hash, fields, format === 1 ? bytes : xxh3_128(bytes)]));
    parts.push(fields, bytes, hash);
    first += records.length;
  }
  return { bytes: Buffer.concat(parts), hash, next: first };
}

function store_of(t, files) {
  const folder = mkdtempSync(path.join(os.tmpdir(), 'cosiva-store-'));
  t.after(() => rmSync(folder, { recursive: true }));
  for (const [first, bytes] of files) writeFileSync(path.join(folder, `${String(first).padStart(20, '0')}.segment`), bytes);
  return folder;
}

for (const format of [1, 2]) test(`the store is read over its segments of format ${format} and 2, a torn tail is no damage, and a flipped bit is one`, (t) => {
  const stop = '{"id":"c1","command":"stop","vehicle":"*"}';
  const slow = '{"id":"c2","command":"slow","vehicle":"CoSiVA/AIV1"}';
  const one = segment(1, Buffer.alloc(32), [[record(1, 1_000, 'server', '{}')], [record(6, 2_000, 'http', stop), record(7, 2_001, '', '')]], format);
  const two = segment(one.next, one.hash, [[record(9, 3_000, 'http', slow)]]);
  const read = read_store(store_of(t, [[1, one.bytes], [4, two.bytes]]));
  assert.deepEqual(read.records.map(({ number, kind }) => [number, kind]), [[1, 'configure'], [2, 'command'], [3, 'tick'], [4, 'proposal']]);
  assert.deepEqual(commands_of(read.records).map(({ json, executed, at_ms }) => [json.command, executed, at_ms]), [['stop', true, 2_000], ['slow', false, 3_000]]);
  assert.equal(read.hash.toString('hex'), two.hash.toString('hex'));
  assert.equal(read.torn, false);

  const torn = read_store(store_of(t, [[1, one.bytes], [4, two.bytes.subarray(0, two.bytes.length - 5)]]));
  assert.deepEqual([torn.records.length, torn.torn], [3, true]);
  // After a failed write the batch is in the next segment; the remainder of the failed one does not count.
  const failed = Buffer.concat([one.bytes, two.bytes.subarray(60, 100)]);
  assert.equal(read_store(store_of(t, [[1, failed], [4, two.bytes]])).records.length, 4);
  assert.throws(() => read_store(store_of(t, [[1, one.bytes.subarray(0, one.bytes.length - 5)], [4, two.bytes]])), /ends before record 4|cut short/);
  for (const at of [3, 30, 70, one.bytes.length - 40, one.bytes.length - 1]) {
    const flipped = Buffer.from(one.bytes);
    flipped[at] ^= 1;
    assert.throws(() => read_store(store_of(t, [[1, flipped], [4, two.bytes]])), /segment, byte/, `byte ${at}`);
  }
});

test('the same seed draws the same schedule, and another seed another one', () => {
  const draw = (seed) => JSON.stringify(make_plan({ seed, minutes: 5, aivs: 3 }));
  assert.equal(draw(1), draw(1));
  assert.notEqual(draw(1), draw(2));
  const kinds = new Set(make_plan({ seed: 3, minutes: 60, aivs: 3 }).flatMap(({ episodes }) => episodes).flatMap(({ actions }) => actions.map(({ what, mode, part }) => mode ?? (part ? `${what} ${part}` : what))));
  for (const kind of ['kill server', 'kill up', 'kill broker', 'kill plant', 'kill aiv3', 'freeze server', 'freeze up', 'delay', 'stall', 'cut', 'half_open', 'refuse', 'fill', 'idle', 'body', 'command', 'command_then_kill']) {
    assert.ok(kinds.has(kind), `an hour without ${kind}`);
  }
});

test('settings follow the order of the commands', () => {
  const command = (name, vehicle, speed) => ({ json: { command: name, vehicle, speed } });
  const settings = settings_after([command('stop', '*'), command('limit', 'CoSiVA/AIV1', 0.2), command('restart', 'CoSiVA/AIV2'), command('fast', 'CoSiVA/AIV2'), { json: { command: 'close', section: 'east' } }], 2);
  assert.deepEqual(settings.get('AIV1'), { stopped: true, profile: null, limit: 0.2 });
  assert.deepEqual(settings.get('AIV2'), { stopped: false, profile: 'fast', limit: null });
  assert.deepEqual(differences({ paused: true, status: 'stopped', speedLimit: 0.2 }, settings.get('AIV1')), []);
  assert.equal(differences({ paused: false, status: 'Normal', speedLimit: 0.2 }, settings.get('AIV1')).length, 2);
  assert.equal(differences({ paused: false, status: 'Normal', speedLimit: null }, settings.get('AIV2')).length, 1);
});

test('a confirmed command that the store lacks is found; one with the same id from an earlier server is not taken for it', () => {
  const body = { command: 'slow', vehicle: 'CoSiVA/AIV1' };
  const log = [{ outcome: 'confirmed', id: 'c1', body, sent_ms: 100_000, done_ms: 100_010 }];
  const stored = (accepted_ms) => [{ json: { id: 'c1', ...body }, accepted_ms, executed: true }];
  assert.equal(missing_commands(log, stored(100_005)).length, 0);
  assert.equal(missing_commands(log, stored(50_000)).length, 1);
  assert.equal(missing_commands(log, []).length, 1);
  const states = new CommandStates();
  states.accept({ commands: [{ id: 'c1', vehicle: 'CoSiVA/AIV1', time_ms: 100_004, state: 'failed', reason: 'superseded' }] });
  assert.equal(states.of(log[0], 'AIV1').length, 1);
});

test('a Stop may be missing only while it was not reported as durable', () => {
  const body = { command: 'stop', vehicle: '*' };
  const stop = { outcome: 'confirmed', id: 'S-1-1', body, sent_ms: 100_000, done_ms: 100_002 };
  assert.equal(missing_commands([{ ...stop, durable: false }], []).length, 0);
  assert.equal(missing_commands([{ ...stop, durable: true }], []).length, 1);
});

test('a vehicle may have taken a Stop that was lost, and is otherwise as the store has it', () => {
  const free = { stopped: false, profile: null, limit: 0.2 };
  const paused = { paused: true, status: 'stopped', speedLimit: 0.2 };
  assert.equal(differences_or_stopped(paused, free, false).length, 1);
  assert.deepEqual(differences_or_stopped(paused, free, true), []);
  assert.deepEqual(differences_or_stopped({ ...paused, paused: false, status: 'Normal' }, free, true), []);
  assert.deepEqual(differences_or_stopped({ ...paused, speedLimit: null }, free, true), ['paused is true', 'speedLimit is null']);
});

test('the witness excuses a vehicle whose Stop was lost, and demands the next Stop from then on', () => {
  const found = [];
  const witness = new Witness((what, { command }) => found.push(`${command}: ${what}`));
  const began_ms = Date.now() - 5_000;
  let x = 0;
  const drive = (metres) => {
    for (const end = x + metres; x < end - 1e-9; ) {
      x += 0.05;
      witness.accept('cosiva/v1/plant/ground_truth', { timestamp: new Date(began_ms + x * 2_000).toISOString(), vehicles: [{ number: 1, x, y: 0, speed: 0.5 }] });
    }
  };
  let lost = false;
  drive(0.1);
  witness.hold(1, 'first', { now_ms: began_ms, lost: () => lost });
  lost = true;
  drive(1.5);
  assert.deepEqual(found, []);
  lost = false;
  witness.hold(1, 'first', { now_ms: began_ms, lost: () => lost });
  witness.hold(1, 'second');
  lost = true;
  drive(0.9); // the first is found to be lost here
  assert.deepEqual(found, []);
  drive(2.5);
  assert.deepEqual(found, ['second: a stopped vehicle drove more than a braking distance']);
});

test('the witness accepts braking, and reports a stopped vehicle that drives on, moves later, or jumps', () => {
  const found = [];
  const witness = new Witness((what) => found.push(what));
  let at_ms = Date.now() - 100_000;
  const drive = (x) => witness.accept('cosiva/v1/plant/ground_truth', { timestamp: new Date((at_ms += 100)).toISOString(), vehicles: [{ number: 1, x, y: 0, speed: 0 }], collisions: 0 });
  let x = 0;
  const metres = (distance) => {
    for (const end = x + distance; x < end - 1e-9; ) drive((x = Math.min(end, x + 0.05)));
  };
  drive(0);
  metres(1);
  // The Stop is a second later than the messages that have arrived: what was driven before it does not count.
  witness.hold(1, 'stop', { now_ms: at_ms + 1_000 });
  metres(1.2);
  assert.deepEqual(found, []);
  metres(0.2);
  assert.match(found.pop(), /more than a braking distance/);
  witness.release(1);
  witness.hold(1, 'stop', { now_ms: at_ms - 4_000 });
  drive(x);
  // A plant that was frozen continues its braking.
  at_ms += 3_000;
  metres(0.2);
  at_ms += 400;
  for (let i = 0; i < 12; ++i) drive(x);
  assert.deepEqual(found, []);
  metres(0.05);
  assert.match(found.pop(), /later than 3 s/);
  witness.release(1);
  drive((x += 1));
  assert.match(found.pop(), /faster than it can/);
  witness.allow_teleports();
  drive((x += 1));
  witness.hold(1, 'stop', { now_ms: at_ms });
  at_ms += 8_000;
  drive((x += 1));
  assert.deepEqual(found, []);
});

test('the proxy knows its clients, and delays, stalls, cuts and half-opens their connections', async (t) => {
  const hello = Buffer.from([0x10, 22, 0, 4, ...Buffer.from('MQTT'), 4, 2, 0, 60, 0, 10, ...Buffer.from('cosiva-aiv')]);
  assert.equal(client_of(hello), 'cosiva-aiv');
  assert.equal(client_of(hello.subarray(0, 15)), null);
  const echo = createServer((socket) => socket.on('error', () => {}).pipe(socket));
  await new Promise((resolve) => echo.listen(0, '127.0.0.1', resolve));
  const proxy = await LossyProxy.start(echo.address().port);
  t.after(async () => {
    await proxy.close();
    await new Promise((resolve) => echo.close(resolve));
  });
  const open = async () => {
    const socket = connect(proxy.port, '127.0.0.1').on('error', () => {});
    const client = { socket, received: 0, closed: false };
    socket.on('data', (chunk) => (client.received += chunk.length)).on('close', () => (client.closed = true));
    socket.write(hello);
    for (let i = 0; i < 100 && client.received < hello.length; ++i) await sleep(10);
    assert.equal(client.received, hello.length);
    client.received = 0;
    return client;
  };
  const client = await open();
  for (const fault of [{ mode: 'delay', delay_ms: 300 }, { mode: 'stall' }]) {
    const end = proxy.begin({ client: 'aiv', ...fault });
    client.received = 0;
    client.socket.write('12345');
    await sleep(150);
    assert.equal(client.received, 0, fault.mode);
    end();
    for (let i = 0; i < 100 && client.received < 5; ++i) await sleep(10);
    assert.equal(client.received, 5, fault.mode);
  }
  proxy.begin({ mode: 'cut', client: 'server' })();
  assert.equal(client.closed, false);
  const end = proxy.begin({ mode: 'half_open', client: '*' });
  client.received = 0;
  client.socket.write('12345');
  await sleep(100);
  assert.deepEqual([client.received, client.closed], [0, false]);
  end();
  for (let i = 0; i < 100 && !client.closed; ++i) await sleep(10);
  assert.ok(client.closed);
});
