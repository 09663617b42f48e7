// Figures 16 and 17 on a running platform: real vehicle processes run the algorithms and receive requests over the
// broker, the plant supplies the ground truth, and the result has the form of any other qualification.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { cosiva, cosiva_binary, eventually, free_port, Platform, Program, work_folder } from './lib/platform.mjs';

/** The end of the platform's output, so that a failure shows its reason. */
const tail = (text) => text.slice(-3000);

test('cosiva compare --live', { timeout: 180_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2, args: ['--respawn', '1'] });
  const broker = `127.0.0.1:${await platform.broker_port()}`;
  const out = path.join(platform.folder, 'out');
  const live = ['--live', '--url', platform.url, '--broker', broker];
  const names = ['dead_reckoning', 'reset_rule', 'arc_kalman', 'arc_smoother'];
  const args = ['compare', ...names, ...live, '--vehicle', 'AIV1', '--vehicle', 'CoSiVA/AIV2', '--distance', '3', '--runs', '3', '--out', out, '--json'];

  // One vehicle's program dies in its run: that run is driven anew.
  const program = new Program(t, cosiva_binary(), args, { name: 'cosiva compare' });
  let stdout = '';
  program.spawned.stdout.on('data', (chunk) => (stdout += chunk));
  await eventually('they drive', () => / [1-9]\d* % of the distance, .* left/.test(program.words), { within_ms: 30_000 });
  await platform.kill_child(/aiv\D*2$/i);
  const { code } = await program.ended;
  assert.equal(code, 0, tail(program.words));
  assert.match(program.words, /CoSiVA\/AIV2 repeats run \d: /);

  const result = JSON.parse(stdout);
  assert.equal(result.what, 'live on lacet4');
  assert.deepEqual(result.algorithms.map((one) => one.name), names);
  for (const one of result.algorithms) {
    assert.equal(one.failed, null);
    assert.equal(one.rmse_by_run_m.length, 3, `${one.name}: a vote per run`);
    assert.ok(one.iterations > 150, `${one.name}: ${one.iterations} moves`);
    // On a busy machine a stamp may be some milliseconds off: 30 mm are 60 of them.
    assert.ok(one.rmse_m > 0 && one.rmse_m < 0.03, `${one.name}: ${one.rmse_m}`);
  }
  assert.equal(result.comparisons.length, 6, 'all pairs, on the same inputs');
  for (const file of ['report.html', 'result.json', 'runs.csv', 'ground_truth.tum', 'arc_kalman.tum', 'arc_smoother.zip'])
    assert.ok(existsSync(path.join(out, file)), file);
  assert.deepEqual(JSON.parse(readFileSync(path.join(out, 'result.json'), 'utf8')), result);
  // The ground truth in the file is of the circuit: lacet4 lies within 2 m of its centre.
  const ground_truth = readFileSync(path.join(out, 'ground_truth.tum'), 'utf8').trim().split('\n').map((line) => line.split(' ').map(Number));
  assert.ok(ground_truth.length > 50 && ground_truth.every(([, x, y]) => Math.hypot(x, y) < 2), 'where it was');

  const snapshot = await platform.snapshot();
  assert.equal(snapshot.aivs.length, 2, 'no twin was lost or doubled');

  const stranger = await cosiva(['qualify', ...live, '--vehicle', 'AIV9', '--distance', '1', '--runs', '1', '--timeout', '2']);
  assert.equal(stranger.code, 2);
  assert.match(stranger.stderr, /CoSiVA\/AIV9: no response for 2 s; the vehicle may be offline/);
  const elsewhere = await cosiva(['qualify', ...live, '--ground-truth', 'site/camera', '--distance', '1', '--runs', '1', '--timeout', '2']);
  assert.equal(elsewhere.code, 2);
  assert.match(elsewhere.stderr, /no actual position of the vehicle on site\/camera for 2 s/);
});

test('cosiva qualify --live reports errors', { timeout: 60_000 }, async (t) => {
  const refused = async (args, pattern) => {
    const said = await cosiva(['qualify', '--live', ...args], { cwd: work_folder(t) });
    assert.equal(said.code, 2, `${args}: ${said.stderr}`);
    assert.match(said.stderr, pattern, `${args}`);
  };
  await refused(['magic'], /magic: there is no such algorithm; there are dead_reckoning, .*ufir/);
  await refused(['ekf', '--pitch', '0.3'], /--pitch: the option has no meaning with --live/);
  await refused(['ekf', '--recording', 'somewhere'], /--recording: the option has no meaning with --live/);
  await refused(['ekf', '--vehicle', 'no/such/name'], /AIV3, or MANUFACTURER\/SERIAL/);
  await refused(['ekf', '--vehicle', 'AIV1', '--vehicle', 'CoSiVA/AIV1'], /given twice/);
  await refused(['particles', '--particles', '9000'], /on board there are at most 5000/);
  await refused(['ekf', '--rate', '1000'], /0\.1 to 50 requests per second/);
  await refused(['ekf', '--broker', `127.0.0.1:${await free_port()}`], /no broker responds at this address: is the platform running/);
  const few = await cosiva(['compare', '--live', 'ekf']);
  assert.equal(few.code, 2);
  assert.match(few.stderr, /a comparison needs at least two/);
});
