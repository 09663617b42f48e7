// A wrong request is refused with a sentence that states what to do and changes nothing, and the page shows that
// sentence and never internal details.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open_browser } from './lib/browser.mjs';
import { assert_sentence, last_command, notice, open_operator, pixel_of } from './lib/page.mjs';
import { eventually, Platform } from './lib/platform.mjs';

const person = (more) => ({ kind: 'person', x: 0.75, y: 0.75, ...more });
/** [what, method, path, body, status, words of the sentence] */
const refusals = [
  ['a body that is not JSON', 'POST', 'commands', '{"command":', 400, /JSON/],
  ['a body that is a list', 'POST', 'commands', '[]', 400, /object/],
  ['no body at all', 'POST', 'virtual-objects', undefined, 400, /JSON|body/],
  ['an unknown command', 'POST', 'commands', { command: 'fly', vehicle: '*' }, 400, /stop|slow/],
  ['no command', 'POST', 'commands', { vehicle: '*' }, 400, /which command/],
  ['no vehicle', 'POST', 'commands', { command: 'stop' }, 400, /which vehicle/],
  ['an unknown vehicle', 'POST', 'commands', { command: 'stop', vehicle: 'CoSiVA/AIV99' }, 400, /AIV99|AIV1/],
  ['one unknown vehicle among known ones', 'POST', 'commands', { command: 'stop', vehicles: ['CoSiVA/AIV1', 'CoSiVA/AIV99'] }, 400, /AIV99/],
  ['no vehicles', 'POST', 'commands', { command: 'stop', vehicles: [] }, 400, /at least one/],
  ['vehicles that are not names', 'POST', 'commands', { command: 'stop', vehicles: [1, 2] }, 400, /vehicle/],
  ['an unknown kind of virtual object', 'POST', 'virtual-objects', { kind: 'dragon', x: 0, y: 0 }, 400, /person/],
  ['a person off the zone', 'POST', 'virtual-objects', person({ x: 50 }), 400, /zone|between|from/],
  ['a person without a position', 'POST', 'virtual-objects', { kind: 'person' }, 400, /place|path/],
  ['a position that is not a number', 'POST', 'virtual-objects', person({ x: 'left' }), 400, /number/],
  ['a person too wide', 'POST', 'virtual-objects', person({ radius: 9 }), 400, /from .* to/],
  ['a walk of no points', 'POST', 'virtual-objects', { kind: 'person', path: [] }, 400, /points/],
  ['a walk that leaves the zone', 'POST', 'virtual-objects', { kind: 'person', path: [[0.75, 0.75], [99, 0]] }, 400, /zone|between|from/],
  ['an obstacle that walks', 'POST', 'virtual-objects', { kind: 'obstacle', path: [[0.75, 0.75], [0.7, 0.7]] }, 400, /does not move/],
  ['a virtual AIV off the circuit', 'POST', 'virtual-objects', { kind: 'aiv', x: 0.75, y: 0.75 }, 400, /way|circuit/],
  ['a virtual AIV on an unknown section', 'POST', 'virtual-objects', { kind: 'aiv', section: 'moon', s: 0 }, 400, /east/],
  ['moving what is not there', 'PATCH', 'virtual-objects/P99', { x: 0.7, y: 0.7 }, 404, /P99/],
  ['removing what is not there', 'DELETE', 'virtual-objects/P99', undefined, 404, /P99/],
  ['a priority too high', 'PUT', 'priorities', { 'CoSiVA/AIV1': 1000 }, 400, /999/],
  ['a priority that is not a whole number', 'PUT', 'priorities', { 'CoSiVA/AIV1': 1.5 }, 400, /999|whole/],
  ['a priority for a name that is not a vehicle', 'PUT', 'priorities', { nobody: 1 }, 400, /manufacturer|vehicle|serial/],
  ['a tag with a number that is taken', 'POST', 'zone/edit', { addTags: [{ number: 3, section: 'east', s: 0.5 }] }, 400, /tag 3/i],
  ['a tag with no number', 'POST', 'zone/edit', { addTags: [{ section: 'east', s: 0.5 }] }, 400, /number/],
  ['a tag off every section', 'POST', 'zone/edit', { addTags: [{ number: 90, x: 0.75, y: 0.75 }] }, 400, /way|section|circuit/],
  ['a tag beyond its section', 'POST', 'zone/edit', { addTags: [{ number: 90, section: 'east', s: 99 }] }, 400, /east|1\.5/],
  ['removing a tag that is not there', 'POST', 'zone/edit', { removeTags: [99] }, 400, /99/],
  ['a tag that is in the edit twice', 'POST', 'zone/edit', { addTags: [{ number: 90, section: 'east', s: 0.3 }, { number: 90, section: 'east', s: 0.6 }] }, 400, /twice|90/],
  ['beacons on top of each other', 'POST', 'zone/edit', { beaconPitch: 0 }, 400, /pitch|from/],
  ['an edit that changes nothing', 'POST', 'zone/edit', {}, 400, /change/],
  ['undoing nothing', 'POST', 'zone/undo', undefined, 409, /nothing to undo/],
  ['doing nothing again', 'POST', 'zone/redo', undefined, 409, /again|redo/],
  ['a physical obstacle off the zone', 'POST', 'plant/obstacles', { x: 50, y: 0 }, 400, /zone|between|from/],
  ['a physical obstacle that is not there', 'DELETE', 'plant/obstacles/box99', undefined, 404, /box99/],
  ['setting the wall’s clock', 'PUT', 'clock', { speed: 4 }, 409, /virtual/],
  ['a step of the wall’s clock', 'POST', 'clock/step', { ms: 100 }, 409, /virtual/],
  ['a trace that is not stored', 'GET', 'traces/999999999', undefined, 404, /kept|trace/],
  ['traces after no number', 'GET', 'traces?after=never', undefined, 400, /number/],
  ['an unknown call', 'GET', 'weather', undefined, 404, /api/i],
  ['a wrong method', 'DELETE', 'snapshot', undefined, 405, /GET/],
];

test('wrong requests are refused with a sentence', { timeout: 120_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2 });
  const browser = await open_browser(t);
  const page = await open_operator(t, browser, platform);
  const what_counts = async () => {
    const { virtualObjects, zoneRevision, aivs, zoneEdits } = await platform.snapshot();
    return { virtualObjects, zoneRevision, zoneEdits, priorities: aivs.map((aiv) => aiv.priority), tags: (await platform.get('zone')).tags };
  };
  const before = await what_counts();

  for (const [what, method, path, body, status, words] of refusals) {
    await t.test(what, async () => {
      const answer = await platform.call(method, path, body);
      assert.equal(answer.status, status, JSON.stringify(answer.body));
      const { code, message } = answer.body.error;
      assert.match(code, /^[a-z_]+(\.[a-z_]+)+$/);
      assert.match(message, words);
      assert.ok(message.length < 500 && / /.test(message.trim()), message);
    });
  }
  await t.test('nothing changed by any of it', async () => assert.deepEqual(await what_counts(), before));

  await t.test('a command to a vehicle that is offline waits for it, with the reason', async () => {
    await platform.without_supervisor(async () => {
      await platform.kill_child(/aiv\D*2$/i);
      await eventually('AIV2 is lost', async () => (await platform.aiv(2)).connection !== 'ONLINE', { within_ms: 8_000 });
      const answer = await platform.call('POST', 'commands', { command: 'slow', vehicle: 'CoSiVA/AIV2' });
      assert.equal(answer.status, 202);
      const command = await eventually('it waits', async () => {
        const last = await last_command(platform, 'CoSiVA/AIV2');
        return last?.state === 'issued' && last;
      }, { within_ms: 2_000 });
      assert_sentence(command.reason);
      assert.match(command.reason, /not connected; the command holds/);
      await page.getByRole('button', { name: 'Slow AIV2', exact: true }).click();
      const said = await eventually('the page shows it', async () => {
        const texts = [...(await page.getByTestId('notice').allInnerTexts()), ...(await page.locator('[data-aiv="CoSiVA/AIV2"] [data-command-state=issued]').allInnerTexts())];
        return texts.find((text) => /not connected|offline|broken/i.test(text));
      }, { within_ms: 4_000 });
      assert_sentence(said);
    });
    await eventually('AIV2 is back', async () => (await platform.aiv(2)).connection === 'ONLINE', { within_ms: 20_000 });
  });

  await t.test('the page: a person off the zone', async () => {
    const zone = await platform.get('zone');
    // Zoomed out, the map also shows the area outside the zone.
    for (let i = 0; i < 8; i++) await page.keyboard.press('-');
    await page.getByTestId('tool-add-person').click();
    const box = await page.getByTestId('circuit').boundingBox();
    await page.mouse.click(box.x + box.width - 120, box.y + 20);
    const said = await notice(page, /person/i);
    assert.match(said, new RegExp(`zone|${zone.bounds[0].toFixed(1)}|between|from`));
    await page.keyboard.press('Escape');
    await page.getByTestId('circuit').focus();
    await page.keyboard.press('Home');
  });

  await t.test('the page: a virtual AIV off the circuit', async () => {
    await page.getByTestId('tool-add-aiv').click();
    const at = await pixel_of(page, platform, 0.75, 0.75);
    await page.mouse.click(at.x, at.y);
    await notice(page, /way|circuit/i);
  });

  await t.test('the page: a tag number that is taken', async () => {
    await page.getByTestId('tool-edit-tags').click();
    await page.getByTestId('tag-choice').selectOption('5');
    await page.getByTestId('tag-number').fill('6');
    await page.getByTestId('tag-number').press('Enter');
    await notice(page, /tag 6/i);
    assert.equal(await page.getByTestId('tag-choice').inputValue(), '5', 'the tag that was meant stays the chosen one');
    assert.equal(await page.getByTestId('tag-number').inputValue(), '5');
    await page.getByTestId('beacon-pitch').fill('0.001');
    await page.getByTestId('beacon-pitch').press('Enter');
    await notice(page, /pitch|beacon/i);
    await page.getByLabel('Close the tags').click();
  });

  await t.test('the page: a priority that is none', async () => {
    await page.getByLabel('Priority of AIV1').fill('x');
    await page.getByLabel('Priority of AIV1').press('Enter');
    await notice(page, /0 to 999/);
  });

  await t.test('nothing on the page shows what is inside', async () => {
    for (const text of await page.getByTestId('notice').allInnerTexts()) assert_sentence(text);
    assert.doesNotMatch(await page.locator('body').innerText(), /undefined|NaN|\[object|Error:/);
    assert.deepEqual(await what_counts(), before);
  });
  assert.deepEqual(page.script_errors, []);
});
