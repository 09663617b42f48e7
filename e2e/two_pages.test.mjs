// Two pages on one platform stay in step, over a server that dies and comes back, and what was added is there again.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open_browser, open_page } from './lib/browser.mjs';
import { ask } from './lib/map.mjs';
import { eventually, Platform } from './lib/platform.mjs';

test('two pages show the same', { timeout: 150_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2 });
  const browser = await open_browser(t);
  const pages = [await open_page(t, browser, platform.url), await open_page(t, browser, platform.url, { colorScheme: 'dark' })];
  const [one, other] = pages;
  const live = (within) => Promise.all(pages.map((page) => page.waitForSelector('[data-testid=link][data-phase=live]', { timeout: within })));
  await live(10_000);

  await t.test('a command given on one is followed on the other', async () => {
    await one.getByRole('button', { name: 'Slow AIV2', exact: true }).click();
    for (const page of pages) await page.waitForSelector('[data-aiv="CoSiVA/AIV2"][data-state=slow]', { timeout: 15_000 });
  });

  await t.test('a person added on one stands on the other, and is removed there', async () => {
    const added = await ask(platform, 'POST', 'things', { kind: 'person', x: 0, y: 1.2 });
    assert.equal(added.status, 201);
    for (const page of pages) await page.locator(`[data-thing="${added.body.id}"]`).waitFor({ timeout: 3_000 });
    await other.getByRole('button', { name: `Remove ${added.body.id}` }).click();
    for (const page of pages) await page.locator(`[data-thing="${added.body.id}"]`).waitFor({ state: 'detached', timeout: 3_000 });
  });

  await t.test('a priority typed on one stands on the other', async () => {
    await one.getByLabel('Priority of AIV1').fill('7');
    await one.getByLabel('Priority of AIV1').press('Enter');
    await other.waitForFunction(() => document.querySelector('[data-aiv="CoSiVA/AIV1"] input[inputmode=numeric]')?.value === '7', null, { timeout: 5_000 });
    assert.equal((await platform.aiv(1)).priority, 7);
  });

  await t.test('both say that the server died, and recover with what was there', async () => {
    const person = (await ask(platform, 'POST', 'things', { kind: 'person', x: 0, y: 1.2 })).body.id;
    const aiv = (await ask(platform, 'POST', 'things', { kind: 'aiv' })).body.id;
    await one.locator(`[data-aiv="CoSiVA.virtual/${aiv}"]`).waitFor({ timeout: 5_000 });
    // It comes back within a second or two, so both are watched from before.
    const said = Promise.all(pages.map((page) => page.getByTestId('banner').waitFor({ timeout: 10_000 })));
    await platform.kill_child(/server/i);
    await said;
    await live(30_000);
    for (const page of pages) {
      await page.getByTestId('banner').waitFor({ state: 'detached', timeout: 5_000 });
      await page.locator(`[data-thing="${person}"]`).waitFor({ timeout: 5_000 });
      await page.locator(`[data-aiv="CoSiVA.virtual/${aiv}"]`).waitFor({ timeout: 15_000 });
    }
    assert.equal((await platform.aiv(1)).priority, 7);
    await eventually('all matched again', async () => (await platform.snapshot()).bijection.matched === 2, { within_ms: 20_000 });
  });
  for (const page of pages) assert.deepEqual(page.script_errors, []);
});
