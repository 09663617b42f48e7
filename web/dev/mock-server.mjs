#!/usr/bin/env node
// Speaks docs/protocols/hmi-api.md with made-up vehicles, so that the page can be worked on without the platform.
//   node dev/mock-server.mjs [--port 8080] [--aivs 4] [--zone lacet4|yard] [--clock wall|virtual] [--dist DIR]
// Serves dist/ too. Not shipped. Faults on demand: POST /mock {"lose":3} {"find":3} {"drift":2} {"zone":null}
// {"freeze":true} {"board":[2,"DOBS"]} {"refuse":true}
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { WebSocketServer } from 'ws';
import { MockBatteries } from './mock/battery.mjs';
import { PositionFrames } from './mock/frames.mjs';
import { Refusal, World } from './mock/world.mjs';

const option = (name, fallback) => {
  const at = process.argv.indexOf(`--${name}`);
  return at > 0 ? process.argv[at + 1] : fallback;
};
const port = Number(option('port', 8080));
const aivs = Number(option('aivs', 4));
const dist = path.resolve(option('dist', path.join(path.dirname(fileURLToPath(import.meta.url)), '../dist')));

const world = new World({ aivs, zone: option('zone', ''), clock: option('clock', 'wall'), scenario: option('scenario', null) });
const batteries = new MockBatteries(world);
const frames = new PositionFrames();
let no_zone = false;
let frozen = false;
let refusing = false;

const zone_text = () => JSON.stringify({ type: 'zone', zone: no_zone ? null : world.zone });
const run_text = () => JSON.stringify({ type: 'run', run: world.run() });
const snapshot_now = () => ({ ...world.snapshot(), battery: batteries.snapshot() });
const snapshot_text = () => JSON.stringify({ type: 'snapshot', snapshot: snapshot_now() });

const zones = () => ['lacet4', 'yard'].map((name) => ({ name, title: name === 'lacet4' ? 'The clover with four crossings' : 'A yard of many loops', current: world.circuit.name === name }));
const number = (url, name, fallback) => Number(url.searchParams.get(name) ?? fallback);

/** [method, path, status, what to do with (id, body, url)] */
const routes = [
  ['GET', /^\/zone$/, 200, () => (no_zone ? null : world.zone)],
  ['GET', /^\/snapshot$/, 200, () => snapshot_now()],
  ['GET', /^\/bijection$/, 200, () => world.bijection()],
  ['GET', /^\/run$/, 200, () => world.run()],
  ['GET', /^\/zones$/, 200, () => ({ zones: zones() })],
  ['GET', /^\/traces$/, 200, (_, __, url) => world.traces.list(number(url, 'after', 0), Math.min(1000, number(url, 'limit', 200)))],
  ['GET', /^\/traces\/(\d+)$/, 200, (n) => world.traces.one(Number(n)) ?? refuse(404, 'traces.none', `There is no trace ${n} (any more).`)],
  ['GET', /^\/battery\/curves\/(.+)$/, 200, (id) => ({ vehicle: id, points: batteries.curve(id) ?? refuse(404, 'battery.not_found', `${id} has not reported its battery.`) })],
  ['POST', /^\/battery\/ready$/, 202, (_, body) => {
    const why = batteries.ready(body);
    return why ? refuse(...why) : {};
  }],
  ['POST', /^\/commands$/, 202, (_, body) => world.command(body)],
  ['POST', /^\/virtual-objects$/, 201, (_, body) => world.add_virtual_object(body)],
  ['PATCH', /^\/virtual-objects\/(.+)$/, 200, (id, body) => world.move_virtual_object(id, body)],
  ['DELETE', /^\/virtual-objects\/(.+)$/, 200, (id) => world.remove_virtual_object(id)],
  ['DELETE', /^\/virtual-objects$/, 200, () => world.remove_all()],
  ['PUT', /^\/priorities$/, 200, (_, body) => world.priorities(body)],
  ['POST', /^\/zone\/switch$/, 200, (_, body) => world.switch_zone(body), zone_text],
  ['GET', /^\/zone\/beacons\/suggestion$/, 200, () => world.suggest_beacons()],
  ['POST', /^\/zone\/edit$/, 200, (_, body) => world.edit_zone(body), zone_text],
  ['POST', /^\/zone\/undo$/, 200, () => world.undo(), zone_text],
  ['POST', /^\/zone\/redo$/, 200, () => world.redo(), zone_text],
  ['POST', /^\/zone\/save$/, 200, () => ((world.saved = true), { file: '~/.local/share/cosiva/zones/lacet4.toml' })],
  ['POST', /^\/plant\/obstacles$/, 201, (_, body) => world.add_box(body)],
  ['DELETE', /^\/plant\/obstacles\/(.+)$/, 200, (id) => world.remove_box(id)],
  ['PUT', /^\/clock$/, 200, (_, body) => world.set_clock(body), run_text],
  ['POST', /^\/clock\/step$/, 200, (_, body) => world.step_clock(body), run_text],
];
function refuse(status, code, message) {
  throw new Refusal(status, code, message);
}

function api(method, url, text) {
  const api_path = url.pathname.slice('/api/v1'.length);
  const fitting = routes.filter(([, pattern]) => pattern.test(api_path));
  const route = fitting.find(([wanted]) => wanted === method);
  if (!route) throw fitting.length > 0 ? new Refusal(405, 'http.method', `${api_path} does not take ${method}.`) : new Refusal(404, 'http.path', `There is nothing at ${url.pathname}.`);
  if (refusing && method !== 'GET') throw new Refusal(409, 'mock.refuses', 'The mock refuses everything just now, as configured.');
  let body;
  try {
    body = text === '' ? {} : JSON.parse(text);
  } catch {
    throw new Refusal(400, 'http.json', 'The body is not JSON.');
  }
  const [, pattern, status, act, event] = route;
  const id = pattern.exec(api_path)[1];
  const value = act(id === undefined ? undefined : decodeURIComponent(id), body, url);
  if (method !== 'GET') {
    if (event) broadcast(event());
    positions(true);
    broadcast(snapshot_text());
  }
  return [status, value];
}

function fault(body) {
  const one = (n) => world.aivs.find((aiv) => aiv.number === n);
  if (body.lose) one(body.lose).lost_at = world.now;
  if (body.find) one(body.find).lost_at = null;
  if (body.drift) one(body.drift).drift = 0.06;
  if (body.board) one(body.board[0]).board_down = body.board[1];
  if ('freeze' in body) frozen = body.freeze;
  if ('refuse' in body) refusing = body.refuse;
  if ('zone' in body) {
    no_zone = body.zone === null;
    broadcast(zone_text());
  }
  return [200, {}];
}

const types = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };
function file(url, response) {
  const wanted = path.join(dist, path.normalize(url.pathname === '/' ? '/index.html' : url.pathname));
  if (!wanted.startsWith(dist) || !existsSync(wanted)) return response.writeHead(404).end('nothing here; npm run build makes dist/');
  response.writeHead(200, { 'content-type': types[path.extname(wanted)] ?? 'application/octet-stream' });
  return createReadStream(wanted).pipe(response);
}
const server = createServer((request, response) => {
  const url = new URL(request.url, 'http://mock');
  if (request.method === 'GET' && url.pathname === '/api/v1/zone/file') {
    return response.writeHead(200, { 'content-type': 'text/plain; charset=utf-8', 'content-disposition': `attachment; filename="${world.circuit.name}.toml"` }).end(`name = "${world.circuit.name}"\n`);
  }
  if (!url.pathname.startsWith('/api/') && url.pathname !== '/mock') return file(url, response);
  let text = '';
  request.on('data', (chunk) => (text += chunk));
  request.on('end', () => {
    let status;
    let value;
    try {
      [status, value] = url.pathname === '/mock' ? fault(JSON.parse(text)) : api(request.method, url, text);
    } catch (problem) {
      if (!(problem instanceof Refusal)) console.error(problem);
      [status, value] = [problem.status ?? 500, { error: { code: problem.code ?? 'mock.bug', message: problem.message } }];
    }
    response.writeHead(status, { 'content-type': 'application/json' }).end(JSON.stringify(value));
  });
});

const sockets = new WebSocketServer({ server, path: '/api/v1/live' });
sockets.on('connection', (socket) => {
  socket.send(zone_text());
  socket.send(run_text());
  socket.send(snapshot_text());
  socket.send(frames.last_key(world.now));
});
/** A reader that is behind gets nothing new until it has caught up: the newest will do. */
function broadcast(data) {
  for (const socket of sockets.clients) if (socket.readyState === 1 && socket.bufferedAmount < 4_000_000) socket.send(data);
}

let since_key = 0;
function positions(as_key = false) {
  const records = world.positions();
  const key = as_key || since_key >= (records.length > 1000 ? 9 : 29);
  const { is_key, bytes } = frames.encode(world.now, records, key);
  since_key = is_key ? 0 : since_key + 1;
  broadcast(bytes);
}

let last = Date.now();
let ticks = 0;
setInterval(() => {
  const now = Date.now();
  if (!frozen) {
    ticks++;
    // Thousands move and are reported ten times a second, as the contract requires.
    const due = world.aivs.length <= 1000 || ticks % 3 === 0;
    if (due) {
      world.advance(now - last);
      last = now;
      positions();
    }
    if (ticks % 3 === 1) broadcast(JSON.stringify(world.ground_truth()));
    // The made-up platform is slower than the real one: above 2 000 its table comes once a second.
    if (ticks % (world.aivs.length > 2000 ? 30 : 8) === 2) broadcast(snapshot_text());
    if (ticks % 30 === 0) broadcast(run_text());
  } else last = now;
}, 33);
server.listen(port, '127.0.0.1', () => console.log(`mock platform on http://127.0.0.1:${port}`));
