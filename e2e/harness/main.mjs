// scripts/chaos: faults in random order against the real platform, for a given time.
import { mkdtempSync, rmSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { parseArgs } from 'node:util';
import { cosiva_binary } from '../lib/platform.mjs';
import { cases, plan_of } from './cases.mjs';
import { Harness } from './harness.mjs';
import { again_in_own_network, in_own_network, netem_obstacle } from './netem.mjs';
import { make_plan } from './plan.mjs';
import { Scope } from './scope.mjs';

const usage = `Usage: scripts/chaos [--minutes M] [--seed S] [--aivs N] [--case NAME] [--plan] [--keep]
Kills, freezes and disconnects the parts of a real platform, and fills its disk, in random order; checks what must always hold.
  --minutes M   how long, without the last episode's checks; without: 2
  --seed S      repeats the schedule of a run; without: a random one, which is printed
  --aivs N      how many vehicles; without: 3
  --case NAME   a fixed schedule instead of a random one; --case list names them
  --plan        print the schedule only
  --keep        keep the logs and the output of the parts; they are always kept after a violation
Exit status: 0 nothing found, 1 a violation, 2 a wrong option.`;

const number = { type: 'string' }; // parseArgs has no numbers
let values;
try {
  ({ values } = parseArgs({ options: { minutes: number, seed: number, case: number, aivs: number, plan: { type: 'boolean' }, keep: { type: 'boolean' }, help: { type: 'boolean', short: 'h' } } }));
} catch (error) {
  console.error(`${error.message}\n${usage}`);
  process.exit(2);
}
if (values.help) {
  console.log(usage);
  process.exit(0);
}
if (values.case !== undefined && !(values.case in cases)) {
  for (const [name, { why }] of Object.entries(cases)) console.log(`${name.padEnd(22)} ${why}`);
  process.exit(values.case === 'list' ? 0 : 2);
}
const minutes = Number(values.minutes ?? (values.case ? 10 : 2));
const seed = Number(values.seed ?? Math.floor(Math.random() * 2 ** 31));
const aivs = Number(values.aivs ?? 3);
if (!(minutes > 0) || !Number.isInteger(seed) || seed < 0 || !Number.isInteger(aivs) || aivs < 1 || aivs > 12) {
  console.error(usage);
  process.exit(2);
}

const obstacle = in_own_network() ? '' : netem_obstacle();
if (obstacle === '' && !in_own_network() && !values.plan) process.exit(again_in_own_network());
const plan = values.case ? plan_of(values.case) : make_plan({ seed, minutes, aivs, netem: obstacle === '' });
if (values.plan) {
  console.log(JSON.stringify(plan, null, 1));
  process.exit(0);
}

console.log(`${values.case ? `case ${values.case}` : `seed ${seed}, ${minutes} min`}, ${aivs} AIVs, ${cosiva_binary()}`);
console.log(obstacle === '' ? 'tc netem: in a network namespace of its own' : `tc netem: not permitted here (${obstacle})`);
const scope = new Scope();
const folder = mkdtempSync(path.join(os.tmpdir(), 'cosiva-chaos-'));
const harness = new Harness(scope, { plan, seed, aivs, minutes, folder, disk_megabytes: cases[values.case]?.disk_megabytes, print: (text) => console.log(text) });
let failure = null;
const run = harness.run().catch((error) => (failure = error));
for (const signal of ['SIGINT', 'SIGTERM']) process.once(signal, () => Object.assign(harness, { minutes: 0, interrupted: true }));
await run;
await scope.end();
if (failure) harness.violation('the run was ended by an error', { error: failure.stack });
const keep = values.keep || harness.violations.length > 0;
if (!keep) rmSync(folder, { recursive: true, force: true });
console.log(`injected: ${Object.entries(harness.counts).sort().map(([what, count]) => `${what} ${count}`).join(', ')}`);
for (const { at_s, episode, what } of harness.violations) console.log(`violation at ${at_s.toFixed(2)} s, episode ${episode}: ${what}`);
if (harness.slowest_durable_ms !== undefined) console.log(`the slowest Stop was durable ${harness.slowest_durable_ms} ms after its response`);
if (keep) console.log(`logs: ${folder}`);
const verdict = `${harness.violations.length === 0 ? 'passed' : `${harness.violations.length} violations`}${harness.interrupted ? ', interrupted' : ''}`;
console.log(values.case ? `case ${values.case}: ${verdict}` : `seed ${seed}: ${verdict}; scripts/chaos --seed ${seed} --minutes ${minutes} --aivs ${aivs} repeats the schedule`);
process.exit(harness.violations.length === 0 ? 0 : 1);
