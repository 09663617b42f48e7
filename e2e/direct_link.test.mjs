// Vehicles send to each other without their broker: over UDP multicast, IPv4 and IPv6, while datagrams without the key,
// changed ones and repeated ones have no effect. The test reads the datagrams itself, with another implementation.
import assert from 'node:assert/strict';
import { createHmac, randomBytes } from 'node:crypto';
import dgram from 'node:dgram';
import { chmodSync, readFileSync, writeFileSync } from 'node:fs';
import { networkInterfaces } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { Truth } from './lib/bus.mjs';
import { finally_do } from './lib/cleanup.mjs';
import { cosiva, descendants, eventually, Platform, sleep, work_folder } from './lib/platform.mjs';

// Linux has no route of IPv6 multicast over the loopback interface; over any other one, datagrams return to this machine.
const ipv6_name = Object.entries(networkInterfaces()).find(([, all]) => all.some(({ family, internal }) => !internal && family === 'IPv6'))?.[0];
const groups = {
  IPv4: { group: '239.192.7.50', type: 'udp4', name: 'lo', interface: '127.0.0.1', text: (port) => `239.192.7.50:${port}` },
  IPv6: { group: 'ff15::c051:7a', type: 'udp6', name: ipv6_name, interface: `::%${ipv6_name}`, text: (port) => `[ff15::c051:7a]:${port}` },
};
const tag_of = (key, bytes) => createHmac('sha256', key).update(bytes).digest();

function decode(key, datagram) {
  const body = datagram.subarray(0, -32);
  assert.ok(tag_of(key, body).equals(datagram.subarray(-32)), 'the tag is that of node:crypto');
  assert.equal(body.subarray(0, 5).toString('latin1'), 'CV2X\x01');
  const [m, n, p] = [body[22], body[23], body.readUInt16BE(24)];
  assert.equal(body.length, 26 + m + n + p);
  const serial = body.subarray(26 + m, 26 + m + n).toString();
  return { kind: body[5], sequence: body.readBigUInt64BE(14), serial, message: JSON.parse(body.subarray(26 + m + n).toString()) };
}

/** A participant of the group that is no vehicle: receives all datagrams, and sends any bytes. */
async function join_group(t, version, port) {
  const socket = dgram.createSocket({ type: version.type, reuseAddr: true });
  finally_do(t, () => socket.close());
  const received = [];
  socket.on('message', (bytes) => received.push({ at_ms: Date.now(), bytes }));
  await new Promise((resolve) => socket.bind(port, resolve));
  socket.addMembership(version.group, version.interface);
  socket.setMulticastInterface(version.interface);
  const send = (bytes) => new Promise((resolve, reject) => socket.send(bytes, port, version.group, (error) => (error ? reject(error) : resolve())));
  return { received, send };
}

function key_file(t) {
  const file = path.join(work_folder(t), 'v2x.key');
  writeFileSync(file, randomBytes(32), { mode: 0o600 });
  return file;
}

for (const [name, version] of Object.entries(groups).filter(([, { name: interface_name }]) => interface_name)) {
  test(`vehicles receive from each other by ${name} without a broker`, { timeout: 150_000 }, async (t) => {
    const file = key_file(t);
    const key = readFileSync(file);
    const port = 20_000 + (process.pid % 20_000) + (name === 'IPv6' ? 1 : 0);
    const direct = ['--v2x-multicast', version.text(port), '--v2x-key', file, '--v2x-interface', version.name, '--link-loss', 'finish-base'];
    const platform = await Platform.up(t, { aivs: 3, args: ['--headless', ...direct] });
    const ether = await join_group(t, version, port);
    await sleep(1_000);

    await platform.without_supervisor(async () => {
      const broker = descendants(platform.pid).find(({ argv }) => /mosquitto/.test(argv[0] ?? ''));
      process.kill(broker.pid, 'SIGKILL');
      await sleep(1_000);
      ether.received.length = 0;
      await sleep(2_000);
      const messages = ether.received.map(({ bytes }) => decode(key, bytes));
      for (const serial of ['AIV1', 'AIV2', 'AIV3']) {
        const own = messages.filter((message) => message.serial === serial);
        // A vehicle that receives from no other sends once a second.
        assert.ok(own.length >= 12, `${serial} sent ${own.length} datagrams in 2 s without a broker`);
        assert.ok(own.every(({ message }) => message.serialNumber === serial && message.mapId === 'lacet4'));
        assert.equal(new Set(own.map(({ sequence }) => sequence)).size, own.length, 'each number once');
      }
      const whole = ether.received[0].bytes;
      for (let i = 0; i < 50; ++i) await ether.send(whole);
      const changed = Buffer.from(whole);
      changed[40] ^= 1;
      for (let i = 0; i < 40; ++i) await ether.send(changed);
      for (let i = 0; i < 30; ++i) await ether.send(Buffer.concat([whole.subarray(0, -32), tag_of(randomBytes(32), whole.subarray(0, -32))]));
      for (let i = 0; i < 20; ++i) await ether.send(Buffer.from('{"no":"datagram"}'));
      await sleep(300);
    });
    // The broker and then the fleet are back.
    await platform.ready();
    const truth = await Truth.follow(t, await platform.broker_port());
    truth.assert_no_collision();
    await platform.stop();
    for (const number of [1, 2, 3]) {
      const log = readFileSync(path.join(platform.log_dir, `aiv${number}.log`), 'utf8');
      const counts = /direct link: (\d+) sent, (\d+) accepted, (\d+) forged, (\d+) replayed, (\d+) malformed/.exec(log)?.slice(1).map(Number);
      assert.ok(counts, `AIV${number} prints its counters:\n${log.slice(-500)}`);
      const [sent, accepted, forged, replayed, malformed] = counts;
      assert.ok(sent > 30 && accepted > 60, `${counts}`);
      assert.equal(forged, 70, `${counts}`);
      // The vehicle that sent the repeated datagram counts it as its own.
      assert.ok(replayed === 50 || replayed === 0, `${counts}`);
      assert.equal(malformed, 20, `${counts}`);
    }
  });
}

test('vehicles agree on crossings among themselves', { timeout: 150_000 }, async (t) => {
  const file = key_file(t);
  const port = 41_000 + (process.pid % 20_000);
  const args = ['--headless', '--v2x-multicast', groups.IPv4.text(port), '--v2x-key', file, '--v2x-interface', 'lo', '--autonomy', 'negotiate'];
  const platform = await Platform.up(t, { aivs: 4, args });
  const truth = await Truth.follow(t, await platform.broker_port());
  await sleep(30_000);
  truth.assert_no_collision();
  for (const { number, distance } of truth.latest.vehicles) assert.ok(distance > 3, `AIV${number} drove ${distance} m in 30 s`);
});

test('a key that others may read, or of another length, is refused before anything starts', async (t) => {
  const file = key_file(t);
  const up = (...more) => cosiva(['up', '--headless', '--v2x-multicast', '239.192.7.50:7500', ...more]);
  chmodSync(file, 0o644);
  const open = await up('--v2x-key', file);
  assert.equal(open.code, 2);
  assert.match(open.stderr, /others than its owner may access the key/);
  writeFileSync(path.join(path.dirname(file), 'short'), 'x', { mode: 0o600 });
  const short = await up('--v2x-key', path.join(path.dirname(file), 'short'));
  assert.equal(short.code, 2);
  assert.match(short.stderr, /exactly 32/);
  assert.equal((await up()).code, 2, 'without a key');
  assert.equal((await cosiva(['up', '--autonomy', 'negotiate'])).code, 2, 'without a direct link');
});
