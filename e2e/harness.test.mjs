// scripts/chaos for a minute. The schedule is drawn from the commit's hash, so that each commit has another one and a failure
// can be repeated; the report names the seed, and COSIVA_CHAOS_SEED chooses one.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { Harness } from './harness/harness.mjs';
import { make_plan } from './harness/plan.mjs';
import { Scope } from './harness/scope.mjs';
import { source_dir } from './lib/platform.mjs';

const minutes = 1;
const aivs = 3;

/** 28 bits of the commit's hash; 1 for sources without a repository. */
function seed_of_commit() {
  try {
    const hash = execFileSync('git', ['rev-parse', 'HEAD'], { cwd: source_dir, encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] });
    return Number.parseInt(hash.slice(0, 7), 16);
  } catch {
    return 1;
  }
}

test('a minute of faults', { timeout: 500_000 }, async (t) => {
  const seed = Number(process.env.COSIVA_CHAOS_SEED ?? seed_of_commit());
  const again = `scripts/chaos --seed ${seed} --minutes ${minutes} --aivs ${aivs}`;
  t.diagnostic(again);
  const folder = mkdtempSync(path.join(os.tmpdir(), 'cosiva-chaos-'));
  const scope = new Scope();
  t.after(async () => {
    await scope.end();
    rmSync(folder, { recursive: true, force: true });
  });
  const lines = [];
  const harness = new Harness(scope, { plan: make_plan({ seed, minutes, aivs }), seed, aivs, minutes, folder, print: (text) => lines.push(text) });
  let failure = null;
  await harness.run().catch((error) => (failure = error.stack));
  const found = { violations: harness.violations, failure };
  assert.deepEqual(found, { violations: [], failure: null }, `${again}\n${lines.join('\n')}\n${harness.log_tails().join('\n')}`);
});
