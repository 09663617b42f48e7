// Many zones in one process, on threads and on MPI's ranks: one result, and one output.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { cosiva_binary, work_folder } from './lib/platform.mjs';

// The ranks' common memory is a file in TMPDIR; as root, Open MPI requires two confirmations.
const environment = { ...process.env, OMPI_ALLOW_RUN_AS_ROOT: '1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: '1' };
const run = async (program, options) => {
  try {
    const { stdout, stderr } = await promisify(execFile)(program, options, { env: environment });
    return { code: 0, stdout, stderr };
  } catch (error) {
    return { code: error.code, stdout: error.stdout, stderr: error.stderr };
  }
};
const binary = cosiva_binary();
const traffic = ['traffic', '--zones', '2*lacet4,indus8,lacet4', '--aivs', '8', '--jobs-per-hour', '90', '--duration', '600'];
const on_ranks = (n, options) => run('mpirun', ['--oversubscribe', '-n', String(n), binary, ...options]);

test('any number of ranks and threads gives the digest of one process, and only one of them prints', async () => {
  const one = await run(binary, [...traffic, '--json']);
  assert.equal(one.code, 0, one.stderr);
  const expected = JSON.parse(one.stdout);
  assert.equal(expected.site.aivs, 32);
  assert.ok(expected.site.zones.every((zone) => zone.collisions === 0 && zone.stuck === 0));
  assert.ok(expected.site.zones.reduce((sum, zone) => sum + zone.came, 0) > 4, one.stdout);
  const threads = await run(binary, [...traffic, '--threads', '3', '--json']);
  assert.equal(JSON.parse(threads.stdout).digest, expected.digest);
  for (const ranks of [2, 4]) {
    const many = await on_ranks(ranks, [...traffic, '--json']);
    assert.equal(many.code, 0, many.stderr);
    const told = JSON.parse(many.stdout); // two outputs would not be one document
    assert.equal(told.ranks, ranks);
    assert.equal(told.digest, expected.digest);
    assert.deepEqual(told.site, expected.site);
  }
});

test('an error in a site is reported with file and line, and every rank ends with status 2', async (t) => {
  const file = path.join(work_folder(t), 'site.toml');
  writeFileSync(file, '[[zone]]\nfile = "lacet4"\n[[zone]]\nfile = "indus8"\n[[transfer_point]]\nfrom = "lacet4/S1"\nto = "indus9"\n');
  for (const tell of [() => run(binary, ['traffic', '--zones', file]), () => on_ranks(2, ['traffic', '--zones', file])]) {
    const { code, stderr } = await tell();
    assert.equal(code, 2, stderr);
    assert.match(stderr, /site\.toml:\d+: transfer_point\[1\]\.to: .*"indus8" meant\?/);
  }
  writeFileSync(file, '[[zone]]\nfile = "lacet4"\naivs = 5000\n');
  const { code, stderr } = await on_ranks(2, ['traffic', '--zones', file]);
  assert.equal(code, 2, stderr);
  assert.match(stderr, /zone 'lacet4': .* has room for/);
});
