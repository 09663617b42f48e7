// Observes the bus from outside: the plant's ground truth, and every message.
import assert from 'node:assert/strict';
import { finally_do } from './cleanup.mjs';
import { connect } from 'mqtt';
import { eventually, sleep } from './platform.mjs';

export class Bus {
  /** Connects and keeps connecting; `topics` are received from now on. */
  static async open(t, port, topics) {
    const bus = new Bus();
    bus.client = connect(`mqtt://127.0.0.1:${port}`, { clientId: `e2e-${process.pid}-${Math.floor(performance.now() * 1000)}`, reconnectPeriod: 200, connectTimeout: 2_000 });
    bus.listeners = [];
    bus.client.on('message', (topic, payload, packet) => {
      for (const listener of bus.listeners) listener(topic, payload, packet);
    });
    bus.client.on('error', () => {}); // the client connects again by itself
    finally_do(t, () => bus.client.endAsync(true));
    await eventually('the bus responds', () => bus.client.connected, { within_ms: 5_000 });
    if (topics.length > 0) await bus.client.subscribeAsync(topics, { qos: 0 });
    return bus;
  }

  on_message(listener) {
    this.listeners.push(listener);
  }

  publish(topic, value, options = {}) {
    return this.client.publishAsync(topic, JSON.stringify(value), options);
  }
}

/** Follows the plant's ground truth: the actual position of each vehicle, and every collision. */
export class Truth {
  static async follow(t, port) {
    const ground_truth = new Truth();
    ground_truth.latest = null;
    ground_truth.received_ms = 0;
    ground_truth.collisions = 0;
    ground_truth.last = [];
    ground_truth.before_collisions = [];
    const bus = await Bus.open(t, port, ['cosiva/v1/plant/ground_truth']);
    bus.on_message((_topic, payload) => ground_truth.accept(JSON.parse(payload.toString())));
    await eventually('the plant publishes the ground truth', () => ground_truth.latest !== null, { within_ms: 10_000 });
    return ground_truth;
  }

  /** Adds to each vehicle the distance driven since the first message: chords of a tenth of a second. */
  accept(news) {
    for (const vehicle of news.vehicles) {
      const before = this.latest?.vehicles.find(({ number }) => number === vehicle.number);
      vehicle.distance = before ? before.distance + Math.hypot(vehicle.x - before.x, vehicle.y - before.y) : 0;
    }
    this.last = [...this.last, news].slice(-30);
    if (news.collisions > this.collisions) this.before_collisions.push(this.last);
    this.latest = news;
    this.received_ms = Date.now();
    this.collisions = news.collisions;
  }

  /** Fails with what the vehicles did in the three seconds before each collision. */
  assert_no_collision() {
    const line = ({ timestamp, vehicles }) =>
      `${timestamp} ${vehicles.map(({ number, x, y, speed }) => `AIV${number} (${x.toFixed(3)}, ${y.toFixed(3)}) ${speed.toFixed(2)} m/s`).join(', ')}`;
    const before = this.before_collisions.map((last) => last.map(line).join('\n'));
    assert.equal(this.collisions, 0, `${this.collisions} collisions\n${before.join('\n\n')}`);
  }

  vehicle(number) {
    return this.latest.vehicles.find((vehicle) => vehicle.number === number);
  }

  /** The first ground truth that arrives after now. */
  async next() {
    const seen = this.received_ms;
    await eventually('a newer ground truth', () => this.received_ms > seen, { within_ms: 15_000, every_ms: 10 });
    return this.latest;
  }

  /** Metres driven by each vehicle during `ms`, by number. */
  async driven(ms) {
    const before = new Map(this.latest.vehicles.map((vehicle) => [vehicle.number, vehicle.distance]));
    await sleep(ms);
    await this.next();
    return new Map(this.latest.vehicles.map((vehicle) => [vehicle.number, vehicle.distance - before.get(vehicle.number)]));
  }

  /** Waits until `number` is stopped; returns how long that took [ms]. */
  async stands(number, within_ms) {
    const start = Date.now();
    await eventually(`AIV${number} is stopped in the ground truth`, () => Math.abs(this.vehicle(number).speed) < 0.01, { within_ms, every_ms: 20 });
    return Date.now() - start;
  }

  /**
   * Waits until `number` has not moved for 0.7 s: a vehicle whose program is killed executes its last command for up to
   * half a second more, and one that was about to start moves off although it is at rest at present.
   */
  async rests(number, within_ms) {
    const end = Date.now() + within_ms;
    while ((await this.driven(700)).get(number) > 0.0005) {
      if (Date.now() > end) throw new Error(`not within ${within_ms} ms: AIV${number} rests in the ground truth`);
    }
  }

  async moves(number, within_ms) {
    await eventually(`AIV${number} moves in ground_truth`, () => Math.abs(this.vehicle(number).speed) > 0.05, { within_ms, every_ms: 20 });
  }
}
