// A campaign that is killed is resumed, and threads and ranks change nothing in the result.
import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { existsSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { cosiva_binary, eventually, work_folder } from './lib/platform.mjs';

// The ranks' common memory is a file in TMPDIR; as root, Open MPI requires two confirmations.
const environment = { ...process.env, OMPI_ALLOW_RUN_AS_ROOT: '1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: '1' };
const run = async (program, options) => {
  try {
    const { stdout, stderr } = await promisify(execFile)(program, options, { env: environment, maxBuffer: 1 << 26 });
    return { code: 0, stdout, stderr };
  } catch (error) {
    return { code: error.code, stdout: error.stdout, stderr: error.stderr };
  }
};
const binary = cosiva_binary();
const campaign = (...options) => run(binary, ['campaign', ...options]);
const on_ranks = (n, ...options) => run('mpirun', ['--oversubscribe', '-n', String(n), binary, 'campaign', ...options]);

/** A few seconds of one core: long enough to be killed before its end. */
const plan = `runs = 300
distance_m = 100
[vary]
algorithm = ["arc_kalman", "reset_rule"]
pitch_m = { from = 0.2, to = 3.2, steps = 5, log = true }
missed_ratio = [0.0, 0.2, 0.4]
`;
const files = ['campaign.sqlite', 'campaign.state', 'cells.csv', 'report.html', 'result.json', 'runs.csv'];

function same_files(one, other) {
  assert.deepEqual(readdirSync(other).sort(), files);
  for (const file of files)
    assert.ok(readFileSync(path.join(one, file)).equals(readFileSync(path.join(other, file))), `${file} differs`);
}

test('killed and started again it is resumed, with the same files as an undisturbed run', async (t) => {
  const folder = work_folder(t);
  const file = path.join(folder, 'plan.toml');
  const [calm, killed] = [path.join(folder, 'calm'), path.join(folder, 'killed')];
  writeFileSync(file, plan);
  const undisturbed = await campaign(file, '--out', calm, '--threads', '1');
  assert.equal(undisturbed.code, 0, undisturbed.stderr);
  const state = path.join(killed, 'campaign.state');
  let lives = 0;
  for (let size = 0; lives < 3; lives++) {
    const child = spawn(binary, ['campaign', file, '--out', killed, '--threads', '1'], { stdio: 'ignore' });
    const ended = new Promise((resolve) => child.on('exit', resolve));
    // As soon as it has made progress, but before it is done.
    await eventually('it gets on', () => existsSync(state) && statSync(state).size > size + 1000, { within_ms: 60_000 });
    size = statSync(state).size;
    child.kill('SIGKILL');
    await ended;
    assert.ok(!existsSync(path.join(killed, 'result.json')), 'killed before its end');
    // In addition its last line is cut, as by a full disk or a power failure.
    if (lives === 1) writeFileSync(state, readFileSync(state).subarray(0, size - 7));
    if (lives === 1) size -= 7;
  }
  const last = await campaign(file, '--out', killed);
  assert.equal(last.code, 0, last.stderr);
  assert.match(last.stderr, /campaign continues: \d+ of \d+ units are finished/);
  same_files(calm, killed);
  // A finished campaign has nothing to do, and prints the same again.
  const again = await campaign(file, '--out', killed);
  assert.equal(again.stdout, last.stdout);
  same_files(calm, killed);
});

test('any number of ranks and threads gives the same files, and only one of them prints', async (t) => {
  const folder = work_folder(t);
  const file = path.join(folder, 'plan.toml');
  writeFileSync(file, plan.replace('runs = 300', 'runs = 6'));
  const one = path.join(folder, 'one');
  const alone = await campaign(file, '--out', one, '--threads', '1', '--json');
  assert.equal(alone.code, 0, alone.stderr);
  const threads = await campaign(file, '--out', path.join(folder, 'threads'), '--threads', '3', '--json');
  assert.equal(threads.stdout, alone.stdout);
  same_files(one, path.join(folder, 'threads'));
  for (const ranks of [2, 4]) {
    const out = path.join(folder, `ranks${ranks}`);
    const many = await on_ranks(ranks, file, '--out', out, '--threads', '1', '--json');
    assert.equal(many.code, 0, many.stderr);
    assert.equal(JSON.parse(many.stdout).digest, JSON.parse(alone.stdout).digest); // two outputs would not be one document
    same_files(one, out);
  }
});

test('an obstacle to a campaign is reported with what to do, and every rank ends with status 2', async (t) => {
  const folder = work_folder(t);
  const file = path.join(folder, 'plan.toml');
  const out = path.join(folder, 'out');
  writeFileSync(file, plan.replace('runs = 300', 'runs = 2').replace('distance_m = 100', 'distance_m = 10'));
  assert.equal((await campaign(file, '--out', out)).code, 0);
  // The state of another plan.
  writeFileSync(file, plan.replace('runs = 300', 'runs = 3').replace('distance_m = 100', 'distance_m = 10'));
  for (const tell of [() => campaign(file, '--out', out), () => on_ranks(2, file, '--out', out)]) {
    const { code, stderr } = await tell();
    assert.equal(code, 2, stderr);
    assert.match(stderr, /campaign\.state:1: the state is of a campaign with another plan, .*--anew/);
    assert.equal(stderr.match(/another plan/g).length, 1, 'one voice');
  }
  assert.equal((await campaign(file, '--out', out, '--anew')).code, 0);
  // A state file that is damaged in its middle part.
  const state = path.join(out, 'campaign.state');
  const bytes = readFileSync(state);
  bytes[200] ^= 1;
  writeFileSync(state, bytes);
  const damaged = await campaign(file, '--out', out);
  assert.equal(damaged.code, 2);
  assert.match(damaged.stderr, /campaign\.state:\d+: the state is damaged/);
  // A folder that cannot be.
  rmSync(out, { recursive: true });
  writeFileSync(out, 'a file');
  const taken = await campaign(file, '--out', out);
  assert.equal(taken.code, 2);
  assert.match(taken.stderr, /out: the folder cannot be made/);
});
