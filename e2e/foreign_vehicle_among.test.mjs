// A third-party vehicle among CoSiVA AIVs: no two bodies may ever touch on the virtual side (the plant does not
// contain the third-party vehicle).
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { bodies_touch, Circuit } from './lib/circuit.mjs';
import { follow, start_foreign_vehicle, stranger } from './lib/foreign_vehicle.mjs';
import { eventually, lacet4_length_m, Platform } from './lib/platform.mjs';

const body = { length: 0.2, width: 0.12 };

test('a third-party vehicle drives a lap among CoSiVA AIVs without a collision', { timeout: 300_000 }, async (t) => {
  const circuit = await Circuit.load();
  const platform = await Platform.up(t, { aivs: 3 });
  const free = await a_place_apart(platform, circuit);
  await start_foreign_vehicle(t, { broker_port: await platform.broker_port(), circuit, waypoint: free, speed_mps: 0.5 });
  await eventually('it is shown', async () => (await platform.snapshot()).aivs.length === 4, { within_ms: 5_000 });

  const touched = [];
  const before = await distances(platform);
  const sections = await follow(platform.url, stranger, lacet4_length_m, 200_000, ({ aivs }) => {
    aivs.forEach((a, i) => aivs.slice(i + 1).forEach((b) => {
      if (bodies_touch(a, b, body.length, body.width)) touched.push(`${a.id} and ${b.id} at ${a.section} ${a.s}`);
    }));
  });
  assert.equal(sections.size, 8);
  assert.deepEqual(touched, []);
  const after = await distances(platform);
  for (const id of before.keys()) assert.notEqual(after.get(id), before.get(id), `${id} went on, too`);
});

/** A waypoint on a loop, a metre from every vehicle. */
async function a_place_apart(platform, circuit) {
  const { aivs } = await platform.snapshot();
  const apart = (waypoint) => Math.min(...aivs.map((aiv) => Math.hypot(aiv.x - waypoint.x, aiv.y - waypoint.y)));
  const best = circuit.waypoints
    .map((waypoint, index) => ({ index, waypoint, apart: apart(waypoint) }))
    .filter(({ waypoint }) => waypoint.section.startsWith('loop_'))
    .sort((a, b) => b.apart - a.apart)[0];
  assert.ok(best.apart > 0.8, `the freest waypoint is ${best.apart} m from an AIV`);
  return best.index;
}

async function distances(platform) {
  return new Map((await platform.snapshot()).aivs.map((aiv) => [aiv.id, `${aiv.lastNode} ${aiv.orderUpdateId}`]));
}
