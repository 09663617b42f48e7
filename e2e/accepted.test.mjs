// What the server has accepted is never lost: a command that was answered takes effect although the server is killed at
// once, and a Stop holds for a vehicle that was dead when it was given, whichever process is killed next.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { Truth } from './lib/bus.mjs';
import { eventually, Platform, work_folder } from './lib/platform.mjs';

const paused = async (platform, number) => {
  const aiv = await platform.aiv(number);
  return aiv.connection === 'ONLINE' && !aiv.lost && aiv.paused && !aiv.driving;
};
const is_back = async (platform) => eventually('the server responds again', async () => (await platform.snapshot()).aivs.length === 3, { within_ms: 20_000 });

test('a store continues over cosiva up, and no run overwrites another', { timeout: 180_000 }, async (t) => {
  const folder = work_folder(t);
  const store = path.join(folder, 'store');
  const up = () => Platform.up(t, { aivs: 1, folder, args: ['--store', store] });
  const segments = () => readdirSync(store).filter((name) => name.endsWith('.segment'));
  const first = await up();
  const { id } = await first.ask('POST', 'virtual-objects', { kind: 'obstacle', x: 1.6, y: 1.6 });
  const close = { command: 'close', section: 'east', id: 'the-first-of-the-day' };
  await first.ask('POST', 'commands', close);
  await first.stop();
  const before = new Map(segments().map((name) => [name, readFileSync(path.join(store, name))]));
  const second = await up();
  assert.ok((await second.snapshot()).virtualObjects.some((object) => object.id === id), `${id} is there`);
  assert.deepEqual((await second.snapshot()).zone.closed, ['east']);
  // The response to the same request is the same, and it is not executed again.
  await second.ask('POST', 'commands', { command: 'open', section: 'east' });
  assert.equal((await second.ask('POST', 'commands', close)).id, close.id);
  assert.deepEqual((await second.snapshot()).zone.closed, []);
  await second.stop();
  for (const [name, bytes] of before) assert.ok(readFileSync(path.join(store, name)).equals(bytes), `${name} is as the first run left it`);
  assert.ok(segments().length > before.size);
});

test('accepted is never lost', { timeout: 500_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 3, args: ['--respawn', '4'] });
  const ground_truth = await Truth.follow(t, await platform.broker_port());

  const all_drive = async () => {
    await platform.command('restart', '*');
    const before = new Map(ground_truth.latest.vehicles.map((vehicle) => [vehicle.number, vehicle.distance]));
    await eventually('all drive', () => ground_truth.latest.vehicles.every((vehicle) => vehicle.distance - before.get(vehicle.number) > 0.5), { within_ms: 60_000 });
  };

  await t.test('a command that was answered survives the death of the server', async () => {
    for (const [x, y] of [[1.6, 1.6], [-1.6, 1.6], [1.6, -1.6]]) {
      const { id } = await platform.ask('POST', 'virtual-objects', { kind: 'obstacle', x, y });
      await platform.kill_child(/server/i);
      await is_back(platform);
      // A command that the killed server was not given waits until the new one knows its vehicles, 5 s at most.
      await eventually(`${id} is there after the restart`, async () => (await platform.snapshot()).virtualObjects.some((object) => object.id === id), { within_ms: 7_000 });
    }
  });

  // Each part that may be killed between the Stop and the return of a vehicle that was dead when it was given.
  const kills = {
    server: async () => {
      await platform.kill_child(/server/i);
      await is_back(platform);
    },
    broker: () => platform.kill_child(/broker/i),
    vehicle: async () => {
      await eventually('the vehicle is there again', async () => (await platform.aiv(2)).connection === 'ONLINE', { within_ms: 20_000, every_ms: 20 });
      await platform.kill_child(/aiv\D*2$/i);
    },
    'server after the return, with another vehicle': async () => {
      await eventually('the vehicle is stopped', () => paused(platform, 2), { within_ms: 20_000 });
      await platform.kill_child(/aiv\D*1$/i);
      await platform.kill_child(/server/i);
      await is_back(platform);
    },
  };
  for (const [killed, kill] of Object.entries(kills)) {
    await t.test(`a Stop holds for a vehicle that was dead, when a kill follows: ${killed}`, async () => {
      await platform.kill_child(/aiv\D*2$/i);
      await ground_truth.rests(2, 5_000);
      await eventually('its twin is lost', async () => (await platform.aiv(2)).connection !== 'ONLINE', { within_ms: 5_000 });
      const rest_m = ground_truth.vehicle(2).distance;
      const stop = await platform.command('stop', '*');
      assert.notEqual((await platform.aiv(2)).connection, 'ONLINE', 'the vehicle was dead at the Stop');
      // A Stop is responded to before its record: only a durable one outlives the server.
      await eventually('the Stop is durable', async () => (await platform.get(`commands/${stop}`)).durable, { every_ms: 5 });
      await kill();
      await eventually('all are stopped', async () => (await Promise.all([1, 2, 3].map((number) => paused(platform, number)))).every(Boolean), { within_ms: 30_000 });
      const driven = await ground_truth.driven(3_000);
      for (const [number, metres] of driven) assert.ok(metres < 0.005, `AIV${number} drove ${metres} m although it is stopped`);
      // Not even for a moment on its return.
      const since_m = ground_truth.vehicle(2).distance - rest_m;
      assert.ok(since_m < 0.005, `AIV2 has driven ${since_m} m since the Stop`);
      await all_drive();
    });
  }
  await t.test('without a collision', () => {
    ground_truth.assert_no_collision();
  });
});
