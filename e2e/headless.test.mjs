// The minute that the platform must be able to show: four AIVs on lacet4, with commands, and the accuracy of the
// twins.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { cosiva, eventually, fetched, free_port, sleep, work_folder } from './lib/platform.mjs';

const report_period_ms = 100;

test('cosiva up --headless for a minute keeps the bijection', { timeout: 150_000 }, async (t) => {
  const folder = work_folder(t);
  const port = await free_port();
  const args = ['up', '--headless', '--zone', 'lacet4', '--aivs', '4', '--duration', '60', '--json', '--port', String(port), '--run-dir', `${folder}/run`, '--log-dir', `${folder}/log`];
  const running = cosiva(args, { timeout_ms: 120_000, cwd: folder });
  const given = await give_commands(port);
  const result = await running;
  assert.equal(result.code, 0, result.stderr.slice(-3000));
  const summary = JSON.parse(result.stdout);
  const { bijection } = summary;
  const woken = `the server woke late by ${JSON.stringify(bijection.late_ms)}`;

  await t.test('every vehicle has its twin, all the time', () => {
    assert.deepEqual([bijection.physical, bijection.virtual, bijection.matched], [4, 4, 4]);
    assert.deepEqual(bijection.orphans, []);
    assert.equal(bijection.matched_ratio, 1);
  });
  await t.test('no vehicle touched another', () => assert.equal(Array.isArray(summary.collisions) ? summary.collisions.length : summary.collisions, 0));
  await t.test('the twin is within 3 cm of the report', () => {
    assert.ok(bijection.divergence_m.count > 1_000, `only ${bijection.divergence_m.count} samples`);
    assert.ok(bijection.divergence_m.p99 <= 0.03, `p99 ${bijection.divergence_m.p99} m; ${woken}`);
  });
  await t.test('reports are at most one and a half periods old', () => {
    assert.ok(bijection.age_ms.count > 1_000);
    assert.ok(bijection.age_ms.p99 <= 1.5 * report_period_ms, `p99 ${bijection.age_ms.p99} ms; ${woken}`);
  });
  await t.test('every command materialised', () => {
    const { issued, materialised, failed } = bijection.commands;
    assert.equal(failed, 0);
    assert.equal(materialised, issued);
    assert.ok(issued >= given, `${issued} of ${given} commands counted`);
  });
  await t.test('events of the physical side were reflected', () => assert.ok(bijection.events.count > 0));
  await t.test('the AIVs circulated', () => {
    assert.equal(typeof summary.laps, 'number');
    assert.match(summary.digest, /^[0-9a-f]{8,}$/);
  });
});

/** Stops, slows and restarts vehicles during the run; 0 where a headless run serves no HTTP. */
async function give_commands(port) {
  const url = `http://127.0.0.1:${port}/api/v1`;
  const get = async (what) => JSON.parse((await fetched(`${url}/${what}`, 2_000)).text);
  const there = await eventually('the platform responds', async () => (await get('snapshot')).aivs.length === 4, { within_ms: 15_000 }).catch(() => false);
  if (!there) return 0;
  await sleep(5_000);
  let given = 0;
  const give = async (command, vehicle) => {
    const response = await fetch(`${url}/commands`, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ command, vehicle }) });
    assert.equal(response.status, 202);
    given++;
  };
  const standing = async (vehicle) => (await get('snapshot')).aivs.find((aiv) => aiv.id === vehicle).status === 'stopped';
  await give('stop', 'CoSiVA/AIV1');
  await eventually('AIV1 is stopped', () => standing('CoSiVA/AIV1'), { within_ms: 5_000 });
  await give('slow', 'CoSiVA/AIV3');
  await sleep(1_000);
  await give('restart', 'CoSiVA/AIV1');
  await sleep(3_000);
  await give('restart', 'CoSiVA/AIV3');
  return given;
}
