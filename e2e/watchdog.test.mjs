// Frozen processes, whose connections stay open, and single messages: each vehicle brakes half a second after the last
// message of its broker or server, and goes on by itself.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Bus, Truth } from './lib/bus.mjs';
import { descendants, eventually, Platform, sleep } from './lib/platform.mjs';

// 500 ms until the loss is noticed, a cycle, 830 ms of braking from 0.5 m/s at 0.6 m/s², and 350 ms for a loaded machine.
const stop_ms_max = 1_700;
const frozen_ms = 3_000; // below the 5 s after which `up` replaces a process that hangs

/** Freezes the processes while `action` runs; `up` is frozen, too, so that it replaces none. */
async function while_frozen(platform, pids, action) {
  return platform.without_supervisor(async () => {
    const frozen_at_ms = Date.now();
    for (const pid of pids) process.kill(pid, 'SIGSTOP');
    try {
      await action(frozen_at_ms);
    } finally {
      for (const pid of pids) process.kill(pid, 'SIGCONT');
    }
  });
}

/** Every ground truth that the plant publishes, with its own time: those of a frozen broker arrive afterwards. */
async function record_truth(t, port) {
  const samples = [];
  const bus = await Bus.open(t, port, ['cosiva/v1/plant/ground_truth']);
  bus.on_message((_topic, payload) => {
    const { timestamp, vehicles } = JSON.parse(payload.toString());
    samples.push({ at_ms: Date.parse(timestamp), vehicles });
  });
  return samples;
}

/** Fails unless every vehicle is stopped from `stop_ms_max` after `frozen_at_ms` on, until `until_ms`. */
function assert_stopped(samples, frozen_at_ms, until_ms, what) {
  const within = samples.filter(({ at_ms }) => at_ms > frozen_at_ms + stop_ms_max && at_ms < until_ms);
  assert.ok(within.length >= 3, `${within.length} ground truths while ${what} was frozen`);
  for (const { at_ms, vehicles } of within)
    for (const { number, speed } of vehicles)
      assert.ok(Math.abs(speed) < 0.01, `AIV${number} drives at ${speed} m/s ${at_ms - frozen_at_ms} ms after ${what} was frozen`);
}

function assert_some_drove(samples, from_ms, to_ms, what) {
  const some = samples.some(({ at_ms, vehicles }) => at_ms > from_ms && at_ms < to_ms && vehicles.some(({ speed }) => speed > 0.1));
  assert.ok(some, `no vehicle drove ${what}`);
}

async function all_go_on(ground_truth, what) {
  // Distance, not speed: at any time a vehicle may wait before a crossing.
  const before = new Map(ground_truth.latest.vehicles.map(({ number, distance }) => [number, distance]));
  const all = () => ground_truth.latest.vehicles.every(({ number, distance }) => distance - before.get(number) > 0.5);
  await eventually(`every AIV drives on after ${what}`, all, { within_ms: 45_000 });
}

test('watchdogs by traffic', { timeout: 300_000 }, async (t) => {
  const platform = await Platform.up(t);
  const port = await platform.broker_port();
  const ground_truth = await Truth.follow(t, port);
  const samples = await record_truth(t, port);
  await all_go_on(ground_truth, 'the start');

  await t.test('a frozen broker stops all vehicles, and they go on when it does', async () => {
    const broker = descendants(platform.pid).find(({ argv }) => /mosquitto/.test(argv[0] ?? ''));
    let began_ms = 0;
    await while_frozen(platform, [broker.pid], async (frozen_at_ms) => {
      began_ms = frozen_at_ms;
      await sleep(frozen_ms);
    });
    const ended_ms = Date.now();
    await eventually('the ground truth of the outage arrives', () => samples.at(-1).at_ms > ended_ms);
    assert_some_drove(samples, began_ms - 500, began_ms, 'before the broker was frozen');
    assert_stopped(samples, began_ms, began_ms + frozen_ms, 'the broker');
    await all_go_on(ground_truth, 'the broker went on');
  });

  await t.test('a frozen server stops all vehicles, and they go on when it does', async () => {
    const server = await platform.child(/server/i);
    let began_ms = 0;
    await while_frozen(platform, [server.pid], async (frozen_at_ms) => {
      began_ms = frozen_at_ms;
      await sleep(frozen_ms);
    });
    assert_some_drove(samples, began_ms - 500, began_ms, 'before the server was frozen');
    assert_stopped(samples, began_ms, began_ms + frozen_ms, 'the server');
    await all_go_on(ground_truth, 'the server went on');
  });

  await t.test('a retained owner that does not exist stops its vehicle, until it is removed', async () => {
    const bus = await Bus.open(t, port, []);
    const topic = 'cosiva/v1/owner/CoSiVA/AIV2';
    await bus.publish(topic, { area: 'nowhere', sequence: 1, timestamp: new Date().toISOString() }, { qos: 1, retain: true });
    await sleep(stop_ms_max);
    await ground_truth.stands(2, 500);
    const driven = await ground_truth.driven(1_000);
    assert.ok(driven.get(2) < 0.005, `AIV2 drove ${driven.get(2)} m without its server`);
    await bus.client.publishAsync(topic, '', { qos: 1, retain: true });
    await all_go_on(ground_truth, 'the owner was removed');
  });

  await t.test('a forged OFFLINE of the server does not disarm the vehicles', async () => {
    const bus = await Bus.open(t, port, []);
    const server = await platform.child(/server/i);
    let began_ms = 0;
    await while_frozen(platform, [server.pid], async (frozen_at_ms) => {
      began_ms = frozen_at_ms;
      await bus.publish('cosiva/v1/server/connection', { connectionState: 'OFFLINE' }, { qos: 1, retain: true });
      await sleep(frozen_ms);
    });
    assert_stopped(samples, began_ms, began_ms + frozen_ms, 'the server');
    await all_go_on(ground_truth, 'the server went on');
  });

  ground_truth.assert_no_collision();
});
