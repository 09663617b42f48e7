// Every command of the page, once by mouse and once by keyboard alone: to one AIV, to several, to all; priorities;
// objects added and removed. The execution of a command is checked with the plant's ground truth and the server, not
// with the page.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { Truth } from './lib/bus.mjs';
import { last_command, materialised, open_operator, press_map, row, tab_to } from './lib/page.mjs';
import { eventually, Platform } from './lib/platform.mjs';

const id = (number) => `CoSiVA/AIV${number}`;
const words = { slow: 'slow speed', medium: 'medium speed', fast: 'fast speed', restart: 'Normal', stop: 'stopped' };
const verbs = ['slow', 'medium', 'fast', 'stop', 'restart'];
const title = (word) => word[0].toUpperCase() + word.slice(1);

test('every command by mouse and by keyboard', { timeout: 240_000 }, async (t) => {
  const platform = await Platform.up(t);
  const ground_truth = await Truth.follow(t, await platform.broker_port());
  const browser = await open_browser(t);
  const page = await open_operator(t, browser, platform);
  const status = async (number) => (await platform.aiv(number)).status;
  const has_status = (number, verb) => eventually(`AIV${number} is ${words[verb]}`, async () => (await status(number)) === words[verb], { within_ms: 20_000 });
  const priority = async (number) => (await platform.aiv(number)).priority;
  const virtualObject = async (wanted) => (await platform.snapshot()).virtualObjects.find(wanted);
  const nothing_left = () => eventually('nothing virtual is left', async () => {
    const { aivs, virtualObjects } = await platform.snapshot();
    return virtualObjects.length === 0 && aivs.every((aiv) => !aiv.augmented || aiv.connection === 'OFFLINE');
  }, { within_ms: 8_000 });

  /** Gives each command to AIV2 and checks with the ground truth that it was executed. */
  async function each_verb(give) {
    for (const verb of verbs) {
      if (verb !== 'restart') await ground_truth.moves(2, 30_000);
      await give(verb);
      await materialised(platform, id(2), verb, 25_000);
      if (verb === 'stop') await ground_truth.stands(2, 3_000);
      else await ground_truth.moves(2, 30_000);
      if (verb !== 'restart') await has_status(2, verb);
    }
  }

  await t.test('mouse: one AIV, each command', () => each_verb((verb) => page.getByRole('button', { name: `${title(verb)} AIV2`, exact: true }).click()));

  await t.test('mouse: several AIVs, and no other', async () => {
    const before = await last_command(platform, id(4));
    for (const number of [1, 3]) await row(page, id(number)).getByRole('checkbox').check();
    for (const verb of ['slow', 'stop']) {
      await page.getByRole('button', { name: `${title(verb)} 2 chosen` }).click();
      for (const number of [1, 3]) await materialised(platform, id(number), verb, 25_000);
    }
    for (const number of [1, 3]) await ground_truth.stands(number, 3_000);
    await page.getByRole('button', { name: 'Restart 2 chosen' }).click();
    for (const number of [1, 3]) await ground_truth.moves(number, 30_000);
    assert.deepEqual(await last_command(platform, id(4)), before);
    for (const number of [1, 3]) await row(page, id(number)).getByRole('checkbox').uncheck();
  });

  await t.test('mouse: all AIVs', async () => {
    await page.getByTestId('stop-all').click();
    for (const number of [1, 2, 3, 4]) await ground_truth.stands(number, 4_000);
    await page.getByTestId('restart-all').click();
    await page.getByTestId('restart-all').click();
    for (const number of [1, 2, 3, 4]) await ground_truth.moves(number, 30_000);
  });

  await t.test('mouse: priorities by number and by dragging', async () => {
    await row(page, id(3)).getByTestId('priority').fill('7');
    await row(page, id(3)).getByTestId('priority').press('Enter');
    await eventually('AIV3 has priority 7', async () => (await priority(3)) === 7, { within_ms: 4_000 });
    await page.getByRole('button', { name: 'By priority' }).click();
    const grip = await row(page, id(4)).getByTestId('grip').boundingBox();
    const first = await page.locator('[data-aiv]').first().boundingBox();
    await page.mouse.move(grip.x + grip.width / 2, grip.y + grip.height / 2);
    await page.mouse.down();
    await page.mouse.move(grip.x + 4, first.y + 40, { steps: 6 });
    await page.mouse.move(grip.x + 4, first.y + 8, { steps: 6 });
    await page.mouse.up();
    await eventually('AIV4 goes first', async () => {
      const { aivs } = await platform.snapshot();
      const of4 = aivs.find((aiv) => aiv.number === 4).priority;
      return aivs.every((aiv) => aiv.number === 4 || aiv.priority < of4);
    }, { within_ms: 4_000 });
    await page.getByRole('button', { name: 'By priority' }).click();
  });

  await t.test('mouse: person, walker, obstacle and physical obstacle are placed where one presses, and removed', async () => {
    // The centres of the loops: inside the zone and off every path.
    const spots = [['add-person', 0.75, 0.75, 'person'], ['add-obstacle', -0.75, 0.75, 'obstacle']];
    for (const [name, x, y, kind] of spots) {
      await page.getByTestId(`tool-${name}`).click();
      await press_map(page, platform, x, y);
      const made = await eventually(`a ${kind}`, () => virtualObject((one) => one.kind === kind), { within_ms: 4_000 });
      assert.ok(Math.hypot(made.x - x, made.y - y) < 0.02, `${kind} at ${made.x}, ${made.y} instead of ${x}, ${y}`);
    }
    await page.getByTestId('tool-draw-walk').click();
    await press_map(page, platform, -0.85, -0.75);
    await press_map(page, platform, -0.65, -0.75);
    await page.getByRole('button', { name: 'Start walking' }).click();
    const walker = await eventually('a walker', () => virtualObject((one) => one.path?.length === 2), { within_ms: 4_000 });
    await eventually('the walker walks', async () => Math.abs((await virtualObject((one) => one.id === walker.id)).x - walker.x) > 0.03, { within_ms: 4_000 });
    await page.getByTestId('tool-add-plant-obstacle').click();
    await press_map(page, platform, 0.75, -0.75);
    await eventually('the plant has it', () => ground_truth.latest.obstacles?.find((one) => Math.hypot(one.x - 0.75, one.y + 0.75) < 0.02), { within_ms: 4_000 });
    const removals = page.locator('[data-virtual-object] button[aria-label^=Remove]');
    await eventually('all four are listed', async () => (await removals.count()) === 4, { within_ms: 4_000 });
    for (const label of await removals.evaluateAll((all) => all.map((one) => one.getAttribute('aria-label')))) await page.getByRole('button', { name: label, exact: true }).click();
    await nothing_left();
    await eventually('the plant is empty', () => ground_truth.latest.obstacles.length === 0, { within_ms: 4_000 });
  });

  await t.test('mouse: a virtual AIV is added where there is room, obeys, and is taken out again', async () => {
    await page.getByTestId('tool-add-aiv').click();
    await page.getByTestId('add-anywhere').click();
    const virtual = await eventually('a virtual AIV drives', async () => (await platform.snapshot()).aivs.find((aiv) => aiv.augmented && aiv.speed > 0.05), { within_ms: 30_000 });
    await row(page, virtual.id).getByRole('button', { name: /^Stop/ }).click();
    await materialised(platform, virtual.id, 'stop');
    await row(page, virtual.id).getByRole('button', { name: /^Remove/ }).click();
    await nothing_left();
  });

  // From here on no mouse: a new page, so that no element has the focus already.
  await page.close();
  const keys = await open_operator(t, browser, platform);
  const press = (...names) => names.reduce((done, name) => done.then(() => keys.keyboard.press(name)), Promise.resolve());
  const type = (text) => keys.keyboard.type(text);
  const top = () => keys.evaluate(() => document.activeElement?.blur());

  await t.test('keyboard: one AIV, each command', () => each_verb(async (verb) => {
    await top();
    await tab_to(keys, new RegExp(`^${title(verb)} AIV2 `));
    await press('Enter');
  }));

  await t.test('keyboard: the selected AIV with s, and any command by its name', async () => {
    await top();
    await press('j');
    const selected = await keys.locator('[data-aiv] .mark[aria-pressed=true]').innerText();
    const number = Number(/\d+/.exec(selected)[0]);
    await ground_truth.moves(number, 30_000);
    await press('s');
    await ground_truth.stands(number, 4_000);
    await press('Control+k');
    await type(`restart AIV${number}`);
    await press('Enter');
    await ground_truth.moves(number, 30_000);
    await press('Escape');
  });

  await t.test('keyboard: several AIVs', async () => {
    await top();
    for (const number of [2, 4]) {
      await tab_to(keys, new RegExp(`^Choose AIV${number} `));
      await press('Space');
    }
    await tab_to(keys, /^Stop 2 chosen/, { back: true });
    await press('Enter');
    for (const number of [2, 4]) await ground_truth.stands(number, 4_000);
    await tab_to(keys, /^Restart 2 chosen/, { back: true });
    await press('Enter');
    for (const number of [2, 4]) await ground_truth.moves(number, 30_000);
  });

  await t.test('keyboard: all AIVs, also while typing', async () => {
    await top();
    await press('/');
    await type('AIV');
    await press('Shift+Escape');
    for (const number of [1, 2, 3, 4]) await ground_truth.stands(number, 4_000);
    await keys.getByTestId('search').evaluate((field) => { field.value = ''; field.dispatchEvent(new Event('input', { bubbles: true })); });
    await top();
    await tab_to(keys, /#restart-all$/);
    await press('Enter', 'Enter');
    for (const number of [1, 2, 3, 4]) await ground_truth.moves(number, 30_000);
  });

  await t.test('keyboard: priorities by number and by rank', async () => {
    await top();
    await tab_to(keys, /^Priority of AIV1 /);
    await press('Control+a');
    await type('3');
    await press('Enter');
    await eventually('AIV1 has priority 3', async () => (await priority(1)) === 3, { within_ms: 4_000 });
    await top();
    await tab_to(keys, /^Choose AIV1 /);
    const before = await priority(1);
    await press('Alt+ArrowUp');
    await eventually('AIV1 ranks higher', async () => (await priority(1)) > before || (await platform.snapshot()).aivs.filter((aiv) => aiv.priority > before).length < 2, { within_ms: 4_000 });
  });

  await t.test('keyboard: a person, an obstacle and a virtual AIV with the cross on the map', async () => {
    for (const [name, kind] of [['add-person', 'person'], ['add-obstacle', 'obstacle']]) {
      await top();
      await tab_to(keys, new RegExp(`#tool-${name}$`));
      await press('Enter');
      await eventually('the map has the focus', () => keys.evaluate(() => document.activeElement?.dataset.testid === 'circuit'), { within_ms: 2_000 });
      // From the zone's centre into a loop, clear of every path.
      const down = kind === 'person' ? 'ArrowUp' : 'ArrowDown';
      const { scale } = await keys.evaluate(async () => {
        const { bounds } = await (await fetch('api/v1/zone')).json();
        const box = document.querySelector('[data-testid=circuit]').getBoundingClientRect();
        return { scale: Math.min((box.width - 68) / (bounds[2] - bounds[0]), (box.height - 68) / (bounds[3] - bounds[1])) };
      });
      const steps = Math.round((0.75 * scale) / 20);
      await press(...Array(steps).fill('ArrowRight'), ...Array(steps).fill(down), 'Enter');
      const made = await eventually(`a ${kind}`, () => virtualObject((one) => one.kind === kind), { within_ms: 4_000 });
      const expected = (20 * steps) / scale;
      assert.ok(Math.abs(made.x - expected) < 0.03 && Math.abs(Math.abs(made.y) - expected) < 0.03, `${kind} at ${made.x}, ${made.y}; ${expected} was meant`);
    }
    await top();
    await tab_to(keys, /#tool-add-aiv$/);
    await press('Enter');
    await tab_to(keys, /#add-anywhere$/, { back: true });
    await press('Enter');
    const virtual = await eventually('a virtual AIV', async () => (await platform.snapshot()).aivs.find((aiv) => aiv.augmented && aiv.connection === 'ONLINE'), { within_ms: 30_000 });
    await eventually('it is listed', () => row(keys, virtual.id).count(), { within_ms: 4_000 });
    for (const name of [/^Remove P\d/, /^Remove O\d/, /^Remove V\d/]) {
      await top();
      await tab_to(keys, name);
      await press('Enter');
      await eventually('it is gone from the list', async () => (await keys.locator('button').evaluateAll((all, source) => all.filter((one) => new RegExp(source).test(one.getAttribute('aria-label') ?? '')).length, name.source)) === 0, { within_ms: 6_000 });
    }
    await nothing_left();
  });

  await t.test('the self-test of a stopped AIV by mouse, with the result of every part; the messages through the proxies on board', async () => {
    await keys.getByRole('button', { name: 'Stop AIV2', exact: true }).click();
    await ground_truth.stands(2, 5_000);
    await keys.getByRole('button', { name: /^Boards/ }).first().click();
    const boards = keys.locator('section').filter({ has: keys.getByTestId('self-test') }).filter({ has: keys.getByRole('button', { name: 'AIV2' }) });
    await boards.getByTestId('self-test').click();
    const result = await eventually('the parts are tested', async () => {
      const text = await boards.locator('[data-self-test]').textContent({ timeout: 1_000 }).catch(() => '');
      return /PILS: .*DEMS passed/.test(text) && text;
    }, { within_ms: 10_000 });
    for (const board of ['PILS', 'PRAV', 'DOBS', 'RALI']) assert.match(result, new RegExp(`${board}: [^·]*passed`));
    assert.match(await boards.locator('[data-proxies]').textContent(), /AIV_Server [1-9]\d* ↑ [1-9]\d* ↓ · .*AIV1 \d+ ↑ [1-9]\d* ↓/);
    const { proxy, proxies } = await platform.aiv(2);
    const since = proxy.delivered - proxies[0].sent;
    assert.ok(since >= 0 && since < 60, `the vehicle has sent ${proxies[0].sent} messages up to its last report, the server received ${proxy.delivered}`);
  });

  assert.deepEqual([...page.script_errors, ...keys.script_errors], []);
  ground_truth.assert_no_collision();
});
