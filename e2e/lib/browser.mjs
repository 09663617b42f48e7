// Debian's chromium, headless, with connections to the page only.
import { finally_do } from './cleanup.mjs';
import { existsSync } from 'node:fs';
import { chromium } from 'playwright-core';

export async function open_browser(t) {
  const executablePath = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find((path) => path && existsSync(path));
  const browser = await chromium.launch({
    executablePath,
    args: ['--no-sandbox', '--disable-background-networking', '--disable-component-update', '--disable-default-apps', '--disable-sync', '--no-first-run', '--disable-dev-shm-usage'],
  });
  finally_do(t, () => browser.close());
  return browser;
}

/**
 * A page whose own errors fail the test: `script_errors`; and `load_errors`, what its console reports, where the test keeps
 * the server in operation and gives no command that is refused.
 */
export async function open_page(t, browser, url, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: 'light', ...options });
  page.script_errors = [];
  page.load_errors = [];
  page.on('pageerror', (error) => page.script_errors.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && page.load_errors.push(`${message.text()} ${message.location().url}`));
  page.on('response', (response) => response.status() === 404 && page.load_errors.push(`404 ${response.url()}`));
  await page.goto(url);
  return page;
}
