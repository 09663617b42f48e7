// A vehicle of another make joins the zone by MQTT: it is shown, is given orders, and drives round the circuit; alone first,
// then among our own AIVs, where no two bodies may ever touch on the virtual side (the plant does not know the stranger).
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Bus } from './lib/bus.mjs';
import { bodies_touch, Circuit } from './lib/circuit.mjs';
import { start_foreign_vehicle } from './lib/foreign_vehicle.mjs';
import { notice, open_operator, row } from './lib/page.mjs';
import { cosiva_binary, eventually, free_port, lacet4_length_m, Platform, Program, sleep, start_broker, work_folder, zone_file } from './lib/platform.mjs';

const stranger = 'RobotCompany/001';
const body = { length: 0.2, width: 0.12 };
const snapshot_of = async (url) => (await fetch(`${url}/api/v1/snapshot`, { signal: AbortSignal.timeout(2_000) })).json();

/** Follows one twin until it has driven `distance_m`; answers the sections it was seen on. `each` sees every snapshot. */
async function follow(url, id, distance_m, within_ms, each = () => {}) {
  const end = Date.now() + within_ms;
  const sections = new Set();
  let driven = 0;
  let last = null;
  while (driven < distance_m) {
    assert.ok(Date.now() < end, `${id} drove ${driven.toFixed(1)} of ${distance_m.toFixed(1)} m within ${within_ms} ms`);
    const snapshot = await snapshot_of(url);
    const aiv = snapshot.aivs.find((candidate) => candidate.id === id);
    assert.ok(aiv, `${id} is shown`);
    assert.equal(aiv.connection, 'ONLINE');
    each(snapshot);
    if (aiv.section !== null) sections.add(aiv.section);
    if (last) driven += Math.hypot(aiv.x - last.x, aiv.y - last.y);
    last = aiv;
    await sleep(40);
  }
  return sections;
}

test('a foreign vehicle drives a lap alone', { timeout: 180_000 }, async (t) => {
  const circuit = await Circuit.load();
  const broker = await start_broker(t);
  const port = await free_port();
  const bus = await Bus.open(t, broker.port, ['uagv/#']);
  // No plant runs here: the zone's file comes as any physical side hands it over (A22).
  await bus.client.publishAsync('cosiva/v1/zone/toml', readFileSync(zone_file('lacet4')), { qos: 1, retain: true });
  new Program(t, cosiva_binary(), ['server', '--broker', broker.address, '--port', String(port)], { cwd: work_folder(t) });
  const url = `http://127.0.0.1:${port}`;
  await eventually('the server shows the zone', async () => (await (await fetch(`${url}/api/v1/zone`)).json())?.name === 'lacet4');

  await start_foreign_vehicle(t, { broker_port: broker.port, circuit, waypoint: circuit.behind('east', 0.1) });
  await eventually('it is shown', async () => (await snapshot_of(url)).aivs.some((aiv) => aiv.id === stranger), { within_ms: 5_000 });
  await operate(t, url);
  const sections = await follow(url, stranger, lacet4_length_m + 0.5, 120_000);
  assert.deepEqual([...sections].sort(), ['east', 'loop_ne', 'loop_nw', 'loop_se', 'loop_sw', 'north', 'south', 'west']);

  const { matched, physical, virtual, orphans } = (await snapshot_of(url)).bijection;
  assert.deepEqual([physical, virtual, matched], [1, 1, 1]);
  assert.deepEqual(orphans, []);
});

test('a foreign vehicle drives a lap among our own, and nobody touches anybody', { timeout: 300_000 }, async (t) => {
  const circuit = await Circuit.load();
  const platform = await Platform.up(t, { aivs: 3 });
  const free = await a_place_apart(platform, circuit);
  await start_foreign_vehicle(t, { broker_port: await platform.broker_port(), circuit, waypoint: free, speed_mps: 0.5 });
  await eventually('it is shown', async () => (await platform.snapshot()).aivs.length === 4, { within_ms: 5_000 });

  const touched = [];
  const before = await distances(platform);
  const sections = await follow(platform.url, stranger, lacet4_length_m, 200_000, ({ aivs }) => {
    aivs.forEach((a, i) => aivs.slice(i + 1).forEach((b) => {
      if (bodies_touch(a, b, body.length, body.width)) touched.push(`${a.id} and ${b.id} at ${a.section} ${a.s}`);
    }));
  });
  assert.equal(sections.size, 8);
  assert.deepEqual(touched, []);
  const after = await distances(platform);
  for (const id of before.keys()) assert.notEqual(after.get(id), before.get(id), `${id} went on, too`);
});

/** The page of a vehicle that nobody here built: shown like any other, stopped and let go; what it cannot do is said. */
async function operate(t, url) {
  const speed = async () => (await snapshot_of(url)).aivs.find(({ id }) => id === stranger).speed;
  await t.test('its page shows it, and commands it', async (t) => {
    const page = await open_operator(t, await open_browser(t), { url, aivs: 1 });
    const it = row(page, stranger);
    await eventually('its state is shown', async () => /normal/i.test(await it.getByTestId('state').innerText()));
    await it.getByRole('button', { name: /^Select/ }).click();
    await page.waitForFunction((id) => document.querySelector(`[data-aiv="${id}"]`).className.includes('selected'), stranger);
    await it.getByRole('button', { name: /^Stop/ }).click();
    await eventually('it stands', async () => (await speed()) === 0, { within_ms: 5_000 });
    await eventually('the page says so', async () => /stopped/i.test(await it.getByTestId('state').innerText()), { within_ms: 5_000 });
    await it.getByRole('button', { name: /^Slow/ }).click();
    assert.match(await notice(page, /001/), /slow/i);
    await it.getByRole('button', { name: /^Restart/ }).click();
    await eventually('it drives again', async () => (await speed()) > 0, { within_ms: 5_000 });
    assert.deepEqual(page.script_errors, []);
    await page.close();
  });
}

/** A waypoint on a loop, a metre from everybody. */
async function a_place_apart(platform, circuit) {
  const { aivs } = await platform.snapshot();
  const apart = (waypoint) => Math.min(...aivs.map((aiv) => Math.hypot(aiv.x - waypoint.x, aiv.y - waypoint.y)));
  const best = circuit.waypoints
    .map((waypoint, index) => ({ index, waypoint, apart: apart(waypoint) }))
    .filter(({ waypoint }) => waypoint.section.startsWith('loop_'))
    .sort((a, b) => b.apart - a.apart)[0];
  assert.ok(best.apart > 0.8, `the freest waypoint is ${best.apart} m from an AIV`);
  return best.index;
}

async function distances(platform) {
  return new Map((await platform.snapshot()).aivs.map((aiv) => [aiv.id, `${aiv.lastNode} ${aiv.orderUpdateId}`]));
}
