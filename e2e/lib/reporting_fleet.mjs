// Hundreds of vehicles that report from one process of their own, so that their load delays no measurement of the test.
// Each drives along its section of the zone and is paused from a `startPause` until a `stopPause`.
//   const fleet = await ReportingFleet.start(t, { broker_port, zone, count, hz })
// Run as a program it is that process: node reporting_fleet.mjs '{"broker_port":…,"zone":…,"count":…,"hz":…}'
import { fork } from 'node:child_process';
import { fileURLToPath } from 'node:url';
import { connect } from 'mqtt';
import { finally_do } from './cleanup.mjs';
import { Circuit } from './circuit.mjs';
import { within } from './platform.mjs';

const program = fileURLToPath(import.meta.url);
export const serial = (number) => `AIV${number}`;
/** Milliseconds since 1970 with fractions: comparable between processes of one machine, and with a page's `timeOrigin`. */
export const wall_ms = () => performance.timeOrigin + performance.now();

export class ReportingFleet {
  /** @param hz  states per second of each vehicle */
  static async start(t, { broker_port, zone, count, hz = 10 }) {
    const fleet = new ReportingFleet();
    const { waypoints } = await Circuit.load(zone);
    fleet.received = new Map(); // "AIV1 actionId" → wall_ms of the first arrival
    fleet.child = fork(program, ['run']);
    const ended = new Promise((resolve) => fleet.child.on('exit', resolve));
    finally_do(t, async () => {
      fleet.child.kill('SIGTERM');
      await within(ended, 3_000);
      fleet.child.kill('SIGKILL');
    });
    await new Promise((resolve, reject) => {
      fleet.child.on('exit', (code) => reject(new Error(`the fleet ended early: ${code}`)));
      fleet.child.on('message', (message) => {
        if (message.ready) resolve();
        for (const [key, at_ms] of message.received ?? []) fleet.received.set(key, at_ms);
      });
      fleet.child.send({ broker_port, zone, count, hz, waypoints: waypoints.map(({ x, y, heading, section }) => [x, y, heading, section]) });
    });
    return fleet;
  }
}

/** Where the vehicles are: each on the way between two waypoints of one section, there and back at 0.8 m/s. */
class Tracks {
  constructor(waypoints, count) {
    this.pairs = [];
    for (let i = 0; i + 1 < waypoints.length; ++i) if (waypoints[i][3] === waypoints[i + 1][3]) this.pairs.push([waypoints[i], waypoints[i + 1]]);
    this.count = count;
  }

  /** The vehicles are spread over the whole zone. */
  position(index, seconds) {
    const [[x0, y0, heading], [x1, y1]] = this.pairs[Math.floor((index * this.pairs.length) / this.count)];
    const length = Math.hypot(x1 - x0, y1 - y0);
    const driven = (0.8 * seconds) % (2 * length);
    const ratio = (driven < length ? driven : 2 * length - driven) / length;
    return { x: x0 + ratio * (x1 - x0), y: y0 + ratio * (y1 - y0), theta: driven < length ? heading : heading + Math.PI };
  }
}

class Reporter {
  constructor({ broker_port, zone, count, hz, waypoints }) {
    Object.assign(this, { zone, count, hz, paused: new Set(), first: new Set(), batch: [], began_ms: wall_ms(), sent: new Map() });
    this.tracks = new Tracks(waypoints, count);
    this.client = connect(`mqtt://127.0.0.1:${broker_port}`, { clientId: `fleet-${process.pid}`, reconnectPeriod: 200 });
    this.client.on('error', () => {}); // the client connects again by itself
    this.client.on('message', (topic, payload) => this.accept(topic.split('/')[3], JSON.parse(payload.toString())));
  }

  async run() {
    await new Promise((resolve) => this.client.once('connect', resolve));
    await this.client.subscribeAsync('uagv/v2/CoSiVA/+/instantActions');
    for (let i = 0; i < this.count; ++i) this.publish(i, 'connection', { connectionState: 'ONLINE' });
    setInterval(() => this.report(), 5);
    process.send({ ready: true });
  }

  accept(name, { actions }) {
    for (const { actionType, actionId } of actions) {
      if (actionType === 'startPause') this.paused.add(name);
      if (actionType === 'stopPause') this.paused.delete(name);
      const key = `${name} ${actionId}`;
      if (this.first.has(key)) continue;
      this.first.add(key);
      // A Stop of all is one message to the test, not one per vehicle.
      if (this.batch.length === 0) setImmediate(() => process.send({ received: this.batch.splice(0) }));
      this.batch.push([key, wall_ms()]);
    }
  }

  publish(index, topic, content) {
    const name = serial(index + 1);
    const full = `uagv/v2/CoSiVA/${name}/${topic}`;
    const headerId = this.sent.get(full) ?? 0; // counts the messages of each topic (VDA 5050 §6.4)
    this.sent.set(full, headerId + 1);
    const header = { headerId, timestamp: new Date().toISOString(), version: '2.1.0', manufacturer: 'CoSiVA', serialNumber: name };
    this.client.publish(full, JSON.stringify({ ...header, ...content }), { qos: 0 });
  }

  /** The states that are due; after a long pause of the process they are not caught up. */
  report() {
    const seconds = (wall_ms() - this.began_ms) / 1000;
    const due = Math.floor(seconds * this.hz * this.count);
    this.reported = Math.max(this.reported ?? 0, due - this.count);
    for (; this.reported < due; ++this.reported) this.state(this.reported % this.count, seconds);
  }

  state(index, seconds) {
    const name = serial(index + 1);
    const paused = this.paused.has(name);
    this.publish(index, 'state', {
      orderId: '', orderUpdateId: 0, lastNodeId: '', lastNodeSequenceId: 0, nodeStates: [], edgeStates: [], actionStates: [],
      driving: !paused, paused, newBaseRequest: false, errors: [], information: [], operatingMode: 'AUTOMATIC',
      agvPosition: { ...this.tracks.position(index, paused ? 0 : seconds), mapId: this.zone, positionInitialized: true },
      velocity: { vx: paused ? 0 : 0.8, vy: 0, omega: 0 },
      batteryState: { batteryCharge: 40 + ((index * 7) % 60), charging: false }, safetyState: { eStop: 'NONE', fieldViolation: false },
    });
  }
}

if (process.argv[1] === program && process.argv[2] === 'run') {
  process.once('message', (options) => void new Reporter(options).run());
  process.on('disconnect', () => process.exit()); // the test has ended
}
