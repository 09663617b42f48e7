// A camera over a running platform: its image on the page with the AIVs at their positions, twins compared with it,
// its findings by name, and the consequences when it is killed or detects nothing.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { open_operator } from './lib/page.mjs';
import { artefacts_dir, cosiva, cosiva_binary, eventually, free_port, Platform, Program, sleep, start_broker, work_folder, zone_file } from './lib/platform.mjs';

const axe_source = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
async function assert_open_to_all(page) {
  await page.evaluate(axe_source);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
  assert.deepEqual(violations.map(({ id, help, nodes }) => `${id}: ${help} ${nodes[0].html.slice(0, 160)}`), []);
}
const findings = async (platform) => (await platform.get('bijection')).findings;

test('cosiva up --gvs', { timeout: 240_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 3, args: ['--gvs'] });
  const page = await open_operator(t, await open_browser(t), platform, { reducedMotion: 'reduce' });

  await t.test('each AIV is detected, and its twin is compared with it', async () => {
    const gvs = await eventually('all three are detected and compared', async () => {
      const { gvs } = await platform.snapshot();
      return gvs?.state === 'watching' && gvs.detections.length === 3 && gvs.detections.every((seen) => seen.twin && seen.gap_m !== null) && gvs;
    }, { within_ms: 30_000 });
    for (const seen of gvs.detections) assert.ok(seen.gap_m < 0.2, `${seen.id}: ${seen.gap_m} m off`);
    const { actual_m } = await eventually('it is a figure of the bijection', async () => {
      const bijection = await platform.get('bijection');
      return bijection.actual_m.count > 20 && bijection;
    });
    assert.ok(actual_m.p50 < 0.05, `${actual_m.p50} m`);
    assert.deepEqual(await findings(platform), []);
  });

  await t.test('the page shows the image, with each AIV drawn where it was detected', async () => {
    await page.getByTestId('open-gvs').click();
    const panel = page.getByTestId('gvs');
    await panel.getByTestId('gvs-picture').waitFor({ timeout: 15_000 });
    await eventually('three outlines', async () => (await panel.locator('[data-detection] path[d$="Z"]').count()) === 3);
    const canvas = panel.locator('canvas');
    const look = () => canvas.evaluate((element) => {
      const { data } = element.getContext('2d').getImageData(0, 0, element.width, element.height);
      let [darkest, brightest, sum] = [255, 0, 0];
      for (let i = 0; i < data.length; i += 4) [darkest, brightest, sum] = [Math.min(darkest, data[i]), Math.max(brightest, data[i]), sum + data[i]];
      return { width: element.width, darkest, brightest, sum };
    });
    const first = await look();
    assert.equal(first.width, 480);
    assert.ok(first.darkest < 60 && first.brightest > 180, `floor, lines and tags: ${JSON.stringify(first)}`);
    await eventually('a new image is shown soon', async () => (await look()).sum !== first.sum);
    assert.match(await panel.getByTestId('gvs-picture').getAttribute('aria-label'), /AIV1 at -?\d/);
    assert.equal(await panel.locator('[data-seen]').count(), 3);
    assert.deepEqual(page.load_errors, [], 'no request fails, not even before the first image');
  });

  await t.test('an AIV chosen in the view is the chosen one everywhere', async () => {
    await page.getByTestId('gvs-seen').getByRole('button', { name: 'AIV2' }).click();
    await eventually('it is', async () => (await page.locator('[data-detection="CoSiVA/AIV2"].selected').count()) === 1);
  });

  for (const theme of ['light', 'dark']) {
    await t.test(`it can be read in ${theme}`, async () => {
      await page.emulateMedia({ colorScheme: theme, reducedMotion: 'reduce' });
      await page.evaluate((wanted) => (location.hash = `#panel=gvs&theme=${wanted}`), theme);
      await page.waitForFunction((wanted) => document.documentElement.dataset.theme === wanted, theme);
      await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
      await page.waitForTimeout(400);
      await page.getByTestId('gvs-picture').waitFor({ timeout: 15_000 });
      await assert_open_to_all(page);
      mkdirSync(artefacts_dir, { recursive: true });
      await page.screenshot({ path: path.join(artefacts_dir, `gvs_view_${theme}.png`) });
    });
  }

  await t.test('killed, it is missed by name, and comes back', async () => {
    let before;
    let killed_ms;
    // Otherwise it is back within some 20 ms.
    await platform.without_supervisor(async () => {
      before = await platform.kill_child(/^gvs$/);
      killed_ms = Date.now();
      await eventually('it is missed', async () => (await findings(platform)).some(({ kind, id }) => kind === 'no detection' && id === 'GVS'), { within_ms: 10_000 });
    });
    const after = await eventually('it is started again', () => platform.children().find(({ name, pid }) => name === 'gvs' && pid !== before.pid));
    assert.ok(after);
    await eventually('all is well again', async () => {
      const { gvs, bijection } = await platform.snapshot();
      return gvs.state === 'watching' && gvs.detections.length === 3 && gvs.detections.every((seen) => seen.at_ms > killed_ms) && bijection.findings.length === 0;
    }, { within_ms: 30_000 });
    assert.equal((await platform.get('bijection')).matched, 3, 'the platform went on');
  });

  await t.test('frozen, it is an alarm on the page that ends when it wakes', async () => {
    const { pid } = await platform.child(/^gvs$/);
    await page.getByTestId('open-alarms').click();
    process.kill(pid, 'SIGSTOP');
    try {
      await page.getByTestId('alarms').getByText('no image arrives').waitFor({ timeout: 15_000 });
    } finally {
      process.kill(pid, 'SIGCONT');
    }
    await eventually('it watches again', async () => (await platform.snapshot()).gvs.state === 'watching', { within_ms: 20_000 });
  });

  await t.test('no image is sent to a closed page', async () => {
    await page.goto('about:blank');
    // Two seconds after the last request none is sent any more, and three later the last one is too old to be shown.
    await sleep(6_000);
    assert.equal((await fetch(`${platform.url}/api/v1/gvs/preview`)).status, 204);
    await eventually('requested again, it comes again', async () => (await fetch(`${platform.url}/api/v1/gvs/preview`)).status === 200, { within_ms: 8_000, every_ms: 250 });
  });
  assert.deepEqual(page.script_errors, []);
});

test('an AIV on the floor without a program has no twin, and the camera reports it', { timeout: 120_000 }, async (t) => {
  const folder = work_folder(t);
  const broker = await start_broker(t, folder);
  const port = await free_port();
  const part = (name, ...args) => new Program(t, cosiva_binary(), [...args, '--broker', broker.address], { cwd: folder, name });
  const sockets = path.join(folder, 'boards');
  mkdirSync(sockets);
  part('plant', 'plant', '--zone', zone_file('lacet4'), '--vehicles', '2', '--sockets', sockets);
  part('server', 'server', '--port', String(port), '--headless');
  part('aiv1', 'aiv', '--number', '1', '--sockets', sockets, '--start', 'loop_se:1.2');
  part('gvs', 'gvs', 'watch');
  const snapshot = async () => (await fetch(`http://127.0.0.1:${port}/api/v1/snapshot`)).json();
  const finding = await eventually('AIV2 is named', async () => (await snapshot()).bijection.findings.find(({ kind }) => kind === 'no twin'), { within_ms: 60_000, every_ms: 200 });
  assert.equal(finding.id, 'CoSiVA/AIV2');
  assert.match(finding.text, /the camera sees it \(tag 2\) at \(-?\d+\.\d, -?\d+\.\d\), and it has no twin/);
  part('aiv2', 'aiv', '--number', '2', '--sockets', sockets, '--start', 'loop_ne:1.2');
  await eventually('with its program it has one, and nothing is wrong', async () => {
    const { bijection, gvs } = await snapshot();
    return gvs.detections.some(({ id, twin }) => id === 'CoSiVA/AIV2' && twin) && !bijection.findings.some(({ kind }) => kind === 'no twin');
  }, { within_ms: 40_000, every_ms: 200 });
});

test('recorded images of a calibrated camera are processed to their end, and then missed', { timeout: 180_000 }, async (t) => {
  const folder = work_folder(t);
  const run = async (...args) => {
    const said = await cosiva(args, { cwd: folder });
    assert.equal(said.code, 0, said.stderr);
  };
  await run('gvs', 'render', '--zone', zone_file('lacet4'), '--aivs', '2', '--size', '800', '--tag-side', '0.12', '--seconds', '3', '--rate', '5', '--out', 'area');
  await run('gvs', 'calibrate', '--points', 'area/points.csv', '--size', '800x800', '--camera-height', '3.3', '--tag-height', '0.1', '--model', 'lens', '--out', 'cal');
  const source = ['--gvs', '--gvs-images', 'area/images', '--gvs-calibration', 'cal/calibration.json', '--gvs-exposure', '4', '--gvs-tag-side', '0.12'];
  const wrong = path.join(folder, 'wrong.json');
  writeFileSync(wrong, readFileSync(path.join(folder, 'cal/calibration.json'), 'utf8').replace('"homography"', '"homo"'));

  await t.test('a wrong calibration is reported before anything is started', async () => {
    const said = await cosiva(['up', ...source.map((one, i) => (i === 4 ? wrong : one))], { cwd: folder });
    assert.equal(said.code, 2);
    assert.match(said.stderr, /wrong\.json/);
  });

  await t.test('the platform goes on when they end', async () => {
    const platform = await Platform.up(t, { aivs: 1, folder, args: source });
    const finding = await eventually('their end is named', async () => (await findings(platform)).find(({ kind }) => kind === 'no detection'), { within_ms: 40_000, every_ms: 100 });
    assert.match(finding.text, /there are no more images/);
    const { gvs, aivs } = await platform.snapshot();
    assert.equal(gvs.state, 'unresponsive');
    assert.match(gvs.source, /area\/images/);
    assert.ok(aivs.every((aiv) => !aiv.lost));
  });
});
