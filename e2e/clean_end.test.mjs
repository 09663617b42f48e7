// However the platform ends, it leaves no process behind, and no file but the logs that it named.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { alive, descendants, eventually, Platform, work_folder } from './lib/platform.mjs';

const files_below = (folder) => (existsSync(folder) ? readdirSync(folder, { recursive: true, withFileTypes: true }).filter((entry) => !entry.isDirectory()).map((entry) => entry.name) : []);

for (const signal of ['SIGINT', 'SIGTERM']) {
  test(`${signal} ends everything`, { timeout: 90_000 }, async (t) => {
    const folder = work_folder(t);
    const platform = await Platform.up(t, { folder });
    const family = descendants(platform.pid);
    assert.ok(family.length >= 7, `broker, plant, four AIVs and server: ${family.map(({ argv }) => argv.join(' ')).join('\n')}`);
    const { code } = await platform.stop({ signal });
    assert.ok(code === 0 || code === 130 || code === 143, `exit ${code}`);
    assert.deepEqual(family.filter(({ pid }) => alive(pid)).map(({ argv }) => argv.join(' ')), []);
    await assert.rejects(fetch(platform.url), 'no server responds any more');

    assert.deepEqual(files_below(platform.run_dir), [], 'the run folder is empty or gone');
    const outside = files_below(folder).filter((name) => !files_below(platform.log_dir).includes(name));
    assert.deepEqual(outside, []);
    assert.ok(platform.words.includes(platform.log_dir), 'it named where its logs are');
  });
}

test('the default folders are as clean', { timeout: 90_000 }, async (t) => {
  const folder = work_folder(t);
  const home = path.join(folder, 'home');
  const tmp = path.join(folder, 'tmp');
  const runtime = path.join(folder, 'runtime');
  for (const each of [home, tmp, runtime]) mkdirSync(each, { mode: 0o700 });
  const env = { ...process.env, HOME: home, TMPDIR: tmp, XDG_RUNTIME_DIR: runtime };
  delete env.XDG_STATE_HOME;
  const system_tmp = new Set(readdirSync('/tmp'));
  const platform = await Platform.up(t, { folder, own_folders: true, env });
  await platform.stop();
  // The store of a run remains, as its logs do: it is on without an option.
  assert.ok(files_below(folder).some((name) => name.endsWith('.segment')), 'the server has kept a store');
  const left = files_below(folder).filter((name) => !/\.(log|segment|lock)$/.test(name));
  assert.deepEqual(left, []);
  const new_in_tmp = readdirSync('/tmp').filter((name) => !system_tmp.has(name) && /cosiva/i.test(name) && !/e2e/.test(name));
  assert.deepEqual(new_in_tmp.filter((name) => files_below(path.join('/tmp', name)).some((file) => !file.endsWith('.log'))), []);
});

test('kill -9 of cosiva up ends its children as well', { timeout: 90_000 }, async (t) => {
  const platform = await Platform.up(t);
  const family = descendants(platform.pid);
  platform.remember_family();
  process.kill(platform.pid, 'SIGKILL');
  await eventually('all children are gone', () => family.every(({ pid }) => !alive(pid)), { within_ms: 8_000 });
});
