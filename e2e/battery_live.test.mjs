// A fleet's battery test over the wire while its processes die: a vehicle's program, the server, and the test itself
// are killed and restarted, and one vehicle is lost for good. No measurement is lost.
import assert from 'node:assert/strict';
import { readFileSync, existsSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { finally_do } from './lib/cleanup.mjs';
import { alive, cosiva, cosiva_binary, eventually, Platform, Program, send_signal, sleep, source_dir } from './lib/platform.mjs';

/**
 * The Leaf's cell, small enough to last a minute and a half, and with a resistance small enough for this rate of
 * discharge.
 */
function small_battery(folder) {
  const type = JSON.parse(readFileSync(path.join(source_dir, 'batteries/leaf33.json'), 'utf8'));
  type.name = 'small';
  for (const key of ['series_ohm', 'fast_ohm', 'slow_ohm']) type[key] = type[key].map((ohm) => ohm * 0.02);
  const file = path.join(folder, 'small.json');
  writeFileSync(file, JSON.stringify(type));
  return file;
}

test('cosiva battery fleet --live', { timeout: 400_000 }, async (t) => {
  const platform = await Platform.up(t, { args: ['--respawn', '1'] });
  const broker = `127.0.0.1:${await platform.broker_port()}`;
  const told = path.join(platform.folder, 'told.txt');
  const state = path.join(platform.folder, 'test.json');
  const out = path.join(platform.folder, 'out');
  const args = [
    'battery', 'fleet', '--live', '--url', platform.url, '--broker', broker, '--aivs', '4', '--type', small_battery(platform.folder),
    '--series', '1', '--scale', '0.0011', '--floor', '40', '--lost-after', '8', '--state', state, '--out', out, '--json',
    '--notify', `tell() { printf '%s\\n' "$1" >> ${told}; }; tell`,
  ];
  const running = (program) => eventually('all four run', () => /run 1 of 1: [1-9]/.test(program.words), { within_ms: 60_000 });

  const first = new Program(t, cosiva_binary(), args, { name: 'cosiva battery' });
  await running(first);

  await platform.kill_child(/aiv\D*2$/i);
  await sleep(4_000);
  await platform.kill_child(/server/i);
  await sleep(3_000);

  // The test itself: its state at the last sample is in its file.
  process.kill(first.pid, 'SIGKILL');
  await first.ended;
  assert.ok(existsSync(state), 'the state is there');
  const second = new Program(t, cosiva_binary(), args, { name: 'cosiva battery' });
  await eventually('it goes on', () => second.words.includes('continues from'), { within_ms: 20_000 });

  // Its program dies whenever the supervisor has started it again: a vehicle that is lost for good.
  const killing = setInterval(() => {
    const lost = platform.children().find(({ name }) => /aiv\D*3$/i.test(name));
    if (lost?.pid > 0 && alive(lost.pid)) send_signal(lost.pid, 'SIGKILL');
  }, 20);
  finally_do(t, () => clearInterval(killing));

  const { code } = await second.ended;
  clearInterval(killing);
  assert.equal(code, 0, second.words.slice(-3000));
  const result = JSON.parse(readFileSync(path.join(out, 'result.json'), 'utf8'));
  assert.equal(result.batteries.length, 4, 'a record for each');
  const by_vehicle = new Map(result.batteries.map((one) => [one.vehicle, one]));
  assert.equal(by_vehicle.get('AIV3').stop, 'lost');
  assert.equal(by_vehicle.get('AIV3').ended, false, 'known to last longer, not counted as an end');
  assert.equal(result.failed, 1);
  const ends = [1, 2, 4].map((number) => by_vehicle.get(`AIV${number}`));
  for (const one of ends) {
    assert.equal(one.stop, 'floor', JSON.stringify(one));
    assert.ok(Math.abs(one.charge_end - 0.4) < 0.01, `the floor: ${one.charge_end}`);
    assert.ok(one.distance_m > 1, `it drove ${one.distance_m} m`);
    assert.ok(one.autonomy_s > by_vehicle.get('AIV3').autonomy_s, 'the lost vehicle had been stopped earlier');
  }
  // Equal batteries on equal vehicles, although one vehicle's program was killed in between.
  const seconds = ends.map((one) => one.autonomy_s);
  assert.ok(Math.max(...seconds) / Math.min(...seconds) < 1.5, `autonomies ${seconds}`);
  assert.ok(!existsSync(state), 'a finished test leaves no state behind');
  assert.ok(existsSync(path.join(out, 'report.html')));
  assert.match(readFileSync(told, 'utf8'), /put battery 1, full, into AIV1/, 'the operator was notified by the command');
  const snapshot = await platform.snapshot();
  assert.equal(new Set(snapshot.aivs.map((aiv) => aiv.id)).size, 4, 'no twin was lost or doubled');
});

test('cosiva battery fleet --live reports errors', { timeout: 120_000 }, async (t) => {
  const nobody = await cosiva(['battery', 'fleet', '--live', '--broker', '127.0.0.1:1', '--aivs', '2']);
  assert.equal(nobody.code, 2);
  assert.match(nobody.stderr, /no broker responds at this address/);
  const whole = await cosiva(['battery', 'fleet', '--live', '--whole']);
  assert.equal(whole.code, 2);
  assert.match(whole.stderr, /--whole/);
  const few = await cosiva(['battery', 'fleet', '--live', '--aivs', '3', '--vehicle', 'CoSiVA/AIV1']);
  assert.equal(few.code, 2);
  assert.match(few.stderr, /as many --vehicle/);
});
