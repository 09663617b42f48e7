// A vehicle whose program ends without a last will stays ONLINE on the broker: its twin is an orphan within a second of
// the end of its silence, and an obstacle, until an operator retires it. Excluded vehicles get no orders.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { finally_do } from './lib/cleanup.mjs';
import { Bus, Truth } from './lib/bus.mjs';
import { place } from './lib/clover.mjs';
import { open_browser } from './lib/browser.mjs';
import { open_operator } from './lib/page.mjs';
import { cosiva, cosiva_json, eventually, Platform, sleep } from './lib/platform.mjs';

const id = 'ACME/7';
const silence_ms = 1_000;

/** A third-party vehicle that stands on the circuit and reports ten times a second, until it falls silent. */
class Standing {
  static async start(t, bus) {
    const vehicle = new Standing();
    const { x, y, heading: theta } = place('loop_ne', 1.0);
    const send = (topic, message, options) => {
      vehicle.sent_ms = Date.now();
      const header = { headerId: vehicle.number++, timestamp: new Date().toISOString(), version: '2.0.0', manufacturer: 'ACME', serialNumber: '7' };
      return bus.publish(`uagv/v2/${id}/${topic}`, { ...header, ...message }, options);
    };
    vehicle.number = 0;
    vehicle.connect = () => send('connection', { connectionState: 'ONLINE' }, { retain: true, qos: 1 });
    vehicle.report = () =>
      send('state', {
        orderId: '', orderUpdateId: 0, lastNodeId: '', lastNodeSequenceId: 0, driving: false, operatingMode: 'AUTOMATIC', nodeStates: [], edgeStates: [], actionStates: [], errors: [],
        agvPosition: { x, y, theta, mapId: 'lacet4', positionInitialized: true }, batteryState: { batteryCharge: 80, charging: false }, safetyState: { eStop: 'NONE', fieldViolation: false },
      });
    finally_do(t, () => vehicle.fall_silent());
    await vehicle.connect();
    vehicle.speak();
    return vehicle;
  }

  speak() {
    this.timer = setInterval(() => void this.report(), 100);
  }

  fall_silent() {
    clearInterval(this.timer);
  }
}

test('a vehicle that ends without a word is an orphan until it is retired', { timeout: 120_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2 });
  const bus = await Bus.open(t, await platform.broker_port(), []);
  const bijection = async () => (await platform.snapshot()).bijection;
  const traces_since = async (from) => {
    const traces = [];
    for (let next = from; ; ) {
      const part = await platform.get(`traces?after=${next}&limit=1000`);
      if (part.traces.length === 0) return traces;
      traces.push(...part.traces);
      next = part.next;
    }
  };
  const vehicle = await Standing.start(t, bus);
  await eventually('it has a twin', async () => (await bijection()).matched === 3, { within_ms: 5_000 });
  assert.deepEqual((await bijection()).orphans, []);

  const refused = await cosiva(['vehicle', 'retire', '7', '--url', platform.url]);
  assert.equal(refused.code, 2);
  assert.match(refused.stderr, /ACME\/7 reports; switch it off/);

  await sleep(3_000);  // its usual rate is known
  vehicle.fall_silent();
  const orphans = await eventually('it is an orphan', async () => {
    const found = (await bijection()).orphans;
    return found.length > 0 && found;
  }, { within_ms: 5_000, every_ms: 20 });
  const took_ms = Date.now() - vehicle.sent_ms;
  assert.ok(took_ms >= silence_ms - 100 && took_ms <= silence_ms + 1_000, `after ${took_ms} ms`);
  assert.deepEqual(orphans.map(({ side, id, reason }) => ({ side, id, reason })), [{ side: 'virtual', id, reason: 'it no longer reports, although it is ONLINE' }]);
  const listed = await cosiva(['vehicle', 'list', '--url', platform.url]);
  assert.match(listed.stdout, /ACME\/7 .*orphan: it no longer reports/);

  const { next: last_trace } = await platform.get('traces');
  await t.test('the page names the orphan, and retires it', async (t) => {
    const page = await open_operator(t, await open_browser(t), platform, { vehicles: 3, hash: '#panel=bijection' });
    await page.getByRole('button', { name: 'Retire' }).click();
    await eventually('its twin is gone', async () => (await platform.snapshot()).aivs.length === 2, { within_ms: 5_000 });
    assert.deepEqual(page.script_errors, []);
  });
  assert.deepEqual((await bijection()).orphans, []);
  await eventually('its departure is traced', async () => (await traces_since(last_trace)).some(({ kind, from, to, content }) => kind === 'disappear' && from === 'AIV_Server' && to === 'Simulator' && content.startsWith(id)), { within_ms: 2_000 });

  vehicle.speak();
  await eventually('it arrives again with its next report', async () => (await bijection()).matched === 3, { within_ms: 5_000 });
});

test('an excluded vehicle stands until it is included', { timeout: 120_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2 });
  const ground_truth = await Truth.follow(t, await platform.broker_port());
  await eventually('both drive', () => [1, 2].every((number) => ground_truth.vehicle(number).distance > 0.1), { within_ms: 20_000 });
  assert.equal((await cosiva(['vehicle', 'exclude', 'AIV1', '--url', platform.url])).code, 0);
  await eventually('it stands', () => ground_truth.vehicle(1).speed === 0, { within_ms: 15_000 });
  const at = ground_truth.vehicle(1).distance;
  await platform.command('restart', '*');
  const listed = await cosiva_json(['vehicle', 'list', '--json', '--url', platform.url]);
  assert.deepEqual(listed.map(({ id, excluded, absent }) => ({ id, excluded, absent })), [1, 2].map((number) => ({ id: `CoSiVA/AIV${number}`, excluded: number === 1, absent: '' })));
  await ground_truth.driven(3_000);
  assert.ok(ground_truth.vehicle(1).distance < at + 0.01);
  assert.equal((await platform.snapshot()).bijection.matched, 2, 'its twin stays');
  assert.equal((await cosiva(['vehicle', 'include', 'AIV1', '--url', platform.url])).code, 0);
  await eventually('it drives', () => ground_truth.vehicle(1).distance > at + 0.3, { within_ms: 15_000 });
  const mistyped = await cosiva(['vehicle', 'exclude', 'AIV11', '--url', platform.url]);
  assert.equal(mistyped.code, 2);
  assert.match(mistyped.stderr, /did you mean AIV1\?/);
});
