// A live run over MQTT is recorded; replayed in virtual time it gives the same digest, at -O2 and at -O1 under
// sanitizers.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, truncateSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { cosiva, cosiva_binary, cosiva_json, eventually, free_port, sleep, source_dir, work_folder } from './lib/platform.mjs';

// Every existing build: their optimisation differs, their digests must not.
const binaries = [...new Set([cosiva_binary(), ...['asan', 'debug', 'release'].map((preset) => path.join(source_dir, `build/${preset}/cosiva`)).filter(existsSync)])];

test('a recorded run replays to the same digest', { timeout: 240_000 }, async (t) => {
  const folder = work_folder(t);
  const file = path.join(folder, 'run.journal');
  const port = await free_port();
  const running = cosiva_json(
    ['up', '--headless', '--zone', 'lacet4', '--aivs', '4', '--duration', '20', '--json', '--record', file, '--port', String(port), '--run-dir', `${folder}/run`, '--log-dir', `${folder}/log`],
    { cwd: folder, timeout_ms: 90_000 },
  );
  // A command from outside is an input like any other.
  await eventually('the platform responds', async () => (await fetch(`http://127.0.0.1:${port}/api/v1/snapshot`)).ok, { within_ms: 12_000 })
    .then(() => sleep(4_000))
    .then(() => fetch(`http://127.0.0.1:${port}/api/v1/commands`, { method: 'POST', headers: { 'content-type': 'application/json' }, body: '{"command":"stop","vehicle":"CoSiVA/AIV1"}' }))
    .catch(() => t.diagnostic('headless serves no HTTP here: no command was recorded'));
  const live = await running;
  assert.match(live.digest, /^[0-9a-f]+$/);
  assert.ok(readFileSync(file).length > 10_000);

  for (const binary of binaries) {
    await t.test(`by ${path.relative(source_dir, binary)}`, async () => {
      const replayed = await cosiva_json(['replay', file, '--json'], { binary });
      assert.equal(replayed.digest, live.digest);
    });
  }

  await t.test('but not once a byte of it is changed', async () => {
    const bytes = readFileSync(file);
    bytes[Math.floor(bytes.length / 2)] ^= 1;
    const damaged = path.join(folder, 'damaged.journal');
    writeFileSync(damaged, bytes);
    const result = await cosiva(['replay', damaged, '--json']);
    assert.notEqual(result.code, 0);
    assert.match(result.stderr, /damaged\.journal/);
  });

  await t.test('and a truncated journal is reported as such', async () => {
    const cut = path.join(folder, 'cut.journal');
    writeFileSync(cut, readFileSync(file));
    truncateSync(cut, readFileSync(file).length - 40);
    const result = await cosiva(['replay', cut, '--json']);
    assert.match(result.stdout + result.stderr, /truncated|cut short/i);
  });
});

test('virtual time gives the same digest every time and at every optimisation', { timeout: 240_000 }, async () => {
  const args = ['up', '--virtual-time', '--zone', 'lacet4', '--aivs', '4', '--duration', '60', '--seed', '1', '--json'];
  const digests = [];
  for (const binary of [...binaries, binaries[0]]) digests.push((await cosiva_json(args, { binary })).digest);
  assert.equal(new Set(digests).size, 1, digests.join(' '));
  const other = await cosiva_json(args.map((arg, i) => (args[i - 1] === '--seed' ? '2' : arg)));
  assert.notEqual(other.digest, digests[0], 'another seed is another run');
});
