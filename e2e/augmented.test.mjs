// Virtual objects affect physical vehicles, and physical obstacles are shown virtually (A2, A3). Evaluated with the
// plant's ground truth, in which no virtual body exists.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Bus, Truth } from './lib/bus.mjs';
import { place } from './lib/clover.mjs';
import { open_operator, row } from './lib/page.mjs';
import { eventually, Platform } from './lib/platform.mjs';

const front_m = 0.1; // half a vehicle's length

test('the virtual and the physical world perceive each other', { timeout: 240_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2 });
  const broker_port = await platform.broker_port();
  const ground_truth = await Truth.follow(t, broker_port);
  const heard = { connection: [], state: [], visualization: [], order: [] };
  const stranger = await Bus.open(t, broker_port, ['uagv/v2/CoSiVA.virtual/#']);
  stranger.on_message((topic, payload) => heard[topic.split('/').at(-1)]?.push({ topic, message: JSON.parse(payload.toString()) }));
  const page = await open_operator(t, await open_browser(t), platform);

  /** A vehicle that drives in a loop, where neither a crossing nor another vehicle limits it, with space before it. */
  const driving_in_a_loop = () => eventually(
    'a vehicle drives in a loop',
    async () => {
      const { aivs } = await platform.snapshot();
      const is_alone = (aiv) => aivs.every((other) => other === aiv || Math.hypot(other.x - aiv.x, other.y - aiv.y) > 1.3);
      return aivs.find((aiv) => !aiv.augmented && aiv.section?.startsWith('loop') && aiv.s > 0.15 && aiv.s < 1.2 && aiv.speed > 0.25 && Math.abs(ground_truth.vehicle(aiv.number).speed) > 0.25 && is_alone(aiv));
    },
    { within_ms: 40_000, every_ms: 25 },
  );
  const snapshot_of = async (id) => (await platform.snapshot()).aivs.find((aiv) => aiv.id === id);
  const brakingFor = (id, virtualObject) => eventually(`${id} brakingFor ${virtualObject}`, async () => (await snapshot_of(id)).brakingFor === virtualObject, { within_ms: 3_000 });
  /** Metres from the front of a vehicle to a position, by the plant's ground truth. */
  const gap = (number, at) => Math.hypot(ground_truth.vehicle(number).x - at.x, ground_truth.vehicle(number).y - at.y) - front_m;

  await t.test('a person before a vehicle stops it; after the removal, the vehicle goes on', async () => {
    const aiv = await driving_in_a_loop();
    // So near that the vehicle has to brake at once.
    const at = place(aiv.section, aiv.s + 0.5);
    const { id } = await platform.ask('POST', 'virtual-objects', { kind: 'person', x: at.x, y: at.y });
    await ground_truth.stands(aiv.number, 4_000);
    assert.ok(gap(aiv.number, at) > 0.06 && gap(aiv.number, at) < 0.4, `the vehicle stopped ${gap(aiv.number, at)} m before the person`);
    await brakingFor(aiv.id, id);
    await page.waitForFunction((virtualObject) => /perceived by AIV/.test(document.querySelector(`[data-virtual-object="${virtualObject}"]`)?.textContent ?? ''), id, { timeout: 4_000 });
    const { x, y } = ground_truth.vehicle(aiv.number);
    await ground_truth.driven(1_200);
    assert.ok(Math.hypot(ground_truth.vehicle(aiv.number).x - x, ground_truth.vehicle(aiv.number).y - y) < 0.005, 'the vehicle stays stopped');
    await page.getByRole('button', { name: `Remove ${id}`, exact: true }).click();
    await ground_truth.moves(aiv.number, 4_000);
  });

  await t.test('a vehicle goes on by itself when a person has walked off its path', async () => {
    const aiv = await driving_in_a_loop();
    const at = place(aiv.section, aiv.s + 0.55);
    const aside = { x: at.x + 0.5 * Math.cos(at.heading - Math.PI / 2), y: at.y + 0.5 * Math.sin(at.heading - Math.PI / 2) };
    const { id } = await platform.ask('POST', 'virtual-objects', { kind: 'person', path: [[at.x, at.y], [aside.x, aside.y]], speed: 0.05, repeat: 'once' });
    await eventually('it brakes', () => Math.abs(ground_truth.vehicle(aiv.number).speed) < 0.12, { within_ms: 4_000, every_ms: 20 });
    await ground_truth.moves(aiv.number, 10_000);
    await platform.ask('DELETE', `virtual-objects/${id}`);
  });

  await t.test('a virtual AIV before a physical one makes it brake; after the removal, it goes on', async () => {
    const aiv = await driving_in_a_loop();
    const at = place(aiv.section, aiv.s + 0.8);
    const { id } = await platform.ask('POST', 'virtual-objects', { kind: 'aiv', section: at.section, s: at.s });
    const virtual = `CoSiVA.virtual/${id}`;
    await eventually('it is listed', async () => snapshot_of(virtual), { within_ms: 3_000, every_ms: 20 });
    // A stopped vehicle receives no first order.
    await eventually('it drives by an order', () => heard.state.some(({ message }) => message.orderId !== ''), { within_ms: 3_000, every_ms: 20 });
    await platform.command('stop', virtual);
    await ground_truth.stands(aiv.number, 8_000);
    const there = await snapshot_of(virtual);
    assert.equal(there.augmented, true);
    assert.ok(gap(aiv.number, there) - front_m > 0.02, `its front is ${gap(aiv.number, there) - front_m} m behind the virtual one`);
    await row(page, virtual).getByText('virtual', { exact: true }).waitFor({ timeout: 3_000 });
    assert.ok(!ground_truth.latest.vehicles.some((vehicle) => vehicle.number === there.number), 'the plant does not contain it');
    await page.getByRole('button', { name: `Remove ${id}`, exact: true }).click();
    await ground_truth.moves(aiv.number, 6_000);
  });

  await t.test('an independent client of the bus received messages of the virtual AIV as of any vehicle', async () => {
    for (const kind of ['connection', 'state', 'visualization', 'order']) assert.ok(heard[kind].length > 0, `no ${kind} of it was received`);
    const ends = heard.connection.map(({ message }) => message.connectionState);
    assert.equal(ends[0], 'ONLINE');
    await eventually('it sent OFFLINE', () => heard.connection.at(-1).message.connectionState === 'OFFLINE', { within_ms: 3_000 });
    for (const { topic, message } of [...heard.state, ...heard.visualization]) {
      const [, , manufacturer, serial] = topic.split('/');
      assert.deepEqual([message.manufacturer, message.serialNumber], [manufacturer, serial]);
    }
    const places = heard.visualization.filter(({ message }) => message.agvPosition).map(({ message }) => message.agvPosition);
    assert.ok(places.length > 3 && places.every(({ mapId }) => mapId === 'lacet4'));
    assert.ok(heard.state.some(({ message }) => message.orderId !== ''), 'it drives by orders, as any vehicle');
  });

  await t.test('a physical obstacle appears at its position, with the vehicle that detected it, and vanishes after it was removed and passed', async () => {
    const aiv = await driving_in_a_loop();
    const at = place(aiv.section, aiv.s + 0.9);
    const { id } = await platform.ask('POST', 'plant/obstacles', { x: at.x, y: at.y, radius: 0.05 });
    const seen = await eventually('its twin is there', async () => (await platform.snapshot()).obstacles.find((one) => Math.hypot(one.x - at.x, one.y - at.y) < 0.12), { within_ms: 5_000 });
    assert.ok(seen.detectedBy.includes(aiv.id), `detected by ${seen.detectedBy}`);
    await ground_truth.stands(aiv.number, 5_000);
    await page.waitForSelector(`[data-seen="${seen.id}"]`, { timeout: 4_000 });
    assert.match(await page.locator(`[data-seen="${seen.id}"]`).innerText(), new RegExp(`by AIV${aiv.number}`));
    await platform.ask('DELETE', `plant/obstacles/${id}`);
    await ground_truth.moves(aiv.number, 6_000);
    await eventually('the twin is gone', async () => (await platform.snapshot()).obstacles.length === 0, { within_ms: 15_000 });
    await page.waitForSelector(`[data-seen="${seen.id}"]`, { state: 'detached', timeout: 4_000 });
  });

  await t.test('every such effect is timed, and the virtual ones are not counted as vehicles', async () => {
    const { effects, augmented, physical } = await platform.get('bijection');
    assert.equal(physical, 2);
    assert.equal(augmented, 0);
    for (const name of ['perceived_ms', 'brakes_ms', 'shown_ms']) assert.ok(effects[name].count > 0 && effects[name].max > 0, `${name}: ${JSON.stringify(effects[name])}`);
    assert.ok(effects.brakes_ms.max < 1_000, `braking took up to ${effects.brakes_ms.max} ms`);
  });

  assert.deepEqual(page.script_errors, []);
  ground_truth.assert_no_collision();
});
