// The tests' own judge: what fails is run again where the machine stood still, and nowhere else.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { eventually, sleep, source_dir, work_folder } from './lib/platform.mjs';
import { Witness } from './lib/witness.mjs';

/** Runs a file whose test passes from its `good`-th run on; how often it ran and what came of it. */
function judged(t, good, ...args) {
  const folder = work_folder(t);
  const runs = path.join(folder, 'runs');
  writeFileSync(runs, '');
  const file = path.join(folder, 'some.test.mjs');
  writeFileSync(file, `import { appendFileSync, readFileSync } from 'node:fs';
import { test } from 'node:test';
appendFileSync(${JSON.stringify(runs)}, 'x');
test('some', () => { if (readFileSync(${JSON.stringify(runs)}).length < ${good}) throw new Error('not yet'); });
`);
  const env = { ...process.env };
  delete env.NODE_TEST_CONTEXT; // it is a runner of its own
  const ended = spawnSync(process.execPath, [path.join(source_dir, 'e2e/run.mjs'), '--quiet-ms', '0', ...args, file], { encoding: 'utf8', env });
  return { code: ended.status, runs: readFileSync(runs).length, words: ended.stdout };
}

const [ran, stood_still] = [['--still-ms=1e9'], ['--still-ms=-1']];

test('what passes is run once, wherever', (t) => {
  for (const machine of [ran, stood_still]) {
    const { code, runs } = judged(t, 1, ...machine);
    assert.deepEqual([code, runs], [0, 1]);
  }
});

test('what fails on a machine that ran has failed', (t) => {
  const { code, runs, words } = judged(t, 2, ...ran);
  assert.deepEqual([code, runs], [1, 1], words);
  assert.match(words, /stood still for \d+ ms of its \d+ ms/);
});

test('what fails where the machine stood still is run again, so often and no more', (t) => {
  const cured = judged(t, 3, ...stood_still);
  assert.deepEqual([cured.code, cured.runs], [0, 3], cured.words);
  const never = judged(t, 99, ...stood_still, '--tries', '2');
  assert.deepEqual([never.code, never.runs], [1, 2], never.words);
});

test('the witness tells for how long nobody ran', async (t) => {
  const witness = new Witness();
  t.after(() => witness.end());
  await sleep(500);
  witness.reset();
  process.kill(witness.child.pid, 'SIGSTOP');
  await sleep(400);
  process.kill(witness.child.pid, 'SIGCONT');
  await eventually('it tells', () => witness.still_ms >= 350, { within_ms: 2_000 });
  assert.ok(witness.longest_ms >= 350);
});
