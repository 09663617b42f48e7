// scripts/chaos for a minute, with a schedule from a random seed, which the report names; COSIVA_CHAOS_SEED repeats one.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { Harness } from './harness/harness.mjs';
import { make_plan } from './harness/plan.mjs';
import { Scope } from './harness/scope.mjs';

test('a minute of faults', { timeout: 400_000 }, async (t) => {
  const seed = Number(process.env.COSIVA_CHAOS_SEED ?? Math.floor(Math.random() * 2 ** 31));
  const again = `scripts/chaos --seed ${seed} --minutes 1 --aivs 3`;
  t.diagnostic(again);
  const folder = mkdtempSync(path.join(os.tmpdir(), 'cosiva-chaos-'));
  const scope = new Scope();
  t.after(async () => {
    await scope.end();
    rmSync(folder, { recursive: true, force: true });
  });
  const lines = [];
  const harness = new Harness(scope, { plan: make_plan({ seed, minutes: 1, aivs: 3 }), seed, aivs: 3, minutes: 1, folder, print: (text) => lines.push(text) });
  await harness.run();
  assert.deepEqual(harness.violations, [], `${again}\n${lines.join('\n')}\n${harness.violations.length > 0 ? harness.log_tails().join('\n') : ''}`);
});
