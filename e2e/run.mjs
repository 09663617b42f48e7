// node run.mjs FILE: runs a file of tests as `node --test` does. What they say of milliseconds and of patience holds on a
// machine that runs: where one fails, and a witness saw that the machine itself stood still meanwhile (a virtual machine whose
// host has no time for it), it is run again once the machine runs. One that fails on a machine that runs has failed.
import { spawn } from 'node:child_process';
import { parseArgs } from 'node:util';
import { sleep } from './lib/platform.mjs';
import { Witness } from './lib/witness.mjs';

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    'still-ms': { type: 'string', default: '200' }, // in all; no test minds less
    'quiet-ms': { type: 'string', default: '15000' }, // next to none of it stood still, before it is run again
    tries: { type: 'string', default: '4' },
  },
});
const [still_ms_max, quiet_ms, tries] = [Number(values['still-ms']), Number(values['quiet-ms']), Number(values.tries)];
const quiet_still_ms_max = 50; // a machine is never quite still
const patience_ms = 300_000; // bad minutes of a host were seen four in a row
if (positionals.length !== 1) {
  console.error('usage: node run.mjs [--still-ms N] [--quiet-ms N] [--tries N] FILE');
  process.exit(2);
}

function run_once(file) {
  const child = spawn(process.execPath, ['--test', '--test-reporter=spec', file], { stdio: 'inherit' });
  return new Promise((resolve) => child.on('exit', (code) => resolve(code ?? 1)));
}

async function until_it_runs(witness) {
  const end = Date.now() + patience_ms;
  do {
    witness.reset();
    await sleep(quiet_ms);
  } while (witness.still_ms > quiet_still_ms_max && Date.now() < end);
}

const witness = new Witness();
let code = 1;
for (let attempt = 1; attempt <= tries; ++attempt) {
  if (attempt > 1) await until_it_runs(witness);
  witness.reset();
  const began = Date.now();
  code = await run_once(positionals[0]);
  if (code === 0) break;
  const { still_ms, longest_ms } = witness;
  console.log(`run ${attempt} of at most ${tries} failed; the machine stood still for ${still_ms} ms of its ${Date.now() - began} ms, at most ${longest_ms} ms at once`);
  if (still_ms <= still_ms_max) break;
}
witness.end();
process.exitCode = code;
