#!/usr/bin/env node
// Speaks docs/protocols/hmi-api.md with made-up vehicles, so that the page can be worked on without the platform.
//   node dev/mock-server.mjs [--port 8080] [--aivs 4]
// Not shipped. Faults on demand: POST /mock {"lose":3} {"find":3} {"drift":2} {"zone":null} {"freeze":true}
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { WebSocketServer } from 'ws';

const option = (name, fallback) => {
  const at = process.argv.indexOf(`--${name}`);
  return at > 0 ? Number(process.argv[at + 1]) : fallback;
};
const port = option('port', 8080);
const count = option('aivs', 4);
const dist = path.join(path.dirname(fileURLToPath(import.meta.url)), '../dist');

// The clover of A11: four straights and four right-hand loops of 270°.
const a = 0.75;
const d = 0.15;
const r = a - d;
const names = ['east', 'loop_se', 'north', 'loop_ne', 'west', 'loop_nw', 'south', 'loop_sw'];
const starts = [[-a, -d, 0], [a, -d, 0], [d, -a, Math.PI / 2], [d, a, Math.PI / 2], [a, d, Math.PI], [-a, d, Math.PI], [-d, a, -Math.PI / 2], [-d, -a, -Math.PI / 2]];
const sections = names.map((name, i) => ({ name, start: starts[i], length: i % 2 ? 1.5 * Math.PI * r : 2 * a, curvature: i % 2 ? -1 / r : 0 }));
const lap = sections.reduce((sum, section) => sum + section.length, 0);

function pose_at(distance) {
  let s = ((distance % lap) + lap) % lap;
  const section = sections.find((candidate) => s <= candidate.length || ((s -= candidate.length), false)) ?? sections[0];
  const [x, y, h] = section.start;
  const k = section.curvature;
  if (k === 0) return { x: x + s * Math.cos(h), y: y + s * Math.sin(h), heading: h, section: section.name, s };
  return { x: x + (Math.sin(h + k * s) - Math.sin(h)) / k, y: y - (Math.cos(h + k * s) - Math.cos(h)) / k, heading: h + k * s, section: section.name, s };
}

function zone() {
  const primitives = [];
  for (const section of sections) {
    const from = lap_start(section.name);
    const points = Array.from({ length: 41 }, (_, i) => pose_at(from + (section.length * i) / 40 - (i === 40 ? 1e-9 : 0))).map((p) => [p.x, p.y]);
    primitives.push({ shape: 'polyline', layer: 'road', points, size_m: 0.2, label: section.name });
    primitives.push({ shape: 'polyline', layer: 'line', points, size_m: 0.012, label: section.name });
    const middle = pose_at(from + section.length / 2);
    primitives.push({ shape: 'text', layer: 'label', points: [[middle.x + 0.14 * Math.sin(middle.heading), middle.y - 0.14 * Math.cos(middle.heading)]], size_m: 0.06, label: section.name, heading: 0 });
  }
  [[d, -d], [d, d], [-d, d], [-d, -d]].forEach(([x, y], i) =>
    primitives.push({ shape: 'disc', layer: 'crossing', points: [[x, y]], size_m: 0.13, label: `X${i + 1}` }));
  for (let i = 0; i < 12; i++) {
    const p = pose_at(((i + 0.5) * lap) / 12);
    primitives.push({ shape: 'disc', layer: 'tag', points: [[p.x, p.y]], size_m: 0.02, label: `tag ${i + 1}` });
  }
  for (let i = -5; i <= 5; i++) for (let j = -5; j <= 5; j++)
    primitives.push({ shape: 'disc', layer: 'beacon', points: [[i * 0.27, j * 0.27]], size_m: 0.008, label: '' });
  return { name: 'lacet4', bounds: [-1.45, -1.45, 1.45, 1.45], vehicle: { length_m: 0.2, width_m: 0.12 }, primitives };
}
function lap_start(name) {
  let sum = 0;
  for (const section of sections) {
    if (section.name === name) return sum;
    sum += section.length;
  }
  return 0;
}

const profiles = { normal: 0.35, slow: 0.12, medium: 0.25, fast: 0.45 };
const aivs = Array.from({ length: count }, (_, i) => ({ number: i + 1, distance: (i * lap) / count + 0.3, speed: 0.3, imposed: null, paused: false, lost_at: null, drift: 0.002, battery: 91 - 3.7 * i }));
const commands = [];
let command_number = 0;
let zone_served = zone();
let frozen = false;

function step(dt, now) {
  for (const aiv of aivs) {
    const gaps = aivs.filter((other) => other !== aiv).map((other) => (((other.distance - aiv.distance) % lap) + lap) % lap);
    let wish = aiv.paused || aiv.lost_at ? 0 : profiles[aiv.imposed ?? 'normal'];
    if (Math.min(...gaps, lap) < 0.32) wish = 0;
    aiv.speed += Math.max(-0.8 * dt, Math.min(0.4 * dt, wish - aiv.speed));
    aiv.distance += aiv.speed * dt;
    aiv.battery = Math.max(0, aiv.battery - 0.002 * dt);
  }
  for (const command of commands) {
    if (command.state === 'issued' && now - command.time_ms > 34) Object.assign(command, { state: 'accepted', accepted_ms: now - command.time_ms });
    const aiv = aivs.find((candidate) => id(candidate) === command.vehicle);
    if (command.state === 'accepted' && aiv) {
      const seen = command.command === 'stop' ? aiv.speed < 0.01 : aiv.speed > 0.05;
      if (seen) Object.assign(command, { state: 'materialised', materialised_ms: now - command.time_ms });
      else if (now - command.time_ms > 5000) Object.assign(command, { state: 'failed', reason: 'not seen within 5 s' });
    }
  }
}

const id = (aiv) => `CoSiVA/AIV${aiv.number}`;
const statistics = (p50, p99, n) => ({ count: n, mean: p50 * 1.05, p50, p99, max: p99 * 1.2 });

function bijection() {
  const lost = aivs.filter((aiv) => aiv.lost_at).length;
  const drift = Math.max(...aivs.map((aiv) => aiv.drift));
  const done = commands.filter((command) => command.state === 'materialised');
  return {
    physical: count, virtual: count, matched: count, matched_share: 1, orphans: [],
    divergence_m: statistics(drift * 0.7, Math.max(0.0112, drift), 48_000), divergence_rad: statistics(0.004, 0.02, 48_000),
    age_ms: statistics(54, lost ? 1800 : 108, 48_000),
    commands: { issued: commands.length, accepted: commands.filter((c) => c.accepted_ms !== null).length, materialised: done.length, failed: commands.filter((c) => c.state === 'failed').length, latency_ms: statistics(done.length ? 480 : 0, done.length ? 910 : 0, done.length) },
    events: { count: 412, latency_ms: statistics(48, 131, 412), by_kind: { arrival: 4, tag: 380, obstacle: 9, stop: 19, battery: 0 } }, held_share: lost ? 0.981 : 0.9994,
  };
}

function snapshot(now) {
  return {
    time: new Date(now).toISOString(), time_ms: now, zoneRevision: 1,
    aivs: aivs.map((aiv) => {
      const p = pose_at(aiv.distance);
      const age = aiv.lost_at ? now - aiv.lost_at : 20 + ((now + 31 * aiv.number) % 100);
      const standing = aiv.speed < 0.01;
      return {
        id: id(aiv), number: aiv.number, connection: aiv.lost_at && age > 1500 ? 'CONNECTIONBROKEN' : 'ONLINE', lost: aiv.lost_at !== null && age > 1000,
        status: standing ? 'stopped' : aiv.imposed ? `${aiv.imposed} speed` : 'Normal', x: p.x, y: p.y, heading: Math.atan2(Math.sin(p.heading), Math.cos(p.heading)), speed: aiv.speed,
        section: p.section, s: p.s, reported: { x: p.x - aiv.drift, y: p.y + aiv.drift, heading: p.heading }, age_ms: age, divergence_m: aiv.drift * (0.6 + 0.4 * Math.sin(now / 700 + aiv.number)),
        battery: aiv.battery, lastTag: 1 + (Math.floor((aiv.distance / lap) * 12 + 0.5) % 12), sinceTag_m: aiv.distance % 1.44, lastNode: `${p.section}@${Math.floor(p.s * 3.3) * 300}`,
        orderId: `lacet4-${aiv.number}`, orderUpdateId: Math.floor(aiv.distance / 0.3), driving: !standing, paused: aiv.paused, fieldViolation: false,
        waitsFor: standing && !aiv.paused && !aiv.lost_at ? 'X2' : null, errors: [], contract: { matched: true, divergence: aiv.drift < 0.03, age: !aiv.lost_at },
      };
    }),
    crossings: [[d, -d], [d, d], [-d, d], [-d, -d]].map(([x, y], i) => {
      const near = aivs.map((aiv) => ({ aiv, p: pose_at(aiv.distance) })).filter(({ p }) => Math.hypot(p.x - x, p.y - y) < 0.3);
      return { name: `X${i + 1}`, heldBy: near[0] ? id(near[0].aiv) : null, waiting: near.slice(1).map(({ aiv }) => id(aiv)) };
    }),
    bijection: bijection(), commands: commands.slice(-50),
  };
}

function give(body, now) {
  const vehicles = body.vehicle === '*' ? aivs : aivs.filter((aiv) => id(aiv) === body.vehicle);
  if (vehicles.length === 0) return [400, { error: { code: 'command.vehicle', message: `no vehicle ${body.vehicle}` } }];
  if (!['stop', 'slow', 'medium', 'fast', 'restart', 'cancel'].includes(body.command)) return [400, { error: { code: 'command.unknown', message: `no command ${body.command}` } }];
  for (const aiv of vehicles) {
    const command = { id: `c${++command_number}`, vehicle: id(aiv), command: body.command, state: 'issued', time_ms: now, accepted_ms: null, materialised_ms: null, reason: '' };
    commands.push(command);
    if (aiv.lost_at) Object.assign(command, { state: 'failed', reason: 'offline' });
    else if (body.command === 'stop') aiv.paused = true;
    else if (body.command === 'restart') Object.assign(aiv, { paused: false, imposed: null });
    else if (body.command !== 'cancel') aiv.imposed = body.command;
  }
  return [202, { id: `c${command_number}` }];
}

function fault(body) {
  const one = (number) => aivs.find((aiv) => aiv.number === number);
  if (body.lose) one(body.lose).lost_at = Date.now();
  if (body.find) one(body.find).lost_at = null;
  if (body.drift) one(body.drift).drift = 0.06;
  if ('freeze' in body) frozen = body.freeze;
  if ('zone' in body) {
    zone_served = body.zone === null ? null : zone();
    broadcast(JSON.stringify({ type: 'zone', zone: zone_served }));
  }
  return [200, {}];
}

const types = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };
const server = createServer((request, response) => {
  const answer = (code, value) => response.writeHead(code, { 'content-type': 'application/json' }).end(JSON.stringify(value));
  const url = new URL(request.url, 'http://mock');
  if (request.method === 'POST') {
    let text = '';
    request.on('data', (chunk) => (text += chunk));
    request.on('end', () => answer(...(url.pathname === '/mock' ? fault(JSON.parse(text)) : give(JSON.parse(text), Date.now()))));
    return;
  }
  if (url.pathname === '/api/v1/zone') return answer(200, zone_served);
  if (url.pathname === '/api/v1/snapshot') return answer(200, snapshot(Date.now()));
  if (url.pathname === '/api/v1/bijection') return answer(200, bijection());
  if (url.pathname === '/api/v1/traces') return answer(200, { next: 0, traces: [] });
  const file = path.join(dist, path.normalize(url.pathname === '/' ? '/index.html' : url.pathname));
  if (!file.startsWith(dist) || !existsSync(file)) return answer(404, { error: { code: 'http.path', message: url.pathname } });
  response.writeHead(200, { 'content-type': types[path.extname(file)] ?? 'application/octet-stream' });
  createReadStream(file).pipe(response);
});
const sockets = new WebSocketServer({ server, path: '/api/v1/live' });
sockets.on('connection', (socket) => socket.send(JSON.stringify({ type: 'zone', zone: zone_served })));
const broadcast = (text) => sockets.clients.forEach((socket) => socket.readyState === 1 && socket.send(text));

let last = Date.now();
setInterval(() => {
  const now = Date.now();
  if (!frozen) {
    step((now - last) / 1000, now);
    broadcast(JSON.stringify({ type: 'snapshot', snapshot: snapshot(now) }));
  }
  last = now;
}, 50);
server.listen(port, '127.0.0.1', () => console.log(`mock platform on http://127.0.0.1:${port}`));
