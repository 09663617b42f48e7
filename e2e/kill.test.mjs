// kill -9 of each part in turn: the other parts stop safely or go on, the killed part is restarted, the fleet goes on
// without help.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Truth } from './lib/bus.mjs';
import { eventually, Platform, sleep } from './lib/platform.mjs';

const stop_ms_max = 1_700; // 500 ms until the loss is noticed, 830 ms of braking from 0.5 m/s at 0.6 m/s², ground truth's 100 ms, slack
const everyone = [1, 2, 3, 4];

async function all_go_on(platform, ground_truth, what, within_ms = 45_000) {
  // Distance, not speed: at any time a vehicle may wait before a crossing.
  const before = new Map(ground_truth.latest.vehicles.map((vehicle) => [vehicle.number, vehicle.distance]));
  const late = () => ground_truth.latest.vehicles.filter((vehicle) => vehicle.distance - before.get(vehicle.number) <= 1);
  try {
    await eventually(`every AIV drives on after ${what}`, () => late().length === 0, { within_ms });
  } catch (error) {
    // The vehicle that a vehicle waits for is more informative than the fact that it waits.
    const { aivs, crossings, deadlocks } = await platform.snapshot();
    const known = aivs.map(({ number, connection, status, section, s, waitsFor, fieldViolation, driving, errors }) => ({ number, connection, status, section, s, waitsFor, fieldViolation, driving, errors }));
    error.message += `\nlate: ${JSON.stringify(late())}\n${known.map((aiv) => JSON.stringify(aiv)).join('\n')}\n${JSON.stringify(crossings)}\n${JSON.stringify(deadlocks)}`;
    throw error;
  }
}

test('kill -9', { timeout: 300_000 }, async (t) => {
  // Long enough to detect the loss before it is repaired.
  const platform = await Platform.up(t, { args: ['--respawn', '4'] });
  const ground_truth = await Truth.follow(t, await platform.broker_port());
  await all_go_on(platform, ground_truth, 'the start');
  const lost_at = new Map();

  await t.test('of an AIV: its twin shows the broken connection, the others go on, it rejoins', async () => {
    const killed_ms = Date.now();
    await platform.kill_child(/aiv\D*2$/i);
    await eventually('the twin is lost', async () => {
      const aiv = await platform.aiv(2);
      return aiv.connection === 'CONNECTIONBROKEN' || aiv.lost;
    }, { within_ms: 2_000 });
    assert.ok(Date.now() - killed_ms < 2_500);
    await ground_truth.stands(2, 2_000);
    const driven = await ground_truth.driven(1_500);
    assert.ok([1, 3, 4].some((number) => driven.get(number) > 0.1), 'the others go on');
    const bijection = await platform.get('bijection');
    assert.equal(bijection.virtual, 4, 'a twin is never lost');
    assert.deepEqual(bijection.orphans.map(({ side, id }) => ({ side, id })), [{ side: 'virtual', id: 'CoSiVA/AIV2' }]);

    await eventually('it is online again', async () => (await platform.aiv(2)).connection === 'ONLINE', { within_ms: 20_000 });
    await all_go_on(platform, ground_truth, 'the AIV came back');
    ground_truth.assert_no_collision();
  });

  await t.test('of the server: vehicles stop safely, then all go on', async () => {
    await platform.without_supervisor(async () => {
      await platform.kill_child(/server/i);
      const end = Date.now() + stop_ms_max;
      for (const number of everyone) await ground_truth.stands(number, Math.max(100, end - Date.now()));
      const driven = await ground_truth.driven(1_000);
      for (const [number, metres] of driven) assert.ok(metres < 0.005, `AIV${number} drove ${metres} m without a server`);
    });
    await eventually('the server responds again', async () => (await platform.snapshot()).aivs.length === 4, { within_ms: 20_000 });
    await all_go_on(platform, ground_truth, 'the server came back');
    const snapshot = await platform.snapshot();
    assert.equal(new Set(snapshot.aivs.map((aiv) => aiv.id)).size, 4, 'none is lost or doubled');
    ground_truth.assert_no_collision();
  });

  await t.test('of the server, back at once: all go on', async () => {
    await platform.kill_child(/server/i);
    await eventually('the server responds again', async () => (await platform.snapshot()).aivs.length === 4, { within_ms: 20_000 });
    await all_go_on(platform, ground_truth, 'the server came back');
    ground_truth.assert_no_collision();
  });

  await t.test('of the broker: vehicles stop safely, then all go on', async () => {
    await platform.without_supervisor(async () => {
      const before = new Map(ground_truth.latest.vehicles.map((vehicle) => [vehicle.number, vehicle.distance]));
      await platform.kill_child(/broker/i);
      await sleep(2_500);
      for (const [number, distance] of before) lost_at.set(number, distance);
    });
    // Without a bus the ground truth cannot be received. The first message after it shows how far each vehicle has
    // driven meanwhile: at most the distance of half a second and braking.
    await ground_truth.next();
    for (const vehicle of ground_truth.latest.vehicles) {
      const driven = vehicle.distance - lost_at.get(vehicle.number);
      assert.ok(driven < 0.8, `AIV${vehicle.number} drove ${driven.toFixed(2)} m without a broker`);
    }
    await all_go_on(platform, ground_truth, 'the broker came back');
    ground_truth.assert_no_collision();
  });

  await t.test('of the emulated world: the vehicles are where they were, and all go on', async () => {
    let before;
    await platform.without_supervisor(async () => {
      await platform.kill_child(/plant/i);
      await sleep(1_500);
      before = ground_truth.latest;
    });
    await ground_truth.next();
    for (const { number, x, y } of before.vehicles) {
      const moved_m = Math.hypot(ground_truth.vehicle(number).x - x, ground_truth.vehicle(number).y - y);
      // 0.5 m/s, in the 0.1 s between two ground truths and in the 0.1 s between two states that are persisted.
      assert.ok(moved_m < 0.12, `AIV${number} is ${moved_m.toFixed(2)} m from where it was`);
    }
    await all_go_on(platform, ground_truth, 'the emulated world came back');
    ground_truth.assert_no_collision();
  });
});
