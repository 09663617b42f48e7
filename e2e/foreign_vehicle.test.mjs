// A third-party vehicle joins the zone over MQTT: it is shown, is given orders, and drives one lap of the circuit,
// alone.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Bus } from './lib/bus.mjs';
import { Circuit } from './lib/circuit.mjs';
import { follow, snapshot_of, start_foreign_vehicle, stranger } from './lib/foreign_vehicle.mjs';
import { notice, open_operator, row } from './lib/page.mjs';
import { cosiva_binary, eventually, free_port, lacet4_length_m, Program, start_broker, work_folder, zone_file } from './lib/platform.mjs';

test('a third-party vehicle drives a lap alone', { timeout: 180_000 }, async (t) => {
  const circuit = await Circuit.load();
  const broker = await start_broker(t);
  const port = await free_port();
  const bus = await Bus.open(t, broker.port, ['uagv/#']);
  // No plant runs here: the zone's file is published as by any physical side (A22).
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

/** The page of a third-party vehicle: shown like any other, stopped and restarted; what it cannot do is reported. */
async function operate(t, url) {
  const speed = async () => (await snapshot_of(url)).aivs.find(({ id }) => id === stranger).speed;
  await t.test('its page shows it, and commands it', async (t) => {
    const page = await open_operator(t, await open_browser(t), { url, aivs: 1 });
    const it = row(page, stranger);
    await eventually('its state is shown', async () => /normal/i.test(await it.getByTestId('state').innerText()));
    await it.getByRole('button', { name: /^Select/ }).click();
    await page.waitForFunction((id) => document.querySelector(`[data-aiv="${id}"]`).className.includes('selected'), stranger);
    await it.getByRole('button', { name: /^Stop/ }).click();
    await eventually('it is stopped', async () => (await speed()) === 0, { within_ms: 5_000 });
    await eventually('the page shows it', async () => /stopped/i.test(await it.getByTestId('state').innerText()), { within_ms: 5_000 });
    await it.getByRole('button', { name: /^Slow/ }).click();
    assert.match(await notice(page, /001/), /slow/i);
    await it.getByRole('button', { name: /^Restart/ }).click();
    await eventually('it drives again', async () => (await speed()) > 0, { within_ms: 5_000 });
    assert.deepEqual(page.script_errors, []);
    await page.close();
  });
}
