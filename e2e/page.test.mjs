// The operator's page on the real platform: four AIVs move, one is stopped by a click and is stopped in the plant's
// ground truth too, and goes on when commanded; the page shows when its server is gone, and recovers by itself.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open_browser, open_page } from './lib/browser.mjs';
import { Truth } from './lib/bus.mjs';
import { eventually, Platform, sleep } from './lib/platform.mjs';

const row = (page, number) => page.locator(`[data-aiv="CoSiVA/AIV${number}"]`);
const section = (page, number) => row(page, number).getByTestId('section').innerText();

test('an operator watches, stops and restarts AIVs on the page', { timeout: 180_000 }, async (t) => {
  const platform = await Platform.up(t);
  const ground_truth = await Truth.follow(t, await platform.broker_port());
  const page = await open_page(t, await open_browser(t), platform.url);

  await t.test('four AIVs are listed, live and matched', async () => {
    assert.equal(await page.title(), 'CoSiVA');
    await page.waitForSelector('[data-testid=link][data-phase=live]', { timeout: 10_000 });
    await page.waitForFunction(() => document.querySelectorAll('[data-aiv]').length === 4, null, { timeout: 10_000 });
    await page.waitForFunction(() => document.querySelector('[data-testid=matched]')?.textContent.includes('4 / 4'), null, { timeout: 10_000 });
  });

  await t.test('all four move, in the list and on the canvas', async () => {
    const before = await Promise.all([1, 2, 3, 4].map((number) => section(page, number)));
    const picture = await page.getByTestId('circuit').screenshot();
    // A vehicle may be stopped for a while before a crossing that another vehicle occupies.
    for (const number of [1, 2, 3, 4]) {
      await eventually(`AIV${number} moves in the list`, async () => (await section(page, number)) !== before[number - 1], { within_ms: 25_000 });
    }
    assert.notDeepEqual(await page.getByTestId('circuit').screenshot(), picture);
  });

  await t.test('rows that are sorted by changing values stay in place while the pointer is on one', async () => {
    await page.keyboard.press('2');
    await page.getByRole('button', { name: /^Age/ }).click();
    const order = () => page.locator('[data-row]').evaluateAll((rows) => rows.map((one) => one.dataset.row).join(' '));
    const was = await order();
    await eventually('the youngest changes', async () => (await order()) !== was, { within_ms: 15_000 });
    const seen = page.evaluate(() => new Promise((resolve) => {
      addEventListener('pointermove', () => {
        const orders = new Set();
        const look = setInterval(() => orders.add([...document.querySelectorAll('[data-row]')].map((one) => one.dataset.row).join(' ')), 25);
        setTimeout(() => resolve([...orders], clearInterval(look)), 800);
      }, { once: true });
    }));
    const [orders] = await Promise.all([seen, page.locator('[data-row]').nth(1).hover()]);
    assert.equal(orders.length, 1, `they changed places: ${orders.join(' | ')}`);
    await page.mouse.move(5, 5);
    await eventually('it is sorted again', async () => (await order()) !== orders[0], { within_ms: 15_000 });
    await page.keyboard.press('2');
  });

  await t.test('the Stop button stops the vehicle on the physical side', async () => {
    await ground_truth.moves(2, 25_000);
    await page.getByRole('button', { name: 'Stop AIV2', exact: true }).click();
    await ground_truth.stands(2, 3_000);
    await page.waitForFunction(() => /Stopped/.test(document.querySelector('[data-aiv="CoSiVA/AIV2"] [data-testid=state]').textContent), null, { timeout: 3_000 });
    const where = ground_truth.vehicle(2).distance;
    await sleep(1_500);
    assert.ok(ground_truth.vehicle(2).distance - where < 0.005, 'it stays where it was stopped');
  });

  await t.test('the command is followed until its effect is detected', async () => {
    await page.waitForSelector('[data-aiv="CoSiVA/AIV2"] [data-command-state=materialised]', { timeout: 6_000 });
  });

  await t.test('the Restart button sets it in motion again', async () => {
    await page.getByRole('button', { name: 'Restart AIV2', exact: true }).click();
    await ground_truth.moves(2, 25_000);
  });

  await t.test('Shift+Esc stops all, and Restart all requests one confirmation', async () => {
    await page.keyboard.press('Shift+Escape');
    for (const number of [1, 2, 3, 4]) await ground_truth.stands(number, 4_000);
    await page.getByTestId('restart-all').click();
    await sleep(500);
    for (const number of [1, 2, 3, 4]) assert.ok(ground_truth.vehicle(number).speed < 0.01, 'one press alone moves no vehicle');
    await page.getByTestId('restart-all').click();
    for (const number of [1, 2, 3, 4]) await ground_truth.moves(number, 30_000);
  });

  await t.test('a vehicle whose process dies is shown as lost', async () => {
    await platform.kill_child(/aiv\D*4$/i);
    await page.waitForSelector('[data-aiv="CoSiVA/AIV4"][data-state=lost]', { timeout: 3_000 });
    await page.waitForFunction(() => document.querySelector('[data-aiv="CoSiVA/AIV4"]').dataset.state !== 'lost', null, { timeout: 30_000 });
  });

  await t.test('when the server dies the page reports it, and recovers', async () => {
    await platform.kill_child(/server/i);
    // Detected and read at once: a server that is back soon removes it.
    const banner = await page.waitForFunction(() => document.querySelector('[data-testid=banner]')?.innerText, null, { timeout: 3_000 });
    assert.match(await banner.jsonValue(), /No connection|unresponsive/);
    await page.waitForSelector('[data-testid=link][data-phase=live]', { timeout: 30_000 });
    await page.waitForSelector('[data-testid=banner]', { state: 'detached', timeout: 5_000 });
    for (const number of [1, 2, 3, 4]) await ground_truth.moves(number, 40_000);
  });

  assert.deepEqual(page.script_errors, []);
  ground_truth.assert_no_collision();
});
