// Travel in indirect direction, live: on order a fleet drives its circuit backwards, and twins, page and orders with it.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { Bus, Truth } from './lib/bus.mjs';
import { cosiva, eventually, Platform, work_folder } from './lib/platform.mjs';

const oval = `name = "oval"
format_version = 1
[circuit]
start = { x = 0, y = 0, heading_deg = 0 }
closed = true
[[section]]
name = "south"
kind = "straight"
length_m = 1.5
[[section]]
name = "east"
kind = "arc"
radius_m = 0.5
angle_deg = 180
[[section]]
name = "north"
kind = "straight"
length_m = 1.5
[[section]]
name = "west"
kind = "arc"
radius_m = 0.5
angle_deg = 180
[[tag]]
number = 1
section = "north"
s_m = 0.4
`;
const backwards = ['south', 'west', 'north', 'east'];

/** The displacement along the body's own heading between two ground truths: negative where it drives backwards. */
const forwards_m = (before, now) =>
  (now.x - before.x) * Math.cos(before.heading) + (now.y - before.y) * Math.sin(before.heading);
const turned = (a, b) => Math.abs(Math.atan2(Math.sin(a - b), Math.cos(a - b)));

test('a fleet drives its circuit backwards on order', { timeout: 150_000 }, async (t) => {
  const zone = path.join(work_folder(t), 'oval.toml');
  writeFileSync(zone, oval);
  const platform = await Platform.up(t, { aivs: 2, zone });
  const broker = await platform.broker_port();
  const truth = await Truth.follow(t, broker);
  const bus = await Bus.open(t, broker, ['uagv/v2/CoSiVA/+/order']);
  const orders = [];
  bus.on_message((_topic, payload) => orders.push(JSON.parse(payload.toString())));
  await eventually('both vehicles drive forwards', () => truth.latest.vehicles.every(({ distance }) => distance > 0.3));

  const switched = await cosiva(['zone', 'switch', `${zone}-indirect`, '--url', platform.url]);
  assert.equal(switched.code, 0, switched.stderr);
  await eventually('both vehicles have stopped on the new map', async () => {
    const { aivs, zone: in_force } = await platform.snapshot();
    return in_force.name === 'oval-indirect' && aivs.every(({ map }) => map === 'oval-indirect');
  });
  orders.length = 0;

  const visited = new Map();
  let before = structuredClone(truth.latest.vehicles);
  let farthest_m = 0;
  await eventually(
    'each vehicle has driven over the whole circuit',
    async () => {
      const { aivs } = await platform.snapshot();
      const now = structuredClone(truth.latest.vehicles);
      for (const body of now) {
        const was = before.find(({ number }) => number === body.number);
        assert.ok(forwards_m(was, body) < 0.005, `AIV${body.number} drives forwards by ${forwards_m(was, body)} m`);
        const twin = aivs.find(({ id }) => id === `CoSiVA/AIV${body.number}`);
        assert.ok(turned(twin.heading, body.heading) < 0.5, `twin ${twin.heading}, vehicle ${body.heading}`);
        farthest_m = Math.max(farthest_m, Math.hypot(twin.x - body.x, twin.y - body.y));
        const sections = visited.get(body.number) ?? [];
        if (twin.section !== null && sections.at(-1) !== twin.section) sections.push(twin.section);
        visited.set(body.number, sections);
      }
      before = now;
      return [...visited.values()].every((sections) => sections.length >= 6);
    },
    { within_ms: 90_000, every_ms: 200 },
  );
  for (const sections of visited.values()) {
    const first = backwards.indexOf(sections[0]);
    sections.forEach((name, i) => assert.equal(name, backwards[(first + i) % 4], sections.join(' ')));
  }
  assert.ok(farthest_m < 0.15, `a twin was ${farthest_m} m from its vehicle`);
  assert.equal(truth.collisions, 0);
  const edges = orders.flatMap((order) => order.edges);
  assert.ok(edges.length > 4);
  for (const edge of edges) {
    assert.equal(edge.orientationType, 'TANGENTIAL');
    assert.ok(Math.abs(edge.orientation - Math.PI) < 1e-9, `${edge.edgeId}: ${edge.orientation}`);
  }

  const back = await cosiva(['zone', 'switch', zone, '--url', platform.url]);
  assert.equal(back.code, 0, back.stderr);
  await eventually('both vehicles drive forwards again', async () => {
    const now = structuredClone(truth.latest.vehicles);
    const forwards = now.every((body) => forwards_m(before.find(({ number }) => number === body.number), body) > 0.01);
    before = now;
    return forwards;
  }, { within_ms: 20_000, every_ms: 300 });
});
