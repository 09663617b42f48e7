// Every VDA 5050 message on the bus during a run, validated with the official schemas.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { Bus } from './lib/bus.mjs';
import { eventually, Platform, sleep, source_dir, work_folder } from './lib/platform.mjs';

const kinds = ['order', 'instantActions', 'state', 'visualization', 'connection', 'factsheet'];

test('every message on the bus is valid', { timeout: 120_000 }, async (t) => {
  const platform = await Platform.up(t, { aivs: 3 });
  const bus = await Bus.open(t, await platform.broker_port(), ['uagv/#']);
  const messages = [];
  bus.on_message((topic, payload, packet) => messages.push({ topic, payload: payload.toString(), retain: packet.retain }));

  await sleep(6_000);
  await platform.command('stop', 'CoSiVA/AIV1');
  await platform.command('slow', 'CoSiVA/AIV2');
  await sleep(3_000);
  await platform.command('restart', '*');
  await platform.command('cancel', 'CoSiVA/AIV3');
  await sleep(8_000);
  await platform.kill_child(/aiv\D*1$/i); // its last will is a message, too
  await sleep(6_000);
  await eventually('it came back', async () => (await platform.aiv(1)).connection === 'ONLINE');

  const seen = Object.fromEntries(kinds.map((kind) => [kind, messages.filter(({ topic }) => topic.endsWith(`/${kind}`)).length]));
  t.diagnostic(JSON.stringify(seen));
  for (const kind of kinds) assert.ok(seen[kind] > 0, `some ${kind} passed`);
  assert.ok(messages.some(({ payload }) => payload.includes('CONNECTIONBROKEN')));

  const file = path.join(work_folder(t), 'bus.ndjson');
  const lines = messages.filter(({ payload }) => payload !== '').map(({ topic, payload }) => JSON.stringify({ topic, payload }));
  writeFileSync(file, `${lines.join('\n')}\n`);
  const check = spawnSync('/usr/bin/python3', [path.join(source_dir, 'scripts/validate_vda5050.py'), file], { encoding: 'utf8' });
  assert.equal(check.status, 0, (check.stdout + check.stderr).slice(0, 4_000));

  await t.test('header ids count up by one per topic', () => {
    const last = new Map();
    let checked = 0;
    for (const { topic, payload } of messages) {
      if (!payload || topic.includes('/AIV1/') || topic.endsWith('/connection') || topic.endsWith('/factsheet')) continue; // AIV1 was killed and counts anew
      const { headerId } = JSON.parse(payload);
      if (last.has(topic)) {
        assert.equal(headerId, last.get(topic) + 1, topic);
        checked++;
      }
      last.set(topic, headerId);
    }
    assert.ok(checked > 100);
  });

  await t.test('order, instantActions and state are never retained', async () => {
    const late = await Bus.open(t, await platform.broker_port(), ['uagv/#']);
    const retained = new Set();
    late.on_message((topic, _payload, packet) => packet.retain && retained.add(topic.split('/').pop()));
    await sleep(1_000);
    for (const kind of retained) assert.ok(['connection', 'factsheet'].includes(kind), `${kind} is retained`);
  });
});
