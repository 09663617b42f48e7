// Observes the fleet on the broker and keeps what was observed: the plant's ground truth, and the vehicles' own states (VDA
// 5050). It decides whether a stopped vehicle has moved.
import { connect } from 'mqtt';

const ground_truth_topic = 'cosiva/v1/plant/ground_truth';
const state_topics = 'uagv/+/+/+/state';
const speed_mps_max = 0.55; // the fastest profile of the zone, and a tenth more
const stop_distance_m = 0.8; // half a second until a loss is noticed, braking from 0.5 m/s, a report's 0.1 s, slack
const stop_ms = 3_000;
const stopped_m = 0.02;
const report_age_ms = 300;
const gap_ms_max = 500;
const quiet_ms = 1_500;

/** How far a vehicle may drive after the last observation before its Stop, which is so old. */
function allowed_distance(age_ms) {
  return stop_distance_m + Math.min(0.5, (speed_mps_max * Math.max(0, age_ms - report_age_ms)) / 1_000);
}

export class Witness {
  /** @param on_violation  (what, evidence) */
  constructor(on_violation) {
    this.on_violation = on_violation;
    this.vehicles = new Map(); // number: {x, y, distance, speed, received_ms}
    this.states = new Map(); // serial number: the last VDA 5050 state
    this.holds = new Map(); // number: {since_ms, distance, allowed_m, settled?: distance, stops: [{why, lost}]}
    this.teleports_allowed_until_ms = 0;
    this.received_ms = 0;
  }

  async follow(port) {
    await this.leave();
    this.client = connect(`mqtt://127.0.0.1:${port}`, { clientId: `witness-${process.pid}`, reconnectPeriod: 200, connectTimeout: 2_000, resubscribe: true });
    this.client.on('error', () => {}); // it connects again by itself
    this.client.on('message', (topic, payload) => this.accept(topic, JSON.parse(payload.toString())));
    this.client.subscribe([ground_truth_topic, state_topics]);
  }

  async leave() {
    const client = this.client;
    this.client = null;
    await client?.endAsync(true);
  }

  accept(topic, message) {
    if (topic !== ground_truth_topic) return this.states.set(topic.split('/')[3], { ...message, received_ms: Date.now() });
    const now_ms = Date.now();
    const stamp_ms = Date.parse(message.timestamp);
    for (const seen of message.vehicles) this.accept_vehicle(seen, stamp_ms, now_ms);
    this.collisions = message.collisions;
    this.received_ms = now_ms;
  }

  accept_vehicle({ number, x, y, speed }, stamp_ms, now_ms) {
    const before = this.vehicles.get(number);
    const chord = before ? Math.hypot(x - before.x, y - before.y) : 0;
    const possible = before ? (speed_mps_max * Math.max(0, stamp_ms - before.stamp_ms)) / 1_000 + 0.03 : 0;
    const teleports = now_ms <= this.teleports_allowed_until_ms;
    // After a plant's end and a pause without observations, a vehicle may be at its start position.
    const jumped = chord > possible || (teleports && before && stamp_ms - before.stamp_ms > gap_ms_max);
    if (jumped && !teleports) {
      this.on_violation('a vehicle moved faster than it can', { vehicle: `AIV${number}`, metres: chord, within_ms: stamp_ms - before.stamp_ms });
    }
    this.vehicles.set(number, { x, y, speed, stamp_ms, received_ms: now_ms, distance: (before?.distance ?? 0) + (jumped ? 0 : chord) });
    this.check_hold(number, stamp_ms, before ? stamp_ms - before.stamp_ms : 0);
  }

  /** The plant was ended: its successor puts the vehicles back to their start positions. */
  allow_teleports(for_ms = 20_000) {
    this.teleports_allowed_until_ms = Date.now() + for_ms;
  }

  /**
   * From now on the vehicle must brake, and then not move.
   *
   * @param lost  () => the Stop does not count any more, because the server ended before it was durable
   */
  hold(number, why, { now_ms = Date.now(), lost = () => false } = {}) {
    const before = this.holds.get(number);
    if (before) return before.stops.push({ why, lost }); // the first Stop is the stricter one
    this.begin_hold(number, [{ why, lost }], now_ms);
  }

  begin_hold(number, stops, now_ms) {
    const vehicle = this.vehicles.get(number);
    this.holds.set(number, { since_ms: now_ms, stops, distance: vehicle?.distance ?? 0, allowed_m: allowed_distance(vehicle ? now_ms - vehicle.stamp_ms : 0) });
  }

  /** The vehicle has moved: is that because its first Stop was lost? What remains of its Stops holds from now on. */
  excused(number, hold) {
    if (!hold.stops[0].lost()) return false;
    const stops = hold.stops.filter(({ lost }) => !lost());
    this.holds.delete(number);
    if (stops.length > 0) this.begin_hold(number, stops, Date.now());
    return true;
  }

  release(number) {
    this.holds.delete(number);
  }

  /** By the plant's time stamps: messages may wait in a queue, of this program too. */
  check_hold(number, stamp_ms, gap_ms) {
    const hold = this.holds.get(number);
    if (!hold || hold.reported) return;
    const { distance, x, y } = this.vehicles.get(number);
    if (stamp_ms <= hold.since_ms) {
      Object.assign(hold, { distance, allowed_m: allowed_distance(hold.since_ms - stamp_ms) });
      return;
    }
    const since_stop_ms = stamp_ms - hold.since_ms;
    const report = (what, metres) => {
      if (this.excused(number, hold)) return;
      hold.reported = true;
      this.on_violation(what, { vehicle: `AIV${number}`, metres: Number(metres.toFixed(3)), since_stop_ms, command: hold.stops[0].why, x, y, paused: this.states.get(`AIV${number}`)?.paused });
    };
    if (distance - hold.distance > hold.allowed_m) return report('a stopped vehicle drove more than a braking distance', distance - hold.distance);
    // A frozen plant continues the braking where it was.
    if (gap_ms > gap_ms_max) Object.assign(hold, { settled: undefined, quiet_from_ms: stamp_ms + quiet_ms });
    if (since_stop_ms < stop_ms || stamp_ms < (hold.quiet_from_ms ?? 0)) return;
    hold.settled ??= distance;
    if (distance - hold.settled > stopped_m) report(`a vehicle moved later than ${stop_ms / 1_000} s after its Stop`, distance - hold.settled);
  }

  distances() {
    return new Map([...this.vehicles].map(([number, { distance }]) => [number, distance]));
  }
}
