// Figures 16 and 17 with the simulator as the pivot: the next position is requested from the vehicle's own program, the
// move commanded, and the actual position requested from the GVS, over the broker; without a GVS from the plant.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { cosiva, eventually, Platform, work_folder } from './lib/platform.mjs';

const names = ['dead_reckoning', 'reset_rule', 'arc_kalman'];
const moves = ['compare', ...names, '--mode', 'predict-then-move', '--step', '0.2', '--json'];

/** A line of steps.csv: {run, step, actual_x_m, …}. */
const rows_of = (csv) => {
  const [head, ...lines] = csv.trim().split('\n').map((line) => line.split(','));
  return lines.map((line) => Object.fromEntries(head.map((name, at) => [name, name === 'time' ? line[at] : Number(line[at])])));
};

/** The result's own figures follow from its steps: mean error, variance and precision of the article. */
const check = (out, result, source, actual) => {
  const rows = rows_of(readFileSync(path.join(out, 'steps.csv'), 'utf8'));
  assert.ok(rows.length >= 9, `${rows.length} steps`);
  for (const one of result.algorithms) {
    assert.equal(one.failed, null);
    assert.equal(one.iterations, rows.length, 'one iteration per move');
    const errors = rows.map((row) => Math.hypot(row[`${one.name}_x_m`] - row.actual_x_m, row[`${one.name}_y_m`] - row.actual_y_m));
    const mean = errors.reduce((sum, error) => sum + error, 0) / errors.length;
    assert.ok(Math.abs(one.mean_m - mean) < 1e-4, `${one.name}: mean ${one.mean_m}, of the steps ${mean}`);
    const below = errors.filter((error) => error < 0.01).length / errors.length;
    assert.ok(Math.abs(one.precision - below) < 1e-9, `${one.name}: precision ${one.precision}, of the steps ${below}`);
    assert.ok(mean < 0.05, `${one.name}: ${mean} m, after moves of 0.2 m`);
  }
  // Each estimate is of the position after the move: the positions before and after are a move apart.
  for (let at = 1; at < rows.length; ++at) {
    if (rows[at].run !== rows[at - 1].run) continue;
    const moved = Math.hypot(rows[at].actual_x_m - rows[at - 1].actual_x_m, rows[at].actual_y_m - rows[at - 1].actual_y_m);
    assert.ok(moved > 0.15 && moved < 0.22, `step ${at} moved ${moved} m`);
  }
  const calls = readFileSync(path.join(out, 'calls.txt'), 'utf8').trim().split('\n').map((line) => line.split(' ').slice(1).join(' '));
  assert.match(calls[0], /^Simulator -> CoSiVA\/AIV1: move\(0\.200 m\)$/, 'the vehicle comes to rest first');
  const kinds = [/nextEstimatedPosition\(dead_reckoning, reset_rule, arc_kalman\)$/, /PE1 = /, /PE2 = /, /PE3 = /, /: move\(/, /: moved$/, /actualAIVposition\(CoSiVA\/AIV1\)$/, /PA = /];
  calls.slice(1, 17).forEach((line, at) => assert.match(line, kinds[at % 8], `figure 17, message ${at + 1}`));
  assert.equal(calls.filter((line) => line.startsWith(`Simulator -> ${actual}: actualAIVposition`)).length, rows.filter((row) => row.run === 1).length);
  const settings = JSON.stringify(result);
  assert.ok(settings.includes(source), `the report names its source: ${source}`);
};

test('cosiva compare --mode predict-then-move in virtual time', { timeout: 120_000 }, async (t) => {
  const folder = work_folder(t);
  const out = path.join(folder, 'out');
  const args = [...moves, '--distance', '2', '--runs', '2', '--out', out];
  const first = await cosiva(args, { cwd: folder });
  assert.equal(first.code, 0, first.stderr);
  const result = JSON.parse(first.stdout);
  check(out, result, "the plant's ground truth", 'plant');
  const again = await cosiva([...args, '--threads', '1'], { cwd: folder });
  assert.equal(again.stdout, first.stdout, 'same seed, same bytes, on any number of threads');
});

test('cosiva compare --mode predict-then-move --live takes actual positions from the GVS', { timeout: 170_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 1, args: ['--gvs'] });
  const broker = `127.0.0.1:${await platform.broker_port()}`;
  await eventually('the camera watches', async () => (await platform.snapshot()).gvs?.state === 'watching', { within_ms: 30_000 });
  const out = path.join(platform.folder, 'out');
  const done = await cosiva([...moves, '--live', '--url', platform.url, '--broker', broker, '--distance', '2', '--runs', '1', '--out', out]);
  assert.equal(done.code, 0, done.stderr.slice(-3000));
  check(out, JSON.parse(done.stdout), 'GVS', 'GVS');
  const continuous = await cosiva(['qualify', 'arc_kalman', '--live', '--url', platform.url, '--broker', broker, '--distance', '2', '--runs', '1', '--json']);
  assert.equal(continuous.code, 0, continuous.stderr.slice(-3000));
  assert.match(continuous.stdout, /GVS, .*cosiva\/v1\/gvs\/detections/);
  // Afterwards the vehicle drives on.
  const before = (await platform.snapshot()).aivs[0];
  await eventually('it drives on', async () => {
    const now = (await platform.snapshot()).aivs[0];
    return Math.hypot(now.x - before.x, now.y - before.y) > 0.3;
  }, { within_ms: 20_000 });
});

test('cosiva qualify --mode predict-then-move reports errors', { timeout: 60_000 }, async (t) => {
  const refused = async (args, pattern) => {
    const response = await cosiva(['qualify', '--mode', 'predict-then-move', ...args], { cwd: work_folder(t) });
    assert.equal(response.code, 2, `${args}: ${response.stderr}`);
    assert.match(response.stderr, pattern, `${args}`);
  };
  await refused(['arc_smoother'], /arc_smoother: predict-then-move estimates on board, before each move/);
  await refused(['arc_kalman', '--step', '0'], /a move is from 0\.02 to 10 m/);
  await refused(['arc_kalman', '--pitch', '1'], /--pitch: the option has no meaning with --mode predict-then-move/);
  await refused(['arc_kalman', '--live', '--ground-truth', 'a/b'], /requests each actual position from the GVS/);
  const without = await cosiva(['qualify', 'arc_kalman', '--step', '0.2'], { cwd: work_folder(t) });
  assert.equal(without.code, 2);
  assert.match(without.stderr, /--step: the option has a meaning with --mode predict-then-move only/);
});
