// The operator's page as a person uses it: by mouse at positions on the map, or by keyboard alone.
import assert from 'node:assert/strict';
import { open_page } from './browser.mjs';
import { eventually } from './platform.mjs';

export async function open_operator(t, browser, platform, { hash = '', vehicles = platform.aivs, ...options } = {}) {
  const page = await open_page(t, browser, `${platform.url}/${hash}`, options);
  await page.waitForSelector('[data-testid=link][data-phase=live]', { timeout: 20_000 });
  await page.waitForFunction((count) => document.querySelectorAll('[data-aiv]').length >= count || document.querySelector('#frame-supervision')?.hidden, vehicles, { timeout: 20_000 });
  return page;
}

export const row = (page, id) => page.locator(`[data-aiv="${id}"]`);
export const aiv_row = (page, number) => row(page, `CoSiVA/AIV${number}`);

/** The pixel of a position on the map, while all of the circuit is shown as at the start (lib/view.ts, fit). */
export async function pixel_of(page, platform, x, y) {
  const { bounds } = await platform.get('zone');
  const box = await page.getByTestId('circuit').boundingBox();
  const margin = 34;
  const scale = Math.min((box.width - 2 * margin) / (bounds[2] - bounds[0]), (box.height - 2 * margin) / (bounds[3] - bounds[1]));
  return { x: box.x + box.width / 2 + (x - (bounds[0] + bounds[2]) / 2) * scale, y: box.y + box.height / 2 - (y - (bounds[1] + bounds[3]) / 2) * scale };
}

export async function press_map(page, platform, x, y) {
  const at = await pixel_of(page, platform, x, y);
  await page.mouse.click(at.x, at.y);
}

/** Presses Tab until the focus is on the element that `wanted` names: a regular expression on its accessible text. */
export async function tab_to(page, wanted, { back = false, presses_max = 160 } = {}) {
  const words = [];
  for (let i = 0; i < presses_max; i++) {
    await page.keyboard.press(back ? 'Shift+Tab' : 'Tab');
    const name = await page.evaluate(() => {
      const element = document.activeElement;
      if (!element || element === document.body) return '';
      const label = element.getAttribute('aria-label') ?? element.labels?.[0]?.textContent ?? element.textContent ?? '';
      return `${label} #${element.dataset?.testid ?? element.id}`.replace(/\s+/g, ' ').trim();
    });
    if (wanted.test(name)) return name;
    words.push(name);
  }
  assert.fail(`Tab never came to ${wanted}; it came to: ${[...new Set(words)].join(' | ')}`);
}

/** The sentence of the newest notice, which must be readable for people. */
export async function notice(page, wanted, { within_ms = 5_000 } = {}) {
  const text = await eventually(
    `a notice like ${wanted}`,
    async () => (await page.getByTestId('notice').allInnerTexts()).find((one) => wanted.test(one)),
    { within_ms },
  );
  assert_sentence(text);
  return text;
}

/** Requirements of a text for people: no code, no braces, no "undefined". */
export function assert_sentence(text) {
  assert.match(text, /[a-z]{2,} [a-z(]/i, `“${text}” is not a sentence`);
  assert.doesNotMatch(text, /[{}]|undefined|NaN|\[object|Error:|HTTP \d|\bnull\b|[a-z]+\.[a-z]+_[a-z]+/, `“${text}” shows internal details`);
}

/** The last command of a vehicle as reported by the server. */
export async function last_command(platform, vehicle) {
  const { commands } = await platform.snapshot();
  return commands.filter((command) => command.vehicle === vehicle).at(-1);
}
export function materialised(platform, vehicle, verb, within_ms = 12_000) {
  return eventually(
    `${verb} of ${vehicle} materialised`,
    async () => {
      const command = await last_command(platform, vehicle);
      return command?.command === verb && command.state === 'materialised' && command;
    },
    { within_ms, every_ms: 100 },
  );
}
