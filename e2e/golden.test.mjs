// The platform's output, served documents and published messages equal the recorded goldens: digests of runs in
// virtual time and of the soaks, every --help, the OpenAPI document, one message of every topic. Nothing depends on
// the speed of the machine. scripts/golden records anew.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { Goldens, first_difference, spread_json } from './lib/golden.mjs';
import { cosiva, cosiva_binary, eventually, fetched, free_port, Program, source_dir, work_folder } from './lib/platform.mjs';

// With COSIVA_LONG the soaks would take more seeds, whatever their arguments are.
delete process.env.COSIVA_LONG;

const at_once = 2;
const timeout_ms = 900_000; // minutes only on a machine that is busy with builds

/**
 * A program of the same build as `cosiva`. Paths are relative to the sources, so that no output contains this machine's
 * folders.
 */
async function run(name, args) {
  const binary = path.join(path.dirname(cosiva_binary()), name);
  assert.ok(existsSync(binary), `${binary} is not built`);
  return cosiva(args, { binary, cwd: source_dir, timeout_ms });
}

/** Calls `work` for each item, a few at a time; returns the results in the items' order. */
async function in_turn(items, work) {
  const answers = new Array(items.length);
  let next = 0;
  const worker = async () => {
    while (next < items.length) {
      const i = next++;
      answers[i] = await work(items[i]);
    }
  };
  await Promise.all(Array.from({ length: at_once }, worker));
  return answers;
}

// ---- Runs in virtual time ---------------------------------------------------------------------------------------------

const scenario = ['--scenario', 'e2e/golden/scenario.toml'];
const kinds_of_run = [
  scenario,
  [...scenario, '--loss', '0.05'],
  [...scenario, '--v2x', 'off', '--convoys', 'off'],
  [...scenario, '--aivs', '7', '--rules', 'fuzzy', '--loss', '0.02'],
  ['--zone', 'zones/indus8.toml', '--aivs', '6', '--duration', '30', '--loss', '0.1'],
];

const virtual_run = (seed) => ['up', '--virtual-time', '--seed', String(seed), ...kinds_of_run[(seed - 1) % kinds_of_run.length], '--json'];

test('runs in virtual time give the recorded digests', { timeout: timeout_ms }, async () => {
  const seeds = Array.from({ length: 20 }, (_, i) => i + 1);
  const runs = await in_turn(seeds, async (seed) => {
    const args = virtual_run(seed);
    const { code, stdout, stderr } = await run('cosiva', args);
    assert.match(stdout, /"digest"/, `cosiva ${args.join(' ')}: ${stderr.slice(-1000)}`);
    return { line: `${JSON.parse(stdout).digest}  exit ${code}  cosiva ${args.join(' ')}`, stdout };
  });
  const goldens = new Goldens();
  goldens.compare('digests.txt', runs.map(({ line }) => line).join('\n'));
  goldens.compare('summary.json', spread_json(runs[0].stdout.trim()));
  goldens.finish();
  assert.equal(new Set(runs.map(({ line }) => line.slice(0, 16))).size, seeds.length, 'every seed is another run');
});

// ---- Soaks ------------------------------------------------------------------------------------------------------------

const lif = 'src/zone/lif/testdata';
const soaks = [
  { name: 'fleet_soak', args: ['zones/lacet4.toml', '4', '8', '1'] },
  { name: 'deadlock_soak', args: ['zones/indus8.toml', '2', '8', '0.5'] },
  { name: 'switch_soak', args: ['zones/lacet4.toml', 'zones/indus8.toml', '2', '8', '3'] },
  { name: 'zone_tour', args: [`${lif}/10.06-station-with-one-node.lif.json`, 'zones/lacet4.toml'] },
  { name: 'hostile_messages', args: ['zones/lacet4.toml', 'fuzz/corpus/vda5050', '20000'] },
];

for (const { name, args } of soaks) {
  test(`${name} gives the recorded digests`, { timeout: timeout_ms }, async () => {
    const { code, stdout, stderr } = await run(`e2e/${name}`, args);
    assert.match(stdout, /digest [0-9a-f]{16}/, stderr.slice(-1000));
    // Threads end in any order, and their speed depends on the machine.
    const lines = stdout.trim().split('\n').map((line) => line.replace(/ \(\d+ of \d+\)/, '').replace(/, \d+ x real time/, ''));
    const goldens = new Goldens();
    goldens.compare(`soak_${name}.txt`, [`e2e/${name} ${args.join(' ')}: exit ${code}`, ...lines.sort()].join('\n'));
    goldens.finish();
  });
}

// ---- --help -----------------------------------------------------------------------------------------------------------

/** The names that a help text lists as subcommands: indented by two, below their heading. */
const subcommands = (help) => {
  const section = /^(?:SUBCOMMANDS|Subcommands):\s*\n((?:(?: {2}.*)?\n)*)/m.exec(`${help}\n`);
  return section ? [...section[1].matchAll(/^ {2}([a-z][\w-]*)/gm)].map(([, name]) => name) : [];
};

async function help_tree(words, goldens) {
  const { code, stdout, stderr } = await run('cosiva', [...words, '--help']);
  assert.equal(code, 0, `cosiva ${words.join(' ')} --help: ${stderr}`);
  goldens.compare(`${['cosiva', ...words].join('_')}.txt`, stdout);
  await in_turn(subcommands(stdout), (name) => help_tree([...words, name], goldens));
}

test('every --help is as recorded, and every command has one', { timeout: timeout_ms }, async () => {
  const goldens = new Goldens('help');
  await help_tree([], goldens);
  assert.ok(goldens.seen.size > 20, `only ${goldens.seen.size} commands were found`);
  goldens.finish();
});

// ---- OpenAPI ----------------------------------------------------------------------------------------------------------

test('the server serves the recorded OpenAPI document', { timeout: timeout_ms }, async (t) => {
  const port = await free_port();
  const folder = work_folder(t);
  const server = new Program(t, cosiva_binary(), ['up', '--virtual-time', '--page', '--headless', '--zone', path.join(source_dir, 'zones/lacet4.toml'), '--aivs', '1', '--port', String(port)], { cwd: folder });
  const { status, text } = await eventually('the server responds', () => fetched(`http://127.0.0.1:${port}/api`, 5_000), { within_ms: 60_000 });
  await server.stop();
  assert.equal(status, 200);
  const goldens = new Goldens();
  goldens.compare('openapi.json', text);
  goldens.finish();
});

// ---- One message of every topic ---------------------------------------------------------------------------------------

const sources = readdirSync(path.join(source_dir, 'src'), { recursive: true }).sort();

/**
 * Every topic that the sources name: CoSiVA's constants, VDA 5050's schemas. A control area has server topics of its
 * own.
 */
function topics_of_the_sources() {
  const own = sources
    .filter((name) => /\.(h|cpp)$/.test(name) && !/_test\.cpp$/.test(name))
    .flatMap((name) => [...readFileSync(path.join(source_dir, 'src', name), 'utf8').matchAll(/\b\w*topic\w*\s*=\s*"(cosiva\/v1\/[^"]+)"/g)].map(([, topic]) => topic));
  const vda = sources.filter((name) => /\bvda5050\/.*\.schema$/.test(name)).map((name) => `vda5050/${path.basename(name, '.schema')}`);
  const area = own.find((topic) => topic.endsWith('/area/'));
  const of_servers = own.filter((topic) => /^cosiva\/v1\/(zone|server)\//.test(topic));
  assert.ok(own.length > 15 && vda.length === 6 && area && of_servers.length === 3, `topics are missing: ${[...own, ...vda]}`);
  return [...own.filter((topic) => topic !== area), ...vda, ...of_servers.map((topic) => area + topic.slice('cosiva/v1/'.length))];
}

/** The topic of these that a message's topic belongs to; undefined where there is none. */
function topic_of(topics, text) {
  const vda = /^uagv\/v2\/[^/]+\/[^/]+\/(\w+)$/.exec(text);
  const wanted = vda ? `vda5050/${vda[1]}` : text.replace(/\/area\/[^/]+\//, '/area/');
  return topics.find((topic) => (topic.endsWith('/') ? wanted.startsWith(topic) : wanted === topic));
}

const payload_of = (line) => line.slice(line.indexOf('"payload":') + '"payload":'.length, -1);
/** Positions by camera pass through OpenCV, whose last digits are those of the processor's vector instructions: to 1 µm. */
const is_by_camera = (topic) => topic.startsWith('cosiva/v1/gvs/');
const to_micro = (text) => text.replace(/-?\d+\.\d{7,}(?:e-?\d+)?/g, (number) => Number(number).toFixed(6));
const sha256 = (text) => createHash('sha256').update(text, 'latin1').digest('hex');
const payload_max = 20_000;

/**
 * A trace's line with a line for each member; of an image its beginning and the digest of the whole. Lines are read
 * byte by byte.
 */
function sample_of(line) {
  const payload = payload_of(line);
  if (payload.length <= payload_max) return spread_json(Buffer.from(line, 'latin1').toString('utf8'));
  return `${spread_json(line.replace(payload, () => 'null'))}\n${payload.length} bytes, sha256 ${sha256(payload)}, beginning:\n${payload.slice(0, 1000).replace(/[^\x20-\x7e]/g, '.')}`;
}

/** The messages of a run by topic: their number, a digest of all, and the longest one. */
class Messages {
  constructor(topics) {
    this.topics = topics;
    this.found = new Map();
  }

  read(file) {
    for (const written of readFileSync(file, 'latin1').split('\n')) {
      if (written === '') continue;
      const text = /"topic":"([^"]*)"/.exec(written)[1];
      const topic = topic_of(this.topics, text);
      assert.ok(topic, `a message on ${text}, which no topic of the sources is`);
      const line = is_by_camera(topic) ? to_micro(written) : written;
      if (!this.found.has(topic)) this.found.set(topic, { count: 0, hash: createHash('sha256'), line });
      const known = this.found.get(topic);
      known.count++;
      known.hash.update(`${line}\n`, 'latin1');
      if (payload_of(line).length > payload_of(known.line).length) known.line = line;
    }
  }
}

test('a message of every topic is as recorded', { timeout: timeout_ms }, async (t) => {
  const topics = topics_of_the_sources();
  const folder = work_folder(t);
  const traces = ['run.jsonl', 'parts.jsonl'].map((name) => path.join(folder, name));
  await run('cosiva', [...virtual_run(1), '--trace-messages', traces[0]]);
  const parts = await run('e2e/message_samples', ['zones/lacet4.toml', traces[1]]);
  assert.equal(parts.code, 0, parts.stderr);
  const messages = new Messages(topics);
  for (const trace of traces) messages.read(trace);

  const goldens = new Goldens('mqtt');
  const counts = [];
  for (const topic of topics.sort()) {
    const found = messages.found.get(topic);
    assert.ok(found, `no message on ${topic}: message_samples.cpp, or the scenario, must make one`);
    goldens.compare(`${topic.replace(/\/$/, '').replaceAll('/', '.')}.json`, sample_of(found.line));
    counts.push(`${found.hash.digest('hex')} ${String(found.count).padStart(6)} ${topic}`);
  }
  goldens.compare('all_messages.txt', counts.join('\n'));
  goldens.finish();
});

// ---- The comparison itself --------------------------------------------------------------------------------------------

test('positions by camera are compared to a micrometre', () => {
  assert.equal(to_micro('{"x":1.2840702690261527,"y":-1.0235205387384876}'), to_micro('{"x":1.2840702690256918,"y":-1.0235205387380575}'));
  assert.notEqual(to_micro('{"x":1.2840702690261527}'), to_micro('{"x":1.2840722690261527}'));
  assert.equal(to_micro('"at":"2023-07-11T00:00:00.702Z","u":3.833619869833508e-4'), '"at":"2023-07-11T00:00:00.702Z","u":0.000383');
});

test('a golden that differs in one line is reported with its number', () => {
  assert.equal(first_difference('a\nb\nc\n', 'a\nb\nc\n'), '');
  assert.match(first_difference('a\nb\nc\n', 'a\nx\nc\n'), /2 - b\n.*2 \+ x/);
  assert.match(first_difference('a\nc\n', 'a\nb\nc\n'), /^ +2 \+ b$/);
  assert.equal(spread_json('{"a":[1.0,2e-7],"b":{"c":"x,{y}"}}'), '{\n  "a": [1.0,2e-7],\n  "b": {\n    "c": "x,{y}"\n  }\n}');
});
