// Traces of communications on the real platform (A8): every message is listed, can be found, read and saved; a
// violation of the standard is shown where it occurs; the article's exchanges are redrawn from the actual messages.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Bus } from './lib/bus.mjs';
import { open_operator } from './lib/page.mjs';
import { eventually, Platform, sleep } from './lib/platform.mjs';

test('the communications are listed, found, read and drawn', { timeout: 180_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2 });
  const page = await open_operator(t, await open_browser(t), platform, { hash: '#frame=traces', vehicles: 0 });
  const table = page.getByTestId('traces-table');
  const cells = () => table.locator('[data-kind]:not([data-kind=""])').evaluateAll((rows) => rows.map((row) => [...row.children].map((cell) => cell.title || cell.textContent)));
  const count = async () => Number((await page.getByTestId('traces-count').innerText()).split(' of ')[0].replace(/\D/g, ''));
  const show_all = async () => {
    await page.getByLabel('Sent or received by').selectOption('');
    await page.getByLabel('Search the communications').fill('');
  };

  await t.test('every message that the server stored is listed, from the first on', async () => {
    await eventually('they are all read', async () => (await count()) >= (await platform.get('traces?after=0&limit=1000')).next - 200, { within_ms: 8_000 });
    await table.focus();
    await page.keyboard.press('Home');
    const { traces } = await platform.get('traces?after=0&limit=5');
    const shown = (await cells()).slice(0, 5).map(([, from, to, kind]) => ({ from, to, kind }));
    assert.deepEqual(shown.map(({ from, kind }) => ({ from, kind })), traces.map(({ from, kind }) => ({ from, kind })));
  });

  await t.test('the list stays while one reads, counts what is new, and follows again', async () => {
    const first = (await cells())[0];
    await eventually('new ones are counted', async () => /\d+ new/.test(await page.getByTestId('traces-follow').innerText()), { within_ms: 4_000 });
    assert.deepEqual((await cells())[0], first);
    await page.getByTestId('traces-follow').click();
    // The number of the row at the upper edge; below the lower edge one more row is rendered when there is one.
    const top = () => table.locator('[data-trace]').first().getAttribute('data-trace');
    const was = await top();
    await eventually('it follows', async () => (await top()) !== was, { within_ms: 3_000 });
    await table.focus();
    await page.keyboard.press('Space');
    const paused_at = await top();
    await sleep(700);
    assert.equal(await top(), paused_at, 'Space pauses');
    await page.keyboard.press('End');
    await eventually('End follows', async () => (await top()) !== paused_at, { within_ms: 3_000 });
  });

  await t.test('the row that is pressed is the one that opens, however fast others come', async () => {
    const box = await table.boundingBox();
    const at = [box.x + 200, box.y + box.height - 100];
    const row_there = () => page.evaluate(([x, y]) => document.elementFromPoint(x, y).closest('[data-trace]').dataset.trace, at);
    /** The row under the pointer as it moves, and 300 ms after. */
    const aimed = () => page.evaluate(([x, y]) => new Promise((resolve) => {
      const row = () => document.elementFromPoint(x, y).closest('[data-trace]').dataset.trace;
      addEventListener('pointermove', () => {
        const first = row();
        setTimeout(() => resolve([first, row()]), 300);
      }, { once: true });
    }), at);
    for (let i = 0; i < 8; i++) {
      await table.focus();
      await page.keyboard.press('End');
      await page.mouse.move(box.x + 200, box.y - 20);
      const was = await row_there();
      await eventually('it follows', async () => (await row_there()) !== was, { within_ms: 3_000 });
      const [[first, then]] = await Promise.all([aimed(), sleep(50).then(() => page.mouse.move(...at))]);
      assert.equal(then, first, 'the rows stay in place while the pointer aims');
      await page.mouse.down();
      const pressed = await row_there();
      await sleep(1_300 * (i % 2)); // some presses are long
      await page.mouse.up();
      assert.equal(await page.getByTestId('trace-detail').getAttribute('aria-label', { timeout: 2_000 }), `Message ${pressed}`);
      await page.getByRole('button', { name: 'Close message' }).click();
    }
  });

  await t.test('a pointer that only lies there does not stop the list', async () => {
    await table.focus();
    await page.keyboard.press('End');
    await table.hover();
    const last = async () => (await cells()).at(-1)[0];
    const was = await last();
    await eventually('it follows', async () => (await last()) !== was, { within_ms: 4_000 });
  });

  await t.test('it shows only messages of one AIV, only some kinds, only some terms', async () => {
    await page.getByLabel('Sent or received by').selectOption('CoSiVA/AIV2');
    await eventually('only AIV2', async () => (await cells()).length > 3 && (await cells()).every(([, from, to]) => from === 'CoSiVA/AIV2' || to === 'CoSiVA/AIV2'), { within_ms: 4_000 });
    await page.getByRole('button', { name: /^Kinds/ }).click();
    await page.getByLabel('Only order').click();
    await page.keyboard.press('Escape');
    await eventually('only orders', async () => (await cells()).length > 0 && (await cells()).every(([, , , kind]) => kind === 'order'), { within_ms: 4_000 });
    await page.getByLabel('Search the communications').fill('no such words');
    await page.getByText('No message matches').waitFor({ timeout: 4_000 });
    await page.getByRole('button', { name: 'Show all' }).click();
    await eventually('everything again', async () => (await count()) > 100, { within_ms: 4_000 });
  });

  await t.test('a message is shown whole, conforms, and what changed is marked', async () => {
    await page.getByLabel('Search the communications').fill('state aiv1');
    await eventually('states of AIV1', async () => (await cells()).length > 1 && (await cells()).every(([, , , kind]) => kind === 'state'), { within_ms: 6_000 });
    await table.focus();
    await page.keyboard.press('End');
    await page.keyboard.press('Enter');
    const detail = page.getByTestId('trace-detail');
    await detail.getByTestId('schema-verdict').waitFor({ timeout: 5_000 });
    assert.equal(await detail.getByTestId('schema-verdict').getAttribute('data-faults'), '0', await detail.innerText());
    assert.match(await detail.innerText(), /uagv\/v2\/CoSiVA\/AIV1\/state/);
    await detail.getByRole('button', { name: 'Changes', exact: true }).click();
    await eventually('the changes are listed', async () => /\d+ since|none but/.test(await detail.getByTestId('changes').innerText()), { within_ms: 4_000 });
    await page.keyboard.press('Escape');
    await detail.waitFor({ state: 'detached' });
    await show_all();
  });

  await t.test('a message that breaks the standard is marked where it does', async () => {
    const bus = await Bus.open(t, await platform.broker_port(), []);
    const header = { headerId: 1, timestamp: new Date().toISOString(), version: '2.1.0', manufacturer: 'RobotCompany', serialNumber: '009' };
    await bus.publish('uagv/v2/RobotCompany/009/connection', { ...header, connectionState: 'ONLINE' }, { qos: 1 });
    // All fields that CoSiVA reads are right; the fault is in a part that CoSiVA does not need.
    await bus.publish('uagv/v2/RobotCompany/009/state', {
      ...header, orderId: '', orderUpdateId: 0, lastNodeId: '', lastNodeSequenceId: 0, nodeStates: [], edgeStates: [], driving: false, actionStates: [],
      batteryState: { batteryCharge: 80, charging: false }, operatingMode: 'AUTOMATIC', errors: [], safetyState: { eStop: 'NONE', fieldViolation: false }, loads: [{ weight: 'heavy' }],
    });
    await page.getByLabel('Search the communications').fill('robotcompany/009 state');
    const row = table.locator('[data-kind=state]');
    await row.waitFor({ timeout: 5_000 });
    await row.click();
    const detail = page.getByTestId('trace-detail');
    await detail.getByTestId('schema-verdict').waitFor({ timeout: 5_000 });
    assert.equal(await detail.getByTestId('schema-verdict').getAttribute('data-faults'), '1');
    assert.match(await detail.innerText(), /loads\[0\]\.weight\s+must be a number, and is "heavy"\./);
    await page.keyboard.press('Escape');
    await show_all();
  });

  await t.test('what is shown is saved, as NDJSON and as CSV', async () => {
    await page.getByLabel('Sent or received by').selectOption('Simulator');
    const wanted = await eventually('the simulator’s', async () => /of/.test(await page.getByTestId('traces-count').innerText()) && (await count()), { within_ms: 4_000 });
    const save = async (name) => {
      await page.getByRole('button', { name: 'Export' }).click();
      const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name }).click()]);
      return readFileSync(await download.path(), 'utf8');
    };
    const lines = (await save(/NDJSON/)).trim().split('\n').map((line) => JSON.parse(line));
    assert.ok(lines.length >= wanted && lines.every(({ from, to }) => from === 'Simulator' || to === 'Simulator'));
    const csv = (await save(/CSV/)).trim().split('\r\n');
    assert.equal(csv[0], 'n,time,from,to,via,kind,content');
    assert.ok(csv.length - 1 >= wanted);
    await show_all();
  });

  await t.test('figure 8 is redrawn from the messages sent when the zone came', async () => {
    await page.getByRole('button', { name: 'Sequence', exact: true }).click();
    await page.getByTestId('figure').selectOption('figure 8');
    const arrows = page.getByTestId('sequence').locator('[data-arrow]');
    await arrows.first().waitFor({ timeout: 4_000 });
    assert.deepEqual(await arrows.evaluateAll((all) => all.map((one) => one.dataset.arrow)), ['zone', 'zoneConfiguration', 'initialise', 'circuitFactory', 'circuitFactory', 'circuit', 'circuit', 'draw', 'draw']);
    const heads = await page.locator('[data-testid=sequence] svg.heads text').allTextContents();
    assert.deepEqual(heads, ['physical side', 'AIV_Server', 'Simulator', 'RTM', 'CircuitFactory', 'Circuit']);
  });

  await t.test('figure 9 is redrawn with a virtual AIV that has just come, and opens its messages', async () => {
    const { id } = await platform.ask('POST', 'virtual-objects', { kind: 'aiv' });
    await eventually('it drives', async () => (await platform.snapshot()).aivs.some((aiv) => aiv.id.endsWith(`/${id}`) && aiv.speed > 0.02), { within_ms: 15_000 });
    await sleep(500);
    await page.getByTestId('figure').selectOption('figure 9');
    const arrows = page.getByTestId('sequence').locator('[data-arrow]');
    const kinds = await eventually('it appears', async () => {
      await page.getByRole('button', { name: 'Latest' }).click();
      const all = await arrows.evaluateAll((each) => each.map((one) => one.dataset.arrow));
      return all.includes('appear') && all.includes('visualization') && all;
    }, { within_ms: 6_000 });
    assert.equal(kinds[0], 'connection');
    assert.ok(kinds.indexOf('state') < kinds.indexOf('appear'), 'it has sent its state before it gets its display number');
    assert.deepEqual(await page.locator('[data-testid=sequence] svg.heads text').allTextContents(), [id, `proxy of ${id}`, 'AIV_Server', 'Simulator']);
    await arrows.first().click();
    await page.getByTestId('schema-verdict').waitFor({ timeout: 5_000 });
    assert.equal(await page.getByTestId('schema-verdict').getAttribute('data-faults'), '0');
    await page.keyboard.press('Escape');
  });

  await t.test('figure 11 is redrawn from the latest reports of one AIV, and saved as an image', async () => {
    await page.getByTestId('figure').selectOption('figure 11');
    const arrows = page.getByTestId('sequence').locator('[data-arrow]');
    await eventually('its reports', async () => (await arrows.count()) >= 2, { within_ms: 4_000 });
    const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'SVG' }).click()]);
    const svg = readFileSync(await download.path(), 'utf8');
    assert.match(svg, /^<svg [^>]*xmlns="http:\/\/www\.w3\.org\/2000\/svg"/);
    assert.match(svg, /Figure 11/);
    assert.doesNotMatch(svg, /undefined|NaN|var\(/);
  });

  assert.deepEqual(page.script_errors, []);
});
