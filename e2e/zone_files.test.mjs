// Every zone file in the repository, of every format: checked and drawn, with the drawings stored for inspection.
import assert from 'node:assert/strict';
import { mkdirSync, readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { artefacts_dir, cosiva, cosiva_json, source_dir } from './lib/platform.mjs';

const folders = ['zones', 'src/zone/lif/testdata', 'src/zone/opendrive/testdata'];
/** Names of all files below a folder, as paths from it. */
function everything(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) =>
    entry.isDirectory() ? everything(path.join(folder, entry.name)).map((name) => path.join(entry.name, name)) : [entry.name],
  );
}
const is_zone = (name) => /\.(toml|lif\.json|xodr|map)$/.test(name) && !name.endsWith('.zone.toml');
const files = folders.flatMap((folder) =>
  everything(path.join(source_dir, folder))
    .filter(is_zone)
    .map((name) => path.join(folder, name)),
);

test('all files of the standards\' samples exist', () => {
  const lif = files.filter((file) => file.includes('lif/testdata') && !file.includes('written') && file.endsWith('.lif.json'));
  assert.equal(lif.filter((file) => !file.includes('2.0-draft')).length, 22);
  assert.equal(lif.filter((file) => file.includes('2.0-draft')).length, 19);
  assert.equal(files.filter((file) => file.includes('opendrive/testdata')).length, 9);
});

for (const file of files) {
  test(`${file} is checked and drawn`, async () => {
    const full = path.join(source_dir, file);
    const checked = await cosiva_json(['zone', 'check', full, '--json']);
    assert.ok(checked.sections > 0 && checked.length_m > 0);
    const pictures = path.join(artefacts_dir, 'zones');
    mkdirSync(pictures, { recursive: true });
    const target = path.join(pictures, path.basename(file).replace(/\.(toml|lif\.json|xodr|map)$/, ''));
    const drawn = await cosiva(['zone', 'show', full, '--svg', `${target}.svg`]);
    assert.equal(drawn.code, 0, drawn.stderr);
    assert.match(readFileSync(`${target}.svg`, 'utf8'), /<\/svg>\s*$/);
    const painted = await cosiva(['zone', 'show', full, '--png', `${target}.png`]);
    assert.equal(painted.code, 0, painted.stderr);
    assert.equal(readFileSync(`${target}.png`).subarray(1, 4).toString(), 'PNG');
  });
}
