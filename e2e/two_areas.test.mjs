// Two servers on one broker, one area each, over one floor. A vehicle goes from one area to the other and back by `go`
// alone: it is always in exactly one server's table, except for the duration of one message, and drives by that
// server's orders. A server that is killed has its vehicles again after its restart.
import assert from 'node:assert/strict';
import path from 'node:path';
import { test } from 'node:test';
import { Bus, Truth } from './lib/bus.mjs';
import { cosiva_binary, eventually, fetched, free_port, Program, sleep, source_dir, start_broker, work_folder } from './lib/platform.mjs';

const nobodys_ms_max = 200;
const zone = (name) => path.join(source_dir, 'e2e/areas', `${name}.toml`);

class ControlArea {
  constructor(t, folder, name, broker, port) {
    Object.assign(this, { t, folder, name, broker, port, url: `http://127.0.0.1:${port}` });
    this.start();
  }

  start() {
    const args = ['server', '--area', this.name, '--zone', zone(`area_${this.name}`), '--broker', this.broker, '--port', String(this.port), '--headless', '--store', path.join(this.folder, `${this.name}.store`)];
    this.program = new Program(this.t, cosiva_binary(), args, { cwd: this.folder, name: `server ${this.name}` });
  }

  async snapshot() {
    return JSON.parse((await fetched(`${this.url}/api/v1/snapshot`, 2_000)).text);
  }

  async has(id) {
    return (await this.snapshot()).aivs.some((aiv) => aiv.id === id);
  }

  async go(vehicle, to) {
    const response = await fetch(`${this.url}/api/v1/commands`, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ command: 'go', vehicle, to }) });
    return { status: response.status, body: await response.json() };
  }
}

/** Queries ten times a second which server has each vehicle. A change between two queries is not a fault: twice means
 * that one server has it before and after the query to the other one. */
class Watch {
  constructor(areas, vehicles) {
    Object.assign(this, { areas, vehicles, looks: 0, twice: [], gaps_ms: [], since: new Map(), stopped: false });
    this.done = this.run();
  }

  async look() {
    const [a, b] = this.areas;
    const asked = Date.now();
    const ids = (snapshot) => new Set(snapshot.aivs.map((aiv) => aiv.id));
    const [before, other, after] = [ids(await a.snapshot()), ids(await b.snapshot()), ids(await a.snapshot())];
    this.looks += 1;
    for (const id of this.vehicles) {
      if (before.has(id) && other.has(id) && after.has(id)) this.twice.push({ id, asked });
      const somewhere = before.has(id) || other.has(id) || after.has(id);
      if (somewhere && this.since.has(id)) {
        this.gaps_ms.push({ id, ms: Date.now() - this.since.get(id) });
        this.since.delete(id);
      } else if (!somewhere && !this.since.has(id)) {
        this.since.set(id, asked);
      }
    }
  }

  async run() {
    while (!this.stopped) {
      const next = Date.now() + 100;
      await this.look();
      // A vehicle that is in no table is queried again at once, to measure for how long.
      if (this.since.size === 0) await sleep(Math.max(0, next - Date.now()));
    }
  }

  async end() {
    this.stopped = true;
    await this.done;
    for (const [id, since] of this.since) this.gaps_ms.push({ id, ms: Date.now() - since });
  }
}

test('a vehicle goes from area to area and back, and never loses its twin', { timeout: 120_000 }, async (t) => {
  const folder = work_folder(t);
  const { address, port } = await start_broker(t, folder);
  const bus = await Bus.open(t, port, ['cosiva/v1/owner/+/+', 'uagv/v2/+/+/order', 'uagv/v2/CoSiVA/AIV2/visualization']);
  const owners = [];
  const orders = [];
  const said_by_local = [];
  let ground_truth;
  bus.on_message((topic, payload) => {
    const [, , name, maker, serial] = topic.split('/');
    if (name === 'owner') owners.push({ id: `${maker}/${serial}`, ...JSON.parse(payload.toString()) });
    else if (serial === 'visualization') said_by_local.push({ place: JSON.parse(payload.toString()).agvPosition, body: ground_truth?.vehicle(2) });
    else orders.push({ after: owners.length, ...JSON.parse(payload.toString()) });
  });
  const sockets = path.join(folder, 'boards');
  new Program(t, cosiva_binary(), ['plant', '--zone', zone('floor'), '--vehicles', '2', '--sockets', sockets, '--broker', address], { cwd: folder });
  const a = new ControlArea(t, folder, 'a', address, await free_port());
  const b = new ControlArea(t, folder, 'b', address, await free_port());
  ground_truth = await Truth.follow(t, port);
  const starts = ['a_far:2.3', 'b_far:2.3'];
  const ones = [];
  const start_aiv = (number) => {
    const args = ['aiv', '--number', String(number), '--sockets', sockets, '--start', starts[number - 1], '--broker', address, '--state-file', path.join(folder, `aiv${number}.state_file`)];
    ones[number - 1] = new Program(t, cosiva_binary(), args, { cwd: folder, name: `aiv ${number}` });
  };
  start_aiv(1);
  start_aiv(2);
  const [traveller, local] = ['CoSiVA/AIV1', 'CoSiVA/AIV2'];
  const words = () => [a.program, b.program, ...ones].map(({ name, words: said }) => `--- ${name}\n${said.slice(-1500)}`).join('\n');
  const tables = async () => JSON.stringify(await Promise.all([a, b].map(async (area) => (await area.snapshot().catch(() => undefined))?.aivs)));
  const in_time = (what, question, options) => eventually(what, question, options).catch(async (error) => {
    throw new Error(`${error.message}\n${await tables()}\n${words()}`);
  });

  await in_time('each vehicle is claimed by the area it is in', async () => (await a.has(traveller)) && (await b.has(local)), { within_ms: 15_000 });
  assert.equal(await b.has(traveller), false);
  assert.equal(await a.has(local), false);
  await in_time('the areas know each other', async () => (await a.snapshot()).area.others.some(({ name, online }) => name === 'b' && online) && (await b.snapshot()).area.others.some(({ name, online }) => name === 'a' && online));

  for (const [to, why] of [['c/rack', /area 'c'/], ['b/nowhere', /no station or waypoint 'nowhere'/]]) {
    const refused = await a.go(traveller, to);
    assert.ok(refused.status >= 400, `${to}: ${refused.status}`);
    assert.match(JSON.stringify(refused.body), why);
  }

  const apart = async (from, number) => {
    const { aivs } = await from.snapshot();
    const [twin, body] = [aivs.find(({ id }) => id === `CoSiVA/AIV${number}`), ground_truth.vehicle(number)];
    return Math.hypot(twin.x - body.x, twin.y - body.y);
  };
  const watch = new Watch([a, b], [traveller, local]);
  const travels = async (from, into, rack) => {
    const said = owners.length;
    const asked = Date.now();
    const answer = await from.go(traveller, `${into.name}/${rack}`);
    assert.equal(answer.status, 202, JSON.stringify(answer.body));
    await in_time(`area ${into.name} has it`, () => into.has(traveller), { within_ms: 30_000 });
    // The message comes over another connection than the snapshot.
    const handed = await in_time('its new owner is published', () => owners.slice(said).find(({ id }) => id === traveller));
    assert.equal(handed.area, into.name);
    assert.deepEqual(handed.mission, { kind: 'go', name: rack });
    await in_time(`it is stopped at ${rack}`, async () => {
      const { aivs } = await into.snapshot();
      const { mission } = aivs.find(({ id }) => id === traveller);
      return mission.to === rack && mission.state === 'arrived';
    }, { within_ms: 30_000 });
    const off_m = await apart(into, 1);
    assert.ok(off_m < 0.1, `its twin is ${off_m} m from it`);
    return Date.now() - asked;
  };
  const there_ms = await travels(a, b, 'rack_b');
  const away = await a.go(traveller, 'rack_a');
  assert.ok(away.status >= 400, 'a area cannot send what is not its own');
  const back_ms = await travels(b, a, 'rack_a');
  await watch.end();

  const longest_ms = Math.max(0, ...watch.gaps_ms.map(({ ms }) => ms));
  t.diagnostic(`there ${there_ms} ms, back ${back_ms} ms, ${watch.looks} queries, ${watch.gaps_ms.length} gaps, the longest ${longest_ms} ms, ${orders.length} orders`);
  assert.deepEqual(watch.twice, [], 'no vehicle is ever in both tables');
  assert.ok(longest_ms <= nobodys_ms_max, `in no table for ${longest_ms} ms`);
  assert.ok(watch.looks > 100, `only ${watch.looks} queries`);
  // The map of an order identifies the server that sent it.
  let area = 'a';
  const maps = orders.filter(({ serialNumber }) => serialNumber === 'AIV1').map(({ nodes }) => nodes[0].nodePosition.mapId);
  const changes = maps.filter((map, i) => i > 0 && map !== maps[i - 1]);
  assert.deepEqual([maps[0], ...changes], ['area_a', 'area_b', 'area_a'], 'each server orders only while it is the owner');
  for (const { after, nodes, serialNumber } of orders) {
    if (serialNumber !== 'AIV1') continue;
    area = owners.slice(0, after).filter(({ id }) => id === traveller).at(-1)?.area;
    assert.equal(nodes[0].nodePosition.mapId, `area_${area}`);
  }
  ground_truth.assert_no_collision();

  process.kill(b.program.pid, 'SIGKILL');
  await in_time('server b is gone', () => b.program.gone);
  b.start();
  await in_time('it has its vehicle again, and only that', async () => {
    const { aivs } = await b.snapshot();
    return aivs.length === 1 && aivs[0].id === local && aivs[0].connection === 'ONLINE';
  }, { within_ms: 10_000 });
  assert.equal(await a.has(local), false, 'no server took it meanwhile');

  // The zone that the emulated world serves is not the one that its state_file belongs to.
  await in_time('AIV2 is far from where it started', () => ground_truth.vehicle(2).y > -0.35, { within_ms: 25_000 });
  process.kill(ones[1].pid, 'SIGKILL');
  await in_time('AIV2 is gone', () => ones[1].gone);
  await ground_truth.stands(2, 3_000);
  const said = said_by_local.length;
  start_aiv(2);
  await in_time('it reports its position again', () => said_by_local.length > said + 10);
  for (const { place, body } of said_by_local.slice(said)) {
    const off_m = Math.hypot(place.x - body.x, place.y - body.y);
    assert.ok(off_m < 0.2, `its reported position is ${off_m} m off: ${JSON.stringify(place)}`);
  }
  const driven = ground_truth.vehicle(2).distance;
  await in_time('it drives on', () => ground_truth.vehicle(2).distance > driven + 0.5, { within_ms: 15_000 });
  ground_truth.assert_no_collision();
});
