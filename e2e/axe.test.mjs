// Accessibility: axe finds no violation on any frame, view or dialog, light or dark.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { materialised, open_operator } from './lib/page.mjs';
import { eventually, Platform } from './lib/platform.mjs';

const axe_source = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/** [name, how to open the view, how to leave it] */
const views = [
  ['all four frames', async () => {}, async () => {}],
  ...['Supervision of AIVs', 'States of AIVs', 'Circuit', 'Traces of communications between AIVs'].map((title, i) => [
    `${title}, alone`, (page) => page.keyboard.press(String(i + 1)), (page) => page.keyboard.press(String(i + 1)),
  ]),
  ...['Bijection', 'Alarms', 'Boards', 'Batteries', 'GVS', 'Log'].map((name) => [
    `panel ${name}`, (page) => page.getByRole('button', { name: new RegExp(`^${name}`) }).first().click(), (page) => page.getByRole('button', { name: new RegExp(`^${name}`) }).first().click(),
  ]),
  ['help', (page) => page.keyboard.press('?'), (page) => page.keyboard.press('Escape')],
  ['list of commands', (page) => page.keyboard.press('Control+k'), (page) => page.keyboard.press('Escape')],
  ['zones', (page) => page.getByTitle('Traffic zone', { exact: true }).click(), (page) => page.keyboard.press('Escape')],
  ['layers', (page) => page.keyboard.press('l'), (page) => page.keyboard.press('l')],
  ['tags and beacons', async (page) => {
    await page.getByTestId('tool-edit-tags').click();
    await page.getByTestId('tag-choice').selectOption('3');
  }, (page) => page.getByLabel('Close the tags').click()],
  ['walk tool', (page) => page.getByTestId('tool-draw-walk').click(), (page) => page.getByLabel('End the tool').click()],
  ['menu of the map', async (page) => {
    await page.getByTestId('circuit').focus();
    await page.keyboard.press('Shift+F10');
  }, (page) => page.keyboard.press('Escape')],
  ['columns of the table', (page) => page.getByRole('button', { name: 'Columns' }).click(), (page) => page.getByRole('button', { name: 'Columns' }).click()],
  ['a message', async (page) => {
    await page.keyboard.press('4');
    await page.getByLabel('Search the communications').fill('state aiv2');
    await page.locator('[data-testid=traces-table] [data-kind=state]').last().waitFor();
    await page.getByTestId('traces-table').focus();
    await page.keyboard.press('End');
    await page.keyboard.press('Enter');
    await page.getByTestId('schema-verdict').waitFor({ timeout: 5_000 });
    await page.getByRole('button', { name: 'Changes', exact: true }).click();
  }, (page) => page.getByLabel('Search the communications').fill('')],
  ['kinds of communications', (page) => page.getByRole('button', { name: /^Kinds/ }).click(), (page) => page.keyboard.press('Escape')],
  ['sequence', (page) => page.getByRole('button', { name: 'Sequence', exact: true }).click(), async () => {}],
  ['sequence, figure 8', (page) => page.getByTestId('figure').selectOption('figure 8'), async (page) => {
    await page.getByRole('button', { name: 'Table', exact: true }).click();
    await page.evaluate(() => document.activeElement?.blur());
    await page.keyboard.press('4');
  }],
];

async function violations_of(page) {
  const { violations, passes } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
  assert.ok(passes.length > 10, 'axe evaluated something');
  return violations.map(({ id, help, nodes }) => `${id}: ${help}\n${nodes.slice(0, 4).map((node) => `    ${node.html.slice(0, 160)}\n      ${node.failureSummary?.split('\n').slice(1, 3).join(' ')}`).join('\n')}`);
}

test('axe finds no violation', { timeout: 240_000 }, async (t) => {
  const platform = await Platform.up(t);
  const browser = await open_browser(t);
  // Every kind of content: virtual objects, one obstacle, one vehicle that is stopped, a command that was executed.
  await platform.ask('POST', 'virtual-objects', { kind: 'aiv' });
  await platform.ask('POST', 'virtual-objects', { kind: 'person', x: 0.75, y: 0.75 });
  await platform.ask('POST', 'virtual-objects', { kind: 'obstacle', x: -0.75, y: 0.75 });
  await platform.ask('POST', 'plant/obstacles', { x: 0.75, y: -0.75 });
  await platform.command('stop', 'CoSiVA/AIV1');
  await platform.command('slow', 'CoSiVA/AIV2');
  await materialised(platform, 'CoSiVA/AIV1', 'stop');
  await eventually('the virtual AIV is there', async () => (await platform.snapshot()).aivs.some((aiv) => aiv.augmented), { within_ms: 20_000 });

  for (const theme of ['light', 'dark']) {
    await t.test(theme, async (t) => {
      const page = await open_operator(t, browser, platform, { hash: `#theme=${theme}`, colorScheme: theme, reducedMotion: 'reduce' });
      await page.evaluate(axe_source);
      for (const [name, enter, leave] of views) {
        await t.test(name, async () => {
          await enter(page);
          await page.waitForTimeout(250);
          // On a busy machine axe takes seconds, while the page may change: only a violation that lasts is one.
          let found = await violations_of(page);
          for (let again = 0; again < 2 && found.length > 0; ++again) found = await violations_of(page);
          await leave(page);
          assert.deepEqual(found, [], found.join('\n'));
        });
      }
      assert.deepEqual(page.script_errors, []);
      await page.close();
    });
  }
});
