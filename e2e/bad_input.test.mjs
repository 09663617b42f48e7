// Errors of users and of the environment: each gets a clear message and the right exit code, and nothing stops.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import path from 'node:path';
import { test } from 'node:test';
import { finally_do } from './lib/cleanup.mjs';
import { Bus, Truth } from './lib/bus.mjs';
import { cosiva, cosiva_binary, eventually, free_port, Platform, Program, sleep, work_folder, zone_file } from './lib/platform.mjs';

const good = readFileSync(zone_file('lacet4'), 'utf8');
const line_of = (text, wanted) => text.slice(0, text.indexOf(wanted)).split('\n').length;
const once = (from, to) => {
  const changed = good.replace(from, to);
  assert.notEqual(changed, good, String(from));
  return changed;
};

// Each fault: its name, the file that has it, the location to be reported (a text of that line), and a term of the
// reason.
const faults = [
  ['a syntax error', once('name = "lacet4"', 'name = "lacet4'), 'name = "lacet4', /./],
  ['an unknown format version', once('format_version = 1', 'format_version = 99'), 'format_version', /format_version|version/],
  ['no format version', once('format_version = 1\n', ''), null, /format_version/],
  ['no name', once('name = "lacet4"\n', ''), null, /name/],
  ['text where a number is due', once('length_m = 0.20', 'length_m = "long"'), 'length_m = "long"', /length_m/],
  ['a negative length', once('length_m = 1.5', 'length_m = -1.5'), 'length_m = -1.5', /length_m/],
  ['a radius of zero', once(/radius_m = [\d.]+/, 'radius_m = 0.0'), 'radius_m = 0.0', /radius_m/],
  ['a number that is none', once(/radius_m = [\d.]+/, 'radius_m = nan'), 'radius_m = nan', /radius_m/],
  ['an unknown kind of section', once('kind = "arc"', 'kind = "spiral"'), 'kind = "spiral"', /kind|spiral/],
  ['an unknown field', once('width_m = 0.12', 'widht_m = 0.12'), null, /widht_m|width_m/],
  ['two sections of one name', once('name = "north"', 'name = "east"'), null, /east/],
  ['a loop that does not close', once('angle_deg = -270', 'angle_deg = -260'), null, /clos|ends at/],
  ['a tag on no section', once('section = "east"\ns_m = 1.471', 'section = "nowhere"\ns_m = 1.471'), 'section = "nowhere"', /nowhere/],
  ['a tag beyond its section', once('s_m = 1.471', 's_m = 9.5'), 's_m = 9.5', /s_m/],
  ['two tags of one number', once('number = 2', 'number = 1'), null, /number|tag/],
  ['a beacon pitch of zero', once(/pitch_m = [\d.]+/, 'pitch_m = 0'), 'pitch_m = 0', /pitch_m/],
  ['a speed of zero', once(/speed_mps = [\d.]+/, 'speed_mps = 0'), 'speed_mps = 0\n', /speed_mps/],
  ['no section at all', good.replace(/\[\[section\]\][^[]*/g, ''), null, /section/],
  ['an empty file', '', null, /./],
];

test('zone files with each kind of fault', { timeout: 120_000 }, async (t) => {
  const folder = work_folder(t);
  for (const [what, text, place, why] of faults) {
    await t.test(what, async () => {
      const file = path.join(folder, `${what.replace(/ /g, '_')}.toml`);
      writeFileSync(file, text);
      const { code, stderr } = await cosiva(['zone', 'check', file]);
      assert.equal(code, 2, stderr);
      assert.ok(stderr.includes(file), `names the file: ${stderr}`);
      assert.match(stderr, why);
      const line = new RegExp(`${path.basename(file)}:(\\d+)`).exec(stderr)?.[1];
      if (place !== null) assert.equal(Number(line), line_of(text, place), stderr);
      else if (text !== '') assert.ok(Number(line) >= 1, `names a line: ${stderr}`);
    });
  }
  await t.test('a good one passes', async () => assert.equal((await cosiva(['zone', 'check', zone_file('lacet4')])).code, 0));
  await t.test('no such file', async () => {
    const { code, stderr } = await cosiva(['zone', 'check', path.join(folder, 'none.toml')]);
    assert.equal(code, 2);
    assert.match(stderr, /none\.toml/);
  });
  await t.test('up refuses a faulty zone as zone check does, and starts nothing', async () => {
    const file = path.join(folder, 'a_negative_length.toml');
    const { code, stderr } = await cosiva(['up', '--headless', '--zone', file, '--duration', '5', '--run-dir', `${folder}/run`, '--log-dir', `${folder}/log`]);
    assert.equal(code, 2, stderr);
    assert.match(stderr, /a_negative_length\.toml:\d+/);
  });
});

test('wrong arguments on the command line', { timeout: 60_000 }, async (t) => {
  await t.test('an unknown subcommand names the nearest', async () => {
    const { code, stderr, stdout } = await cosiva(['serve']);
    assert.equal(code, 2);
    assert.match(stderr, /did you mean.*server/i);
    assert.equal(stdout, '');
  });
  await t.test('an unknown option', async () => {
    const { code, stderr } = await cosiva(['up', '--aiv', '4', '--duraton', '3']);
    assert.equal(code, 2);
    assert.match(stderr, /--duraton|--aiv\b/);
  });
  await t.test('a number out of range', async () => {
    const { code, stderr } = await cosiva(['up', '--aivs', '-3']);
    assert.equal(code, 2);
    assert.match(stderr, /aivs/);
  });
  await t.test('an unknown zone', async () => {
    const { code, stderr } = await cosiva(['up', '--headless', '--zone', 'lacet5', '--duration', '1']);
    assert.equal(code, 2);
    assert.match(stderr, /lacet5/);
  });
  await t.test('--help is no error', async () => {
    const { code, stdout } = await cosiva(['--help']);
    assert.equal(code, 0);
    assert.match(stdout, /up/);
  });
});

test('a busy port is reported and another is taken', { timeout: 90_000 }, async (t) => {
  const port = await free_port();
  const squatter = createServer().listen(port, '127.0.0.1');
  finally_do(t, () => squatter.close());
  const platform = await Platform.up(t, { aivs: 1, port, ready: false });
  const other = await eventually('it names the port it took', () => {
    const ports = [...platform.words.matchAll(/127\.0\.0\.1:(\d+)/g)].map((match) => Number(match[1])).filter((candidate) => candidate !== port);
    return ports.length > 0 && ports;
  });
  assert.ok(platform.words.includes(String(port)), `the output reports that ${port} is busy:\n${platform.words}`);
  const answers = await eventually('the page is served there', async () => {
    for (const candidate of other) {
      const response = await fetch(`http://127.0.0.1:${candidate}/api/v1/snapshot`, { signal: AbortSignal.timeout(500) }).catch(() => null);
      if (response?.ok) return true;
    }
    return false;
  });
  assert.ok(answers);
});

test('a broker that refuses is reported, and tried again', { timeout: 60_000 }, async (t) => {
  const folder = work_folder(t);
  const nobody = await free_port();
  const server = new Program(t, cosiva_binary(), ['server', '--broker', `127.0.0.1:${nobody}`, '--port', String(await free_port())], { cwd: folder });
  await eventually('the server reports it', () => server.words.includes(String(nobody)) && /refused|cannot|not reach|connect/i.test(server.words), { within_ms: 8_000 });
  await sleep(2_000);
  assert.ok(!server.gone, 'it goes on trying');
  await server.stop({ within_ms: 5_000 });
});

test('invalid messages on the bus and over HTTP stop nothing', { timeout: 90_000 }, async (t) => {
  const platform = await Platform.up(t);
  const bus = await Bus.open(t, await platform.broker_port(), []);
  const ground_truth = await Truth.follow(t, await platform.broker_port());

  const payloads = ['', 'nonsense', '{', '[]', 'null', '{"headerId":-1}', '{"headerId":1e999}', '"\\ud800"', '['.repeat(100_000), '\u0000\u0001'];
  const topics = ['uagv/v2/CoSiVA/AIV1/state', 'uagv/v2/CoSiVA/AIV1/order', 'uagv/v2/CoSiVA/AIV2/instantActions', 'uagv/v2/CoSiVA/AIV3/visualization', 'uagv/v2/CoSiVA/AIV9/connection', 'uagv/v2/Evil/x/state', 'cosiva/v1/server/heartbeat', 'cosiva/v1/zone/toml', 'cosiva/v1/zone/xml', 'cosiva/v1/plant/command'];
  for (const topic of topics) for (const payload of payloads) await bus.client.publishAsync(topic, payload);
  for (const topic of topics) {
    // The broker may disconnect a client that sends this much: a client of its own each time, which waits for no
    // acknowledgement.
    const guest = await Bus.open(t, await platform.broker_port(), []);
    guest.client.publish(topic, `{"a":"${'x'.repeat(3_000_000)}"}`);
    await sleep(150);
    guest.client.end(true);
  }

  const old_order = { headerId: 1, timestamp: '2026-01-01T00:00:00.000Z', version: '9.0.0', manufacturer: 'CoSiVA', serialNumber: 'AIV1', orderId: 'evil', orderUpdateId: 0, nodes: [], edges: [] };
  await bus.publish('uagv/v2/CoSiVA/AIV1/order', old_order);

  const requests = [
    ['POST', '/api/v1/commands', 'nonsense', 400],
    ['POST', '/api/v1/commands', '{"command":"fly","vehicle":"CoSiVA/AIV1"}', 400],
    ['POST', '/api/v1/commands', '{"command":"stop","vehicle":"CoSiVA/AIV99"}', 400],
    ['POST', '/api/v1/commands', `{"command":"${'x'.repeat(200_000)}"}`, 413],
    ['GET', '/api/v1/nothing', null, 404],
    ['GET', '/../../../../etc/passwd', null, 404],
    ['GET', '/api/v1/traces?after=-1&limit=999999999', null, [200, 400]],
    ['DELETE', '/api/v1/snapshot', null, [404, 405]],
  ];
  for (const [method, url, body, expected] of requests) {
    const response = await fetch(platform.url + url, { method, body, headers: body ? { 'content-type': 'application/json' } : {} }).catch((error) => ({ status: error.message }));
    assert.ok([expected].flat().includes(response.status), `${method} ${url.slice(0, 60)}: ${response.status}, expected ${expected}`);
  }

  await sleep(1_000);
  assert.equal(platform.children().every(({ pid }) => pid > 0), true);
  const before = new Map(ground_truth.latest.vehicles.map((vehicle) => [vehicle.number, vehicle.distance]));
  await eventually('all four drive on', () => ground_truth.latest.vehicles.every((vehicle) => vehicle.distance - before.get(vehicle.number) > 0.5), { within_ms: 45_000 });
  const ours = (await platform.snapshot()).aivs.filter((aiv) => aiv.id.startsWith('CoSiVA/AIV') && aiv.number >= 1 && aiv.number <= 4);
  assert.equal(ours.length, 4);
});
