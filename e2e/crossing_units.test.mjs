// Crossing units live: each is a program, is drawn next to its crossing, and raises an alarm when it becomes unresponsive.
// Datagrams without the key are counted and ignored; a frozen unit holds no vehicle.
import assert from 'node:assert/strict';
import { createHmac, randomBytes } from 'node:crypto';
import dgram from 'node:dgram';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Truth } from './lib/bus.mjs';
import { finally_do } from './lib/cleanup.mjs';
import { open_operator, pixel_of } from './lib/page.mjs';
import { artefacts_dir, cosiva, descendants, eventually, Platform, sleep, work_folder } from './lib/platform.mjs';

const group = '239.192.7.51';
const crossings = ['X1', 'X2', 'X3', 'X4'];

/** A status of the unit of X1 that reports a vehicle of nowhere in the crossing, as one datagram. */
function status_datagram(key, sequence) {
  const message = {
    headerId: sequence, timestamp: new Date().toISOString(), mapId: 'lacet4', manufacturer: 'CoSiVA.unit', serialNumber: 'X1', crossing: 'X1', x: 0, y: 0, online: true,
    holders: [{ manufacturer: 'CoSiVA', serialNumber: 'NOWHERE', age: 0 }], waiting: [],
  };
  const [m, n, p] = [Buffer.from('CoSiVA.unit'), Buffer.from('X1'), Buffer.from(JSON.stringify(message))];
  const head = Buffer.alloc(26);
  head.write('CV2X\x01\x02', 'latin1');
  head.writeBigUInt64BE(2n ** 62n, 6);
  head.writeBigUInt64BE(BigInt(sequence), 14);
  head[22] = m.length;
  head[23] = n.length;
  head.writeUInt16BE(p.length, 24);
  const body = Buffer.concat([head, m, n, p]);
  return Buffer.concat([body, createHmac('sha256', key).update(body).digest()]);
}

async function sender(t, port) {
  const socket = dgram.createSocket({ type: 'udp4', reuseAddr: true });
  finally_do(t, () => socket.close());
  await new Promise((resolve) => socket.bind(0, resolve));
  socket.setMulticastInterface('127.0.0.1');
  return (bytes) => new Promise((resolve, reject) => socket.send(bytes, port, group, (error) => (error ? reject(error) : resolve())));
}

const counters_of = (platform, name) => {
  const log = readFileSync(path.join(platform.log_dir, `${name}.log`), 'utf8');
  return /direct link: (\d+) sent, (\d+) accepted, (\d+) forged/.exec(log)?.slice(1).map(Number);
};

test('crossing units are programs that are drawn, watched and started again', { timeout: 170_000 }, async (t) => {
  const file = path.join(work_folder(t), 'v2x.key');
  const key = randomBytes(32);
  writeFileSync(file, key, { mode: 0o600 });
  const port = 21_000 + (process.pid % 20_000);
  const args = ['--crossing-units', 'all', '--autonomy', 'negotiate', '--v2x-multicast', `${group}:${port}`, '--v2x-key', file, '--v2x-interface', 'lo'];
  const platform = await Platform.up(t, { aivs: 4, args });
  const unit = async (crossing) => (await platform.snapshot()).units.find((one) => one.crossing === crossing);
  const page = await open_operator(t, await open_browser(t), platform, { viewport: { width: 1366, height: 768 } });
  const truth = await Truth.follow(t, await platform.broker_port());

  await t.test('all are online, and report vehicles in their crossings', async () => {
    await eventually('four units online', async () => {
      const { units } = await platform.snapshot();
      return units.length === 4 && units.every(({ state, age_ms }) => state === 'online' && age_ms < 2_000);
    });
    for (const crossing of crossings) await page.waitForSelector(`[data-testid=unit-${crossing}]`, { timeout: 5_000 });
    const held = await eventually('a vehicle in a crossing', async () => (await platform.snapshot()).units.find(({ holders }) => holders.length > 0), { within_ms: 30_000 });
    assert.match(held.holders[0].id, /^CoSiVA\/AIV\d$/);
    await eventually('it is on the page', () => page.evaluate(() => [...document.querySelectorAll('[data-testid^=unit-]')].some((one) => /held by AIV\d/.test(one.getAttribute('aria-label')))), { within_ms: 20_000, every_ms: 100 });
    // A vehicle in the crossing has a tip of its own.
    await eventually('the tip of a crossing tells what its unit reports', async () => {
      for (const { x, y } of (await platform.snapshot()).units) {
        const at = await pixel_of(page, platform, x, y);
        await page.mouse.move(at.x, at.y);
        await sleep(100);
        const tip = page.getByTestId('map-tip');
        if ((await tip.count()) > 0 && /^Crossing X\d\s*Unit: /.test(await tip.innerText())) return true;
      }
      return false;
    });
    await page.mouse.move(5, 5);
    mkdirSync(artefacts_dir, { recursive: true });
    await page.screenshot({ path: path.join(artefacts_dir, 'crossing_units.png') });
  });

  await t.test('datagrams with another key are counted and ignored', async () => {
    const send = await sender(t, port);
    for (let i = 1; i <= 60; ++i) await send(status_datagram(randomBytes(32), i)).then(() => sleep(20));
    for (const crossing of crossings) assert.ok(!(await unit(crossing)).holders.some(({ id }) => id.includes('NOWHERE')));
  });

  await t.test('a frozen unit is drawn as unresponsive, raises an alarm, holds no vehicle, and is started again', async () => {
    const { pid } = descendants(platform.pid).find(({ argv }) => argv.includes('unit') && argv.includes('X2'));
    await platform.without_supervisor(async () => {
      process.kill(pid, 'SIGSTOP');
      await eventually('it is unresponsive', async () => (await unit('X2')).state === 'unresponsive', { within_ms: 6_000 });
      await page.waitForSelector('[data-testid=unit-X2].unresponsive', { timeout: 3_000 });
      assert.match(await page.getByTestId('unit-X2').getAttribute('aria-label'), /^Crossing X2\. Unit unresponsive for \d/);
      await page.evaluate(() => (location.hash = '#panel=alarms'));
      await page.waitForSelector('text=/No status for \\d+ s/', { timeout: 5_000 });
      await page.screenshot({ path: path.join(artefacts_dir, 'crossing_units_unresponsive.png') });
      const before = truth.latest.vehicles.map(({ distance }) => distance);
      await sleep(15_000);
      for (const [i, { number, distance }] of truth.latest.vehicles.entries()) assert.ok(distance > before[i] + 0.5, `AIV${number} drove ${distance - before[i]} m in 15 s`);
      process.kill(pid, 'SIGKILL');
      process.kill(pid, 'SIGCONT');
    });
    await eventually('it is online again', async () => (await unit('X2')).state === 'online', { within_ms: 20_000 });
  });

  truth.assert_no_collision();
  await platform.stop();
  for (const name of ['aiv1', 'unit-X1']) {
    const [sent, accepted, forged] = counters_of(platform, name);
    assert.ok(sent > 50 && accepted > 100, `${name}: ${sent} sent, ${accepted} accepted`);
    assert.equal(forged, 60, name);
  }
});

test('a scenario adds a unit, and switches one off and on; a unit that is ended signs off', { timeout: 90_000 }, async (t) => {
  const folder = work_folder(t);
  const file = path.join(folder, 'units.toml');
  const step = (t_s, crossing, on) => `[[at]]\nt_s = ${t_s}\nunit = { crossing = "${crossing}", on = ${on} }\n`;
  writeFileSync(file, `name = "units"\naivs = 2\ncrossing_units = ["X1"]\n${step(2, 'X1', false)}${step(3, 'X3', true)}${step(8, 'X1', true)}`);
  const platform = await Platform.up(t, { aivs: 2, args: ['--headless', '--scenario', file] });
  const states = async () => Object.fromEntries((await platform.snapshot()).units.map(({ crossing, state }) => [crossing, state]));
  const become = (wanted, within_ms) => eventually(JSON.stringify(wanted), async () => { assert.deepEqual(await states(), wanted); return true; }, { within_ms, every_ms: 100 });
  await become({ X1: 'unresponsive', X3: 'online' }, 30_000);
  await become({ X1: 'online', X3: 'online' }, 15_000);
  const seen = [];
  const journal = path.join(folder, 'unit.journal');
  const alone = await cosiva(['unit', '--zone', 'lacet4', '--crossing', 'X4', '--broker', `127.0.0.1:${await platform.broker_port()}`, '--duration', '3', '--record', journal, '--json'], {
    on_start: () => seen.push(become({ X1: 'online', X3: 'online', X4: 'online' }, 2_900)),
  });
  assert.equal(alone.code, 0, alone.stderr);
  assert.deepEqual(await Promise.all(seen), [true]);
  await become({ X1: 'online', X3: 'online' }, 1_000);
  const replay = await cosiva(['replay', journal]);
  assert.equal(replay.code, 0, replay.stderr);
  assert.match(`${replay.stdout}${replay.stderr}`, /the digest equals that of the recorded run/);
});

test('a unit of an unknown crossing is refused before anything starts', async () => {
  const up = await cosiva(['up', '--headless', '--crossing-units', 'X9']);
  assert.equal(up.code, 2);
  assert.match(up.stderr, /lacet4 has no crossing 'X9'.*X1, X2, X3, X4/s);
  const alone = await cosiva(['unit', '--zone', 'lacet4', '--crossing', 'X9', '--duration', '1']);
  assert.equal(alone.code, 2);
  assert.match(alone.stderr, /has no crossing of this name/);
});
