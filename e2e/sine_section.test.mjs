// A kind of section that the platform does not contain (examples/sine_section): its own program reads a zone with it, and a
// fleet drives on it, live.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { Truth } from './lib/bus.mjs';
import { cosiva, cosiva_binary, eventually, Platform, source_dir } from './lib/platform.mjs';

const binary = path.join(path.dirname(cosiva_binary()), 'examples/cosiva_sine');
const zone = path.join(source_dir, 'examples/sine_section/sine.toml');
const amplitude_m = 0.1;
const wavelength_m = 1.5;

/** The sine waves as the zone's drawing shows them, and the distance of a point from the nearest of them. */
function waves_of({ primitives }) {
  const points = primitives.filter(({ layer, kind }) => layer === 'line' && kind === 'sine').map((line) => line.points);
  const distance = ({ x, y }) => Math.min(...points.flat().map(([wave_x, wave_y]) => Math.hypot(x - wave_x, y - wave_y)));
  return { points, distance };
}

/** The length of two waves, by chords: independent of the section's own arc length. */
function two_waves_m() {
  const steps = 100_000;
  const at = (i) => [(i / steps) * 2 * wavelength_m, amplitude_m * Math.sin((i / steps) * 4 * Math.PI)];
  let sum_m = 0;
  for (let i = 0; i < steps; i++) sum_m += Math.hypot(at(i + 1)[0] - at(i)[0], at(i + 1)[1] - at(i)[1]);
  return sum_m;
}

test('a section of one\'s own is read by the program that has it alone', { timeout: 60_000 }, async () => {
  const own = await cosiva(['zone', 'check', zone], { binary });
  assert.equal(own.code, 0, own.stderr);
  const without = await cosiva(['zone', 'check', zone]);
  assert.equal(without.code, 2);
  assert.match(without.stdout + without.stderr, /sine\.toml:\d+.*expected "straight" or "arc" or "clothoid", found "sine"/);
});

test('a fleet drives laps on sine sections, and its twins with it', { timeout: 180_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 2, zone, binary });
  const drawn = waves_of(await platform.get('zone'));
  assert.equal(drawn.points.length, 2, 'the drawing has both waves');
  const { sections } = await platform.get('zone');
  const wave = sections.find(({ name }) => name === 'wave_east');
  assert.ok(Math.abs(wave.length_m - two_waves_m()) < 1e-5, `${wave.length_m} m, by chords ${two_waves_m()} m`);

  const truth = await Truth.follow(t, await platform.broker_port());
  const seen = new Map();
  let farthest_m = 0;
  await eventually(
    'both vehicles have driven on every section twice',
    async () => {
      const { aivs } = await platform.snapshot();
      for (const { id, section } of aivs) {
        const sections_of = seen.get(id) ?? [];
        if (section !== null && sections_of.at(-1) !== section) sections_of.push(section);
        seen.set(id, sections_of);
        // The body itself is on the wave while its twin is: the plant's ground truth, not the vehicle's estimate.
        if (section?.startsWith('wave_')) {
          const body = truth.latest.vehicles.find(({ number }) => id === `CoSiVA/AIV${number}`);
          farthest_m = Math.max(farthest_m, Math.min(drawn.distance(body), 0.3));
        }
      }
      return [...seen.values()].filter((names) => names.length >= 9).length === 2;
    },
    { within_ms: 120_000, every_ms: 100 },
  );
  for (const [id, names] of seen) {
    const round = ['wave_east', 'turn_east', 'wave_west', 'turn_west'];
    const first = round.indexOf(names[0]);
    assert.deepEqual(names.slice(0, 8), Array.from({ length: 8 }, (_, i) => round[(first + i) % 4]), id);
  }
  assert.equal(truth.collisions, 0);
  assert.ok(farthest_m < 0.1, `a body was ${farthest_m} m off the drawn waves`);
  const { bijection } = await platform.snapshot();
  assert.equal(bijection.matched, 2);
  assert.ok(bijection.divergence_m.p99 < 0.05, `divergence ${JSON.stringify(bijection.divergence_m)}`);

  // Figure 11: the section of the example responds to the request of the twin that moves on to the next one.
  const { traces } = await platform.get('traces?after=0&limit=100000');
  const requested = traces.filter(({ kind }) => kind === 'nextAIVposition');
  assert.ok(requested.some(({ content }) => /on wave_east .* m to travel$/.test(content)), 'a request to a sine section');
  assert.ok(readFileSync(zone, 'utf8').includes('kind = "sine"'));
});
