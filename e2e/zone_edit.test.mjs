// Tags and beacons edited on the page are in force on the vehicles, can be undone, and are saved with the zone's file.
import assert from 'node:assert/strict';
import { copyFileSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Truth } from './lib/bus.mjs';
import { place } from './lib/clover.mjs';
import { open_operator, pixel_of, tab_to } from './lib/page.mjs';
import { cosiva_json, eventually, Platform, work_folder, zone_file } from './lib/platform.mjs';

test('tags and beacons are edited on the page', { timeout: 240_000 }, async (t) => {
  const folder = work_folder(t);
  const file = path.join(folder, 'my_lacet4.toml');
  copyFileSync(zone_file('lacet4'), file);
  const original = readFileSync(file, 'utf8');
  const platform = await Platform.up(t, { zone: file, folder });
  const ground_truth = await Truth.follow(t, await platform.broker_port());
  const page = await open_operator(t, await open_browser(t), platform);
  const tags = async () => (await platform.get('zone')).tags;
  const tag = async (number) => (await tags()).find((one) => one.number === number);
  const choose = (number) => page.getByTestId('tag-choice').selectOption(String(number));
  const whole = async () => ({ tags: await tags(), pitch: (await platform.get('zone')).beacons.pitch_m });
  const first = await whole();

  await page.getByTestId('tool-edit-tags').click();

  await t.test('a tag that got another number is reported under it by the vehicle that passes', async () => {
    const old = await tag(1);
    await choose(1);
    await page.getByTestId('tag-number').fill('77');
    await page.getByTestId('tag-number').press('Enter');
    const renamed = await eventually('tag 77 is there', () => tag(77), { within_ms: 4_000 });
    assert.ok(Math.hypot(renamed.x - old.x, renamed.y - old.y) < 1e-6);
    assert.equal(await tag(1), undefined);
    const aiv = await eventually('a vehicle passes it', async () => (await platform.snapshot()).aivs.find((one) => one.lastTag === 77), { within_ms: 40_000, every_ms: 50 });
    assert.ok(aiv.section === renamed.section || aiv.sinceTag_m < 0.5, `at ${aiv.section} ${aiv.s}`);
  });

  await t.test('a tag dragged on the map is read at its new position, and rectifies there', async () => {
    const old = await tag(6);
    const wanted = place(old.section, old.s + (old.s > 1 ? -0.3 : 0.3));
    const from = await pixel_of(page, platform, old.x, old.y);
    const to = await pixel_of(page, platform, wanted.x, wanted.y);
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    await page.mouse.move((from.x + to.x) / 2, (from.y + to.y) / 2, { steps: 5 });
    await page.mouse.move(to.x, to.y, { steps: 5 });
    await page.mouse.up();
    const moved = await eventually('tag 6 has moved', async () => {
      const now = await tag(6);
      return Math.abs(now.s - old.s) > 0.2 && now;
    }, { within_ms: 4_000 });
    assert.ok(Math.hypot(moved.x - wanted.x, moved.y - wanted.y) < 0.03, `tag 6 at ${moved.x}, ${moved.y} instead of ${wanted.x}, ${wanted.y}`);
    const aiv = await eventually('a vehicle has just passed it', async () => (await platform.snapshot()).aivs.find((one) => one.lastTag === 6 && one.sinceTag_m < 0.2 && one.speed > 0.1), { within_ms: 60_000, every_ms: 30 });
    // The vehicle reports how far behind the tag is: with the tag's new position that gives its actual position.
    const estimated = place(moved.section, moved.s + aiv.sinceTag_m);
    const really = ground_truth.vehicle(aiv.number);
    assert.ok(Math.hypot(estimated.x - really.x, estimated.y - really.y) < 0.12, `estimated ${estimated.x}, ${estimated.y}; really ${really.x}, ${really.y}`);
  });

  await t.test('a tag is added and another taken away, by keyboard alone', async () => {
    const before = (await tags()).length;
    await page.evaluate(() => document.activeElement?.blur());
    await tab_to(page, /#tag-choice$/);
    await page.keyboard.type('9');
    await tab_to(page, /^New /);
    await page.keyboard.press('Enter');
    await eventually('there is one more', async () => (await tags()).length === before + 1, { within_ms: 4_000 });
    await eventually('it is the one that is chosen', async () => (await page.getByTestId('tag-choice').inputValue()) === '1', { within_ms: 4_000 });
    await tab_to(page, /^Remove #/);
    await page.keyboard.press('Enter');
    await eventually('there are as many as before', async () => (await tags()).length === before, { within_ms: 4_000 });
    await choose(9);
    await page.getByTestId('tag-choice').focus();
    await tab_to(page, /^Remove #/);
    await page.keyboard.press('Enter');
    await eventually('tag 9 is gone', async () => !(await tag(9)), { within_ms: 4_000 });
  });

  await t.test('the beacons get another pitch', async () => {
    await page.getByTestId('beacon-pitch').fill('0.25');
    await page.getByTestId('beacon-pitch').press('Enter');
    await eventually('the pitch is 0.25 m', async () => (await platform.get('zone')).beacons.pitch_m === 0.25, { within_ms: 4_000 });
  });

  await t.test('everything can be undone to how it was, and done again', async () => {
    const edited = await whole();
    const { undo } = (await platform.snapshot()).zoneEdits;
    assert.ok(undo >= 5, `${undo} edits to undo`);
    for (let left = undo; left > 0; left--) {
      await page.getByRole('button', { name: 'Undo', exact: true }).click();
      await eventually(`${left - 1} edits left`, async () => (await platform.snapshot()).zoneEdits.undo === left - 1, { within_ms: 4_000, every_ms: 20 });
    }
    assert.deepEqual(await whole(), first);
    assert.equal((await platform.snapshot()).zoneEdits.unsaved, false);
    for (let done = 1; done <= undo; done++) {
      await page.keyboard.press('Control+Shift+Z');
      await eventually(`${done} edits again`, async () => (await platform.snapshot()).zoneEdits.undo === done, { within_ms: 4_000, every_ms: 20 });
    }
    assert.deepEqual(await whole(), edited);
  });

  await t.test('it is saved with the zone, in its own file, and that file holds', async () => {
    assert.equal(readFileSync(file, 'utf8'), original, 'nothing is written before it is requested');
    await page.waitForSelector('[data-testid=unsaved]', { timeout: 4_000 });
    await page.getByTestId('save-zone').click();
    await page.waitForSelector('[data-testid=unsaved]', { state: 'detached', timeout: 4_000 });
    const saved = readFileSync(file, 'utf8');
    assert.notEqual(saved, original);
    assert.equal((await (await fetch(`${platform.url}/api/v1/zone/file`)).text()).trim(), saved.trim());
    assert.match(saved, /number = 77/);
    assert.match(saved, /CircuitLacet4/, 'the words of the file stay');
    const checked = await cosiva_json(['zone', 'check', file, '--json']);
    assert.equal(checked.zone, 'lacet4');
    assert.equal(checked.tags, (await tags()).length);
  });

  await t.test('all vehicles drove on through every edit', async () => {
    for (const number of [1, 2, 3, 4]) await ground_truth.moves(number, 30_000);
    ground_truth.assert_no_collision();
  });
  assert.deepEqual(page.script_errors, []);
});
