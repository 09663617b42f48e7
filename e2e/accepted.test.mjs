// What the server has accepted is never lost: a command that was answered takes effect although the server is killed at
// once, and a Stop holds for a vehicle that was dead when it was given, whichever process is killed next.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Truth } from './lib/bus.mjs';
import { eventually, Platform } from './lib/platform.mjs';

const paused = async (platform, number) => {
  const aiv = await platform.aiv(number);
  return aiv.connection === 'ONLINE' && !aiv.lost && aiv.paused && !aiv.driving;
};
const is_back = async (platform) => eventually('the server responds again', async () => (await platform.snapshot()).aivs.length === 3, { within_ms: 20_000 });

test('accepted is never lost', { timeout: 300_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 3, args: ['--respawn', '2'] });
  const ground_truth = await Truth.follow(t, await platform.broker_port());

  await t.test('a command that was answered survives the death of the server', async () => {
    for (const [x, y] of [[1.6, 1.6], [-1.6, 1.6], [1.6, -1.6]]) {
      const { id } = await platform.ask('POST', 'virtual-objects', { kind: 'obstacle', x, y });
      await platform.kill_child(/server/i);
      await is_back(platform);
      // A command that the killed server was not given waits until the new one knows its vehicles, 5 s at most.
      await eventually(`${id} is there after the restart`, async () => (await platform.snapshot()).virtualObjects.some((object) => object.id === id), { within_ms: 7_000 });
    }
  });

  await t.test('a Stop holds for a vehicle that was dead, and for those that are killed later', async () => {
    await platform.kill_child(/aiv\D*2$/i);
    await eventually('its twin is lost', async () => (await platform.aiv(2)).connection !== 'ONLINE', { within_ms: 5_000 });
    const stop = await platform.command('stop', '*');
    // A Stop is responded to before its record: only a durable one outlives the server.
    await eventually('the Stop is durable', async () => (await platform.get(`commands/${stop}`)).durable, { every_ms: 5 });
    await platform.kill_child(/server/i);
    await is_back(platform);
    await eventually('all are stopped', async () => (await Promise.all([1, 2, 3].map((number) => paused(platform, number)))).every(Boolean), { within_ms: 20_000 });
    await platform.kill_child(/aiv\D*1$/i);
    await platform.kill_child(/server/i);
    await is_back(platform);
    await eventually('the killed one is stopped again', async () => paused(platform, 1), { within_ms: 20_000 });
    const driven = await ground_truth.driven(3_000);
    for (const [number, metres] of driven) assert.ok(metres < 0.005, `AIV${number} drove ${metres} m although it is stopped`);
  });

  await t.test('until they are restarted', async () => {
    await platform.command('restart', '*');
    const before = new Map(ground_truth.latest.vehicles.map((vehicle) => [vehicle.number, vehicle.distance]));
    await eventually('all drive', () => ground_truth.latest.vehicles.every((vehicle) => vehicle.distance - before.get(vehicle.number) > 0.5), { within_ms: 45_000 });
    assert.equal(ground_truth.collisions, 0);
  });
});
