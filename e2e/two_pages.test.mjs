// Two pages on one platform show the same; when the server is killed both report it, recover by themselves, and added
// objects and settings are still there.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Truth } from './lib/bus.mjs';
import { aiv_row, open_operator, press_map, row } from './lib/page.mjs';
import { eventually, Platform } from './lib/platform.mjs';

test('two pages stay synchronised, and survive a restart of their server', { timeout: 180_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 3 });
  const ground_truth = await Truth.follow(t, await platform.broker_port());
  const browser = await open_browser(t);
  const one = await open_operator(t, browser, platform);
  const other = await open_operator(t, browser, platform, { colorScheme: 'dark' });
  const in_both = (what, question, within_ms = 4_000) => Promise.all([one, other].map((page) => eventually(what, () => question(page), { within_ms })));
  const virtualObjects = () => platform.snapshot().then((snapshot) => snapshot.virtualObjects.map(({ id }) => id).sort());

  await t.test('what one commands, both show', async () => {
    await ground_truth.moves(2, 30_000);
    await one.getByRole('button', { name: 'Stop AIV2', exact: true }).click();
    await ground_truth.stands(2, 3_000);
    await in_both('AIV2 stopped', async (page) => /Stopped/.test(await aiv_row(page, 2).getByTestId('state').innerText()));
    await in_both('the command is materialised', (page) => aiv_row(page, 2).locator('[data-command-state=materialised]').count());
    await other.getByRole('button', { name: 'Restart AIV2', exact: true }).click();
    await ground_truth.moves(2, 30_000);
    await in_both('AIV2 drives', async (page) => !/Stopped/.test(await aiv_row(page, 2).getByTestId('state').innerText()), 20_000);
  });

  await t.test('what one adds, edits and ranks, both show', async () => {
    await other.getByTestId('tool-add-person').click();
    await press_map(other, platform, 0.75, 0.75);
    await in_both('the person', (page) => page.locator('[data-virtual-object^=P]').count());
    await one.getByTestId('tool-add-obstacle').click();
    await press_map(one, platform, -0.75, 0.75);
    await in_both('the obstacle', (page) => page.locator('[data-virtual-object^=O]').count());
    await one.getByTestId('tool-add-aiv').click();
    await one.getByTestId('add-anywhere').click();
    await in_both('the virtual AIV', (page) => row(page, 'CoSiVA.virtual/V1').count(), 10_000);
    await other.locator('[data-aiv="CoSiVA/AIV3"]').getByTestId('priority').fill('42');
    await other.locator('[data-aiv="CoSiVA/AIV3"]').getByTestId('priority').press('Enter');
    await in_both('priority 42', async (page) => (await aiv_row(page, 3).getByTestId('priority').inputValue()) === '42');
    await one.getByTestId('tool-edit-tags').click();
    await one.getByTestId('tag-choice').selectOption('12');
    await one.getByTestId('tag-number').fill('55');
    await one.getByTestId('tag-number').press('Enter');
    await other.getByTestId('tool-edit-tags').click();
    await in_both('tag 55', (page) => page.getByTestId('tag-choice').locator('option[value="55"]').count());
    await in_both('it is not saved', (page) => page.getByTestId('unsaved').count());
  });

  const before = await virtualObjects();
  const last_trace = (await platform.get('traces')).next - 1;
  await t.test('both report that the server is gone', async () => {
    assert.equal(before.length, 2);
    // Frozen, its supervisor cannot restart it before the pages have shown the loss.
    await platform.without_supervisor(async () => {
      await platform.kill_child(/server/i);
      for (const page of [one, other]) {
        await page.waitForSelector('[data-testid=banner]', { timeout: 4_000 });
        assert.match(await page.getByTestId('banner').innerText(), /No connection to the server|server is unresponsive/);
      }
      await one.getByRole('button', { name: 'Stop AIV1', exact: true }).click();
      const said = await eventually('the page says that nothing was sent', async () => (await one.getByTestId('notice').allInnerTexts()).find((text) => /AIV1|server/.test(text)), { within_ms: 5_000 });
      assert.match(said, /server does not respond|not sent/i);
    });
  });

  await t.test('both recover by themselves, and everything is still there', async () => {
    for (const page of [one, other]) {
      await page.waitForSelector('[data-testid=link][data-phase=live]', { timeout: 30_000 });
      await page.waitForSelector('[data-testid=banner]', { state: 'detached', timeout: 5_000 });
    }
    await in_both('the person and the obstacle', async (page) => (await page.locator('[data-virtual-object]').count()) === 2, 10_000);
    await in_both('the virtual AIV', (page) => row(page, 'CoSiVA.virtual/V1').count(), 15_000);
    assert.deepEqual(await virtualObjects(), before);
    await in_both('priority 42', async (page) => (await aiv_row(page, 3).getByTestId('priority').inputValue()) === '42', 10_000);
    await in_both('tag 55, still not saved', async (page) => (await page.getByTestId('tag-choice').locator('option[value="55"]').count()) && (await page.getByTestId('unsaved').count()), 10_000);
    for (const number of [1, 2, 3]) await ground_truth.moves(number, 40_000);
  });

  await t.test('the traces of before the restart are still there, and go on', async () => {
    const { next, traces } = await platform.get(`traces?after=${last_trace}&limit=10`);
    assert.equal(traces[0].n, last_trace);
    assert.ok(next > last_trace + 1);
  });

  assert.deepEqual([...one.script_errors, ...other.script_errors], []);
  ground_truth.assert_no_collision();
});
