// An operator changes batteries by hand and confirms this on the page: the requested battery is an alarm and a form
// there, a click confirms it, the run begins, and its curve grows.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { open_operator } from './lib/page.mjs';
import { artefacts_dir, cosiva_binary, eventually, Platform, Program } from './lib/platform.mjs';

const axe_source = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
async function assert_open_to_all(page) {
  await page.evaluate(axe_source);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
  assert.deepEqual(violations.map(({ id, help, nodes }) => `${id}: ${help} ${nodes[0].html.slice(0, 160)}`), []);
}

test('an operator changes a battery, confirms it on the page, and watches the test', { timeout: 180_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 1 });
  const page = await open_operator(t, await open_browser(t), platform, { reducedMotion: 'reduce' });
  const panel = page.getByTestId('battery');
  const slot = panel.locator('[data-testid=battery-test] [data-vehicle="CoSiVA/AIV1"]');

  await t.test('without a test the view teaches how to begin one', async () => {
    await page.getByTestId('open-battery').click();
    await panel.getByText(/cosiva battery fleet --live/).waitFor({ timeout: 10_000 });
    await assert_open_to_all(page);
    await page.getByTestId('open-battery').click();
  });

  const live = new Program(
    t, cosiva_binary(),
    ['battery', 'sampled', '--live', '--by-hand', '--url', platform.url, '--broker', `127.0.0.1:${await platform.broker_port()}`, '--battery', 'red', '--floor', '5'],
    { name: 'cosiva battery' },
  );

  await t.test('a wanted battery is an alarm, whatever the page shows', async () => {
    await page.getByTestId('open-alarms').click();
    await page.getByTestId('alarms').getByText('Battery red is requested').waitFor({ timeout: 30_000 });
    await page.getByTestId('open-battery').click();
    await panel.getByTestId('battery-change').waitFor({ timeout: 5_000 });
    await eventually('the test is shown to wait', async () => (await slot.getAttribute('data-phase')) === 'changing');
    await assert_open_to_all(page);
  });

  await t.test('a battery that is not full is refused, with the reason next to the form', async () => {
    const form = panel.getByTestId('battery-change');
    await form.getByText('Battery details').click();
    await form.getByLabel('Charge [%]').fill('80');
    await form.getByRole('button', { name: /battery red, AIV1/ }).click();
    await panel.getByText(/was refused: it is not full: 80/).waitFor({ timeout: 5_000 });
  });

  await t.test('a click confirms the right one, and the run begins', async () => {
    const form = panel.getByTestId('battery-change');
    // The form may have been drawn anew since.
    if (!(await form.getByLabel('Charge [%]').isVisible())) await form.getByText('Battery details').click();
    await form.getByLabel('Charge [%]').fill('100');
    await eventually('the button is free', () => form.getByRole('button', { name: /battery red, AIV1/ }).isEnabled());
    await form.getByRole('button', { name: /battery red, AIV1/ }).click();
    await eventually('it runs', async () => (await slot.getAttribute('data-phase')) === 'running');
    assert.equal(await panel.getByTestId('battery-change').count(), 0, 'nothing is wanted any more');
    assert.deepEqual((await platform.snapshot()).battery.changes, []);
  });

  await t.test('its curves grow', async () => {
    const charge = panel.locator('[data-testid=battery-curves][data-vehicle="CoSiVA/AIV1"] svg[role=img]').first();
    const points = async () => Number(await charge.getAttribute('data-points'));
    const before = await eventually('there is a curve', points);
    await eventually('it grows', async () => (await points()) >= before + 3, { within_ms: 15_000 });
    assert.match(await charge.getAttribute('aria-label'), /^Charge of AIV1: from .* to .* in /);
    const known = await platform.get('battery/curves/CoSiVA%2FAIV1');
    assert.ok(known.points.length > 2, 'the server knows it too: a page that is opened later begins with it');
  });

  for (const theme of ['light', 'dark']) {
    await t.test(`it can be read in ${theme}`, async () => {
      await page.emulateMedia({ colorScheme: theme, reducedMotion: 'reduce' });
      await page.evaluate((wanted) => (location.hash = `#panel=battery&theme=${wanted}`), theme);
      // Drawn in its colours completely, before they are evaluated.
      await page.waitForFunction((wanted) => document.documentElement.dataset.theme === wanted, theme);
      await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
      await page.waitForTimeout(400);
      await assert_open_to_all(page);
      await page.screenshot({ path: path.join(artefacts_dir, `battery_view_${theme}.png`) });
    });
  }

  await t.test('a test that is given up stays, as that', async () => {
    await live.stop();
    await panel.getByText(/^Given up at/).waitFor({ timeout: 10_000 });
    assert.equal(await slot.getAttribute('data-phase'), 'ended');
  });
  assert.deepEqual(page.script_errors, []);
});
