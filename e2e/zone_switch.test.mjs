// The operator switches the zone on the page: the consequences are shown before, the result after, and the map
// follows. A zone that cannot be used changes nothing, and the reason is shown. Sections are closed, and vehicles are
// sent to stations.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { open_operator, pixel_of } from './lib/page.mjs';
import { eventually, Platform } from './lib/platform.mjs';

test('the zone is switched on the page', { timeout: 240_000 }, async (t) => {
  const platform = await Platform.up(t, { zone: 'indus8' });
  const page = await open_operator(t, await open_browser(t), platform);
  const loaded = await page.evaluate(() => performance.timeOrigin);
  const zone_state = async () => (await platform.snapshot()).zone;
  const middle = async (name) => {
    const { primitives } = await platform.get('zone');
    const { points } = primitives.find((one) => one.layer === 'road' && one.label === name);
    const [x, y] = points[Math.floor(points.length / 2)];
    return points.length > 2 ? [x, y] : [(points[0][0] + points[1][0]) / 2, (points[0][1] + points[1][1]) / 2];
  };

  await t.test('a station on the map takes the AIV that is chosen', async () => {
    const { stations } = await platform.get('zone');
    const dock = stations.find((one) => one.name === 'dock');
    await page.locator('[data-aiv="CoSiVA/AIV1"]').first().click();
    await eventually('no vehicle is on it, and its menu opens', async () => {
      const at = await pixel_of(page, platform, dock.x, dock.y);
      await page.mouse.click(at.x, at.y);
      return page.getByRole('menuitem', { name: /^Send AIV\d here$/ }).first().isVisible();
    }, { within_ms: 30_000, every_ms: 700 });
    await page.getByRole('menuitem', { name: /^Send AIV\d here$/ }).first().click();
    await eventually('a vehicle is sent', async () => (await platform.snapshot()).aivs.some((one) => one.mission.kind === 'go' && one.mission.to === 'dock'), { within_ms: 5_000 });
  });

  await t.test('the consequences of a switch are shown, and then its result', async () => {
    await page.getByTestId('zone-chooser').click();
    await page.getByTestId('zone-switch-lacet4').click();
    await page.getByTestId('zone-confirm').getByText('4 AIVs stop').waitFor();
    assert.equal((await zone_state()).name, 'indus8', 'nothing is switched before it is confirmed');
    await page.getByTestId('zone-switch-now').click();
    await page.getByTestId('zone-switched').getByText(/\d snapped, .*the first moved after/).waitFor({ timeout: 20_000 });
    assert.equal((await zone_state()).name, 'lacet4');
    await page.getByTestId('zone-chooser').getByText('lacet4').waitFor();
    assert.equal(await page.evaluate(() => performance.timeOrigin), loaded, 'the page is the same');
    assert.equal(await page.locator('[data-aiv]').count() >= 4, true, 'no twin vanishes');
  });

  await t.test('a file that cannot be used is refused with its line, and is an alarm', async () => {
    await page.getByTestId('zone-file').setInputFiles({ name: 'broken.toml', mimeType: 'text/plain', buffer: Buffer.from('name = 3\n') });
    await page.getByTestId('zone-switch-now').click();
    await page.getByTestId('zone-refused').getByText('broken.toml:1').waitFor();
    assert.equal((await zone_state()).name, 'lacet4');
    assert.match((await zone_state()).refused.why, /format_version|name/);
    await page.keyboard.press('Escape');
    await page.keyboard.press('Escape');
    await page.getByTestId('open-alarms').click();
    await page.getByText(/broken\.toml was refused/).first().waitFor();
    await page.getByTestId('open-alarms').click();
  });

  await t.test('a section is closed by pressing it, and opened again', async () => {
    await page.waitForTimeout(700); // the map has come to rest
    await page.getByTestId('tool-close-sections').click();
    const [x, y] = await middle('loop_ne');
    const at = await pixel_of(page, platform, x, y);
    await page.mouse.click(at.x, at.y);
    await eventually('it is closed', async () => (await zone_state()).closed.includes('loop_ne'), { within_ms: 4_000 });
    await page.waitForTimeout(500); // the page has received it
    await page.mouse.click(at.x, at.y);
    await eventually('it is open', async () => !(await zone_state()).closed.includes('loop_ne'), { within_ms: 4_000 });
    await page.keyboard.press('Escape');
  });

  assert.deepEqual(page.script_errors, []);
});
