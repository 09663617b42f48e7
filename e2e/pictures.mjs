// Creates the images of README and guides again, of the real platform: `node e2e/pictures.mjs` after scripts/setup
// test and a build; `node e2e/pictures.mjs page gvs` only these of zones, reports, gvs and page. To be run on an idle
// machine: load affects the metrics shown.
import { mkdirSync } from 'node:fs';
import path from 'node:path';
import { open_browser, open_page } from './lib/browser.mjs';
import { cosiva, Platform, sleep, source_dir, work_folder } from './lib/platform.mjs';
import { pathToFileURL } from 'node:url';

const folder = path.join(source_dir, 'docs/images');
mkdirSync(folder, { recursive: true });
// What the tests' helpers require of a test.
const endings = [];
const t = { after: (action) => endings.push(action), diagnostic: console.log, name: 'pictures', passed: true };

/** The ready zones as drawn by the page, side by side. */
async function take_zones(browser) {
  const drawn = [];
  for (const name of ['lacet4', 'indus8', 'workshop', 'crossing8']) {
    const { code, stdout, stderr } = await cosiva(['zone', 'show', name]);
    if (code !== 0) throw new Error(stderr);
    drawn.push(`<img alt="" src="data:image/svg+xml;base64,${Buffer.from(stdout).toString('base64')}">`);
  }
  const page = await browser.newPage({ viewport: { width: 1440, height: 1180 } });
  await page.setContent(`<style>body { margin: 0; background: #fff; display: grid; grid-template: 590px 590px / 720px 720px }
    img { width: 720px; height: 590px; object-fit: contain }</style>${drawn.join('')}`);
  await page.screenshot({ path: path.join(folder, 'zones.png') });
  await page.close();
  console.log('docs/images/zones.png');
}

/** The first screen of the reports that the experiments write. */
async function take_reports(browser) {
  const out = work_folder(t);
  const reports = {
    metrology: ['compare', 'dead_reckoning', 'reset_rule', 'arc_kalman', 'arc_smoother', '--seed', '1'],
    batteries: ['battery', 'fleet', '--aivs', '12', '--seed', '1'],
  };
  for (const [name, args] of Object.entries(reports)) {
    const { code, stderr } = await cosiva([...args, '--out', path.join(out, name)], { timeout_ms: 120_000 });
    if (code !== 0) throw new Error(stderr);
    const page = await browser.newPage({ viewport: { width: 1100, height: 1300 } });
    await page.goto(pathToFileURL(path.join(out, name, 'report.html')).href);
    await page.screenshot({ path: path.join(folder, `${name}.png`) });
    await page.close();
    console.log(`docs/images/${name}.png`);
  }
}

/** The image of the camera over the zone. */
async function take_gvs(browser) {
  const platform = await Platform.up(t, { args: ['--gvs', '--name', 'gvs'] });
  const page = await open_page(t, browser, `${platform.url}/#panel=gvs`);
  await page.getByTestId('gvs-picture').waitFor({ timeout: 15_000 });
  await sleep(15_000);
  await page.screenshot({ path: path.join(folder, 'gvs.png') });
  console.log('docs/images/gvs.png');
  await page.close();
  await platform.stop();
}

/** The page, each of its frames alone, and the sequence diagram. */
async function take_page(browser) {
  const platform = await Platform.up(t, { args: ['--scenario', 'showroom', '--name', 'showroom'] });
  const shot = async (page, name) => {
    await page.mouse.move(5, 5);
    await page.screenshot({ path: path.join(folder, `${name}.png`) });
    console.log(`docs/images/${name}.png`);
  };
  const page = await open_page(t, browser, platform.url);
  // Persons walk, the virtual AIV drives, and the start no longer affects the metrics.
  await sleep(45_000);
  await shot(page, 'page');
  for (const [key, name, height] of [['1', 'supervision', 560], ['2', 'states', 420], ['3', 'circuit', 860], ['4', 'traces', 640]]) {
    await page.setViewportSize({ width: 1440, height });
    await page.keyboard.press(key);
    if (name === 'supervision') for (const word of ['Slow AIV1', 'Stop AIV2']) await page.getByRole('button', { name: word, exact: true }).click();
    await sleep(1_500);
    await shot(page, name);
    if (name === 'traces') {
      await page.getByRole('button', { name: 'Sequence' }).click();
      await page.getByTestId('figure').selectOption('figure 11');
      await sleep(2_000);
      await shot(page, 'sequence');
    }
    if (name === 'supervision') for (const word of ['Restart AIV1', 'Restart AIV2']) await page.getByRole('button', { name: word, exact: true }).click();
    await page.keyboard.press(key);
  }
  const dark = await open_page(t, browser, platform.url, { colorScheme: 'dark', viewport: { width: 1920, height: 1080 } });
  await sleep(20_000);
  await shot(dark, 'page-dark');
}

try {
  const browser = await open_browser(t);
  const parts = { zones: take_zones, reports: take_reports, gvs: take_gvs, page: take_page };
  const wanted = process.argv.length > 2 ? process.argv.slice(2) : Object.keys(parts);
  for (const name of wanted) {
    if (!parts[name]) throw new Error(`no part ${name}: ${Object.keys(parts).join(', ')}`);
    await parts[name](browser);
  }
} finally {
  for (const end of endings.reverse()) await end();
}
