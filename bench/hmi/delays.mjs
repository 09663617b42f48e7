#!/usr/bin/env node
// Measures delays on a running platform, over --events of each kind:
//   command   POST /commands → the vehicle's instantActions message on the bus, and → the vehicle's own acknowledgement
//   brake     POST /virtual-objects, a person before a driving AIV → `decided` in the vehicle's acknowledgement, braking for it
//   screen    a vehicle's own time of an event (a node passed, driving or not, an obstacle detected) → the live frame that shows
//             it, in a WebSocket client, and, for a part of the events, in a browser's next animation frame
//
//     node bench/hmi/delays.mjs [--what command,brake,screen] [--events 1000] [--aivs 4] [--json FILE]
//                               [--url http://127.0.0.1:8080 --broker-port 1883]   (without: starts a platform of its own)
// All clocks are this machine's. Times that travel in messages have whole milliseconds.
import { open_browser } from '../../e2e/lib/browser.mjs';
import { Bus } from '../../e2e/lib/bus.mjs';
import { Platform, eventually, sleep } from '../../e2e/lib/platform.mjs';
import { Reader, now_ms } from './live_client.mjs';
import { arguments_over, figures, report, table, with_cleanup } from './lib.mjs';

const options = arguments_over({
  what: 'command,brake,screen',
  events: 1000,
  aivs: 4,
  url: '',
  broker_port: 0,
  ahead: 0.35,
  browser_share: 0.2,
  json: '',
});
const goals = { 'command on the bus': 20, 'brake decided': 50, 'event on screen': 100 };

async function ask(url, method, path, body) {
  const response = await fetch(`${url}/api/v1/${path}`, {
    method,
    ...(body === undefined ? {} : { headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) }),
  });
  const answer = await response.json();
  if (!response.ok) throw new Error(answer.error?.message ?? String(response.status));
  return answer;
}

/** Waits for the message that `listen` reports; null when it does not come in time. */
function heard(within_ms, listen) {
  return new Promise((resolve) => {
    const timer = setTimeout(() => resolve(null), within_ms);
    listen((value) => {
      clearTimeout(timer);
      resolve(value);
    });
  });
}

/** The page's view of the fleet, updated by the live stream, with the watchers that wait for a change. */
class View extends Reader {
  watchers = new Set();
  take(data, binary) {
    super.take(data, binary);
    if (binary) return;
    const message = JSON.parse(data.toString());
    if (message.type !== 'snapshot') return;
    this.snapshot = message.snapshot;
    this.shown_ms = now_ms();
    for (const watcher of this.watchers) watcher(this.snapshot, this.shown_ms);
  }
  aiv(id) {
    return this.snapshot?.aivs.find((aiv) => aiv.id === id);
  }
}

/** Messages of the vehicles, by topic's last level. */
class Fleet {
  listeners = new Set();
  static async open(t, port) {
    const fleet = new Fleet();
    fleet.bus = await Bus.open(t, port, ['uagv/v2/+/+/instantActions', 'uagv/v2/+/+/state', 'cosiva/v1/virtual_obstacles_ack/+/+', 'cosiva/v1/detected_obstacle/+/+']);
    fleet.bus.on_message((topic, payload) => {
      const at_ms = now_ms();
      const levels = topic.split('/');
      const own = levels[0] === 'cosiva';
      const kind = own ? levels[2] : levels[4];
      const vehicle = own ? `${levels[3]}/${levels[4]}` : `${levels[2]}/${levels[3]}`;
      let message;
      try {
        message = JSON.parse(payload.toString());
      } catch {
        return;
      }
      for (const listener of fleet.listeners) listener(kind, vehicle, message, at_ms);
    });
    return fleet;
  }
  /** The result of `pick` for the first message for which it has one. */
  next(within_ms, pick) {
    let listener;
    return heard(within_ms, (done) => {
      listener = (...message) => {
        const value = pick(...message);
        if (value !== undefined) done(value);
      };
      this.listeners.add(listener);
    }).finally(() => this.listeners.delete(listener));
  }
}

let progress_ms = 0;
/** One line every few seconds, for the person who waits. */
function progress(text) {
  if (now_ms() < progress_ms) return;
  progress_ms = now_ms() + 10_000;
  console.error(text);
}

const physical = (view) => view.snapshot.aivs.filter((aiv) => !aiv.augmented && aiv.connection === 'ONLINE' && !aiv.lost);

async function measure_commands(url, view, fleet) {
  const bus = [];
  const acknowledged = [];
  let missed = 0;
  const vehicles = physical(view).map((aiv) => aiv.id);
  const verbs = ['slow', 'medium', 'fast'];
  for (let i = 0; i < options.events; ++i) {
    const vehicle = vehicles[i % vehicles.length];
    progress(`command: ${i} of ${options.events}`);
    // Repeating a command changes nothing; the next one for this vehicle is another.
    const command = verbs[Math.floor(i / vehicles.length) % verbs.length];
    let action;
    const on_bus = fleet.next(2_000, (kind, whom, message, at_ms) => {
      if (kind !== 'instantActions' || whom !== vehicle) return undefined;
      const found = message.actions.find(({ actionType, actionParameters }) => actionType === 'setSpeedLimit' && actionParameters?.some(({ value }) => value === command));
      if (!found) return undefined;
      action = found.actionId;
      return at_ms;
    });
    const in_state = fleet.next(3_000, (kind, whom, message, at_ms) =>
      kind === 'state' && whom === vehicle && action && message.actionStates.some(({ actionId }) => actionId === action) ? at_ms : undefined,
    );
    const start = now_ms();
    await ask(url, 'POST', 'commands', { command, vehicle });
    const [sent_ms, state_ms] = await Promise.all([on_bus, in_state]);
    if (sent_ms === null || state_ms === null) ++missed;
    if (sent_ms !== null) bus.push(sent_ms - start);
    if (state_ms !== null) acknowledged.push(state_ms - start);
    await sleep(20);
  }
  await ask(url, 'POST', 'commands', { command: 'restart', vehicle: '*' });
  return { 'command on the bus': bus, 'command acknowledged': acknowledged, missed };
}

/** The point this far ahead on the released path of the vehicle; null where that path is shorter. */
function point_ahead(aiv, distance_m) {
  const way = [[aiv.x, aiv.y], ...aiv.reserved.slice(1)];
  for (let i = 1, done_m = 0; i < way.length; ++i) {
    const leg_m = Math.hypot(way[i][0] - way[i - 1][0], way[i][1] - way[i - 1][1]);
    if (leg_m > 0 && done_m + leg_m >= distance_m) {
      const share = (distance_m - done_m) / leg_m;
      return { x: way[i - 1][0] + share * (way[i][0] - way[i - 1][0]), y: way[i - 1][1] + share * (way[i][1] - way[i - 1][1]) };
    }
    done_m += leg_m;
  }
  return null;
}

const drives = (aiv) => aiv && aiv.driving && !aiv.paused && !aiv.brakingFor && aiv.speed > 0.1 && aiv.contract.matched;

async function measure_brakes(url, view, fleet) {
  const decided = [];
  const answered = [];
  let missed = 0;
  const busy = new Set();
  /** One person before one vehicle, removed again when the vehicle has braked. */
  const once = async (id) => {
    const aiv = view.aiv(id);
    const place = drives(aiv) && view.shown_ms > now_ms() - 150 ? point_ahead(aiv, options.ahead) : null;
    if (!place) return false;
    let person;
    const acknowledged = fleet.next(2_000, (kind, whom, message, at_ms) =>
      kind === 'virtual_obstacles_ack' && whom === id && message.braking && (person === undefined || message.body === person)
        ? { body: message.body, decided_ms: Date.parse(message.decided), at_ms }
        : undefined,
    );
    progress(`brake: ${decided.length} of ${options.events}`);
    const start = now_ms();
    person = (await ask(url, 'POST', 'virtual-objects', { kind: 'person', ...place })).id;
    const answer = await acknowledged;
    if (answer && answer.body === person) {
      decided.push(answer.decided_ms - start);
      answered.push(answer.at_ms - start);
    } else {
      ++missed; // another body was nearer, or the vehicle had turned away
    }
    await ask(url, 'DELETE', `virtual-objects/${encodeURIComponent(person)}`);
    return true;
  };
  const give_up = Date.now() + options.events * 6_000 + 30_000;
  const worker = async (id) => {
    while (decided.length < options.events && Date.now() < give_up) {
      if (await once(id)) await eventually(`${id} drives on`, () => drives(view.aiv(id)), { within_ms: 20_000, every_ms: 20 }).catch(() => {});
      else await sleep(20);
    }
    busy.delete(id);
  };
  // One vehicle at a time would take hours; each waits for its own acknowledgement only.
  await Promise.all(physical(view).map((aiv) => (busy.add(aiv.id), worker(aiv.id))));
  return { 'brake decided': decided.slice(0, options.events), 'brake acknowledged': answered.slice(0, options.events), missed };
}

/** Records in the page itself when a snapshot with an event came, and when the next frame was drawn. */
function watch_in_browser(page) {
  return page.evaluate(() => {
    window.shown = [];
    const known = new Map();
    const socket = new WebSocket(`ws://${location.host}/api/v1/live`);
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({ data }) => {
      if (typeof data !== 'string') return;
      const message = JSON.parse(data);
      if (message.type !== 'snapshot') return;
      const news = message.snapshot.aivs.filter((aiv) => known.get(aiv.id) !== aiv.lastNode).map((aiv) => ({ id: aiv.id, node: aiv.lastNode }));
      for (const { id, node } of news) known.set(id, node);
      if (news.length > 0) requestAnimationFrame(() => window.shown.push(...news.map((one) => ({ ...one, at_ms: performance.timeOrigin + performance.now() }))));
    };
  });
}

async function measure_screen(t, url, view, fleet) {
  const kinds = { 'node passed': [], 'started or stopped': [], 'obstacle detected': [] };
  const waiting = []; // {kind, shows(snapshot), since_ms}
  const nodes = []; // for the browser
  const last = new Map();
  let missed = 0;
  view.watchers.add((snapshot, at_ms) => {
    for (let i = waiting.length - 1; i >= 0; --i) {
      const event = waiting[i];
      if (event.shows(snapshot)) kinds[event.kind].push(at_ms - event.since_ms);
      else if (at_ms - event.since_ms > 2_000) ++missed;
      else continue;
      waiting.splice(i, 1);
    }
  });
  const listener = (kind, vehicle, message) => {
    const since_ms = Date.parse(message.timestamp);
    const before = last.get(vehicle);
    const row = (snapshot) => snapshot.aivs.find((aiv) => aiv.id === vehicle);
    if (kind === 'state') {
      last.set(vehicle, message);
      if (!before) return;
      // What a later state has overtaken is shown by the later one: of one kind of event only the newest counts.
      const expect = (event, value, of_row) => {
        for (const older of waiting) if (older.kind === event && older.vehicle === vehicle) older.values.add(value);
        const values = new Set([value]);
        waiting.push({ kind: event, vehicle, values, since_ms, shows: (snapshot) => row(snapshot) && values.has(of_row(row(snapshot))) });
      };
      if (before.lastNodeId !== message.lastNodeId) {
        expect('node passed', message.lastNodeId, (aiv) => aiv.lastNode);
        nodes.push({ id: vehicle, node: message.lastNodeId, since_ms });
      }
      if (before.driving !== message.driving) expect('started or stopped', message.driving, (aiv) => aiv.driving);
    } else if (kind === 'detected_obstacle' && message.obstacle) {
      const { x, y } = message.obstacle;
      const near = (obstacle) => Math.hypot(obstacle.x - x, obstacle.y - y) < 0.2;
      const vehicle_near = view.snapshot.aivs.some((aiv) => near(aiv));
      if (vehicle_near || view.snapshot.obstacles.some(near) || waiting.some((event) => event.kind === 'obstacle detected')) return;
      waiting.push({ kind: 'obstacle detected', since_ms, shows: (snapshot) => snapshot.obstacles.some(near) });
    }
  };
  fleet.listeners.add(listener);
  const total = () => Object.values(kinds).reduce((sum, list) => sum + list.length, 0);
  const page = options.browser_share > 0 ? await (await open_browser(t)).newPage() : null;
  const in_browser = async () => (page ? page.evaluate(() => window.shown.length) : Infinity);
  if (page) {
    await page.goto(url);
    await watch_in_browser(page);
    nodes.length = 0;
  }

  // Obstacles in the emulated world, one after the other before a driving vehicle, as long as events are wanted.
  let boxes = 0;
  const wanted_in_browser = page ? options.events * options.browser_share : 0;
  while (total() < options.events || (await in_browser()) < wanted_in_browser) {
    progress(`screen: ${total()} of ${options.events}, ${await in_browser()} of ${wanted_in_browser} in the browser`);
    const aiv = physical(view).find(drives);
    const place = aiv && point_ahead(aiv, 0.5);
    const box = place && (await ask(url, 'POST', 'plant/obstacles', place).catch(() => null));
    if (box) ++boxes;
    await sleep(2_000);
    if (box) await ask(url, 'DELETE', `plant/obstacles/${box.id}`);
    await sleep(3_000);
  }
  fleet.listeners.delete(listener);
  const shown = page ? await page.evaluate(() => window.shown) : [];
  const drawn = [];
  for (const { id, node, since_ms } of nodes) {
    const match = shown.find((one) => one.id === id && one.node === node && one.at_ms >= since_ms - 1 && one.at_ms - since_ms < 2_000);
    if (match) drawn.push(match.at_ms - since_ms);
  }
  return { 'event on screen': Object.values(kinds).flat(), ...kinds, 'node passed, drawn in Chromium': drawn, missed, boxes };
}

const wanted = new Set(options.what.split(','));
const result = { events: options.events };
await with_cleanup(async (t) => {
  const own = options.url === '';
  const platform = own ? await Platform.up(t, { aivs: options.aivs }) : { url: options.url };
  const port = own ? await platform.broker_port() : options.broker_port;
  const view = new View(platform.url);
  t.after(() => view.close());
  await view.opened;
  await eventually('a snapshot comes', () => view.snapshot, { within_ms: 5_000 });
  const fleet = await Fleet.open(t, port);
  await sleep(3_000);
  const rows = [];
  const take = (measured) => {
    const { missed, boxes: _boxes, ...lists } = measured;
    for (const [name, list] of Object.entries(lists)) {
      const { count, p50, p99, max } = figures(list);
      const goal = goals[name];
      rows.push({ delay: name, count, 'p50 ms': p50, 'p99 ms': p99, 'max ms': max, 'goal p99 ms': goal ?? '', held: goal === undefined || count === 0 ? '' : p99 <= goal ? 'yes' : 'NO', missed });
    }
  };
  if (wanted.has('command')) take(await measure_commands(platform.url, view, fleet));
  if (wanted.has('brake')) take(await measure_brakes(platform.url, view, fleet));
  if (wanted.has('screen')) take(await measure_screen(t, platform.url, view, fleet));
  result.delays = rows;
  result.bijection = view.snapshot.bijection;
  table(`Delays on ${own ? `a platform with ${options.aivs} AIVs` : platform.url}`, rows);
});
report(options, result);
