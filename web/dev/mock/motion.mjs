// What moves in the made-up world, and the messages it sends meanwhile. The physics is not modelled.
import { circuit_for } from './tracks.mjs';
import { intent_of, order_of, state_of, topic_of, Traces, visualization_of } from './traces.mjs';

const profiles = { normal: 0.35, slow: 0.12, medium: 0.25, fast: 0.45 };
const half_length = 0.1;
const see_m = 1.0;

export class Motion {
  constructor({ aivs, zone, clock, scenario }) {
    this.traces = new Traces();
    this.clock = { kind: clock, running: true, speed: 1, time_ms: Date.now() };
    this.scenario = scenario;
    this.count = aivs;
    this.commands = [];
    this.command_number = 0;
    this.handles = { aiv: 0, virtualObject: 32768, detected: 49152 };
    this.load(zone, aivs);
  }

  load(name, aivs) {
    this.circuit = circuit_for(name, aivs);
    this.zone_revision = (this.zone_revision ?? 0) + 1;
    this.pitch = this.circuit.beacons?.pitch_m ?? null;
    const { tracks, total } = this.circuit;
    this.tags = Array.from({ length: this.circuit.tags }, (_, i) => ({ number: i + 1, ...this.spread((i + 0.5) / this.circuit.tags, tracks, total) }));
    this.undo_stack = [];
    this.redo_stack = [];
    this.saved = true;
    this.aivs = [];
    for (let i = 0; i < aivs; i++) this.make_aiv(i + 1, false, this.spread((i + 0.3) / aivs, tracks, total));
    this.virtualObjects = [];
    this.boxes = [];
    this.detected = [];
    this.zone_cache = null;
    this.closed = new Set();
  }
  spread(ratio, tracks, total) {
    let distance = ratio * total;
    for (const track of tracks) {
      if (distance < track.lap) return { track, distance };
      distance -= track.lap;
    }
    return { track: tracks[0], distance: 0 };
  }
  make_aiv(number, augmented, { track, distance }) {
    const serial = augmented ? `V${number}` : `AIV${number}`;
    const aiv = {
      id: `${augmented ? 'CoSiVA.virtual' : 'CoSiVA'}/${serial}`, serial, number, augmented, track, distance, handle: this.handles.aiv++, speed: 0.3, imposed: null, paused: false,
      lost_at: null, drift: 0.002, battery: 30 + ((61 + 53 * number) % 68), priority: 0, brakingFor: null, perceived: null, field: false, orderUpdateId: 1, orderId: `${this.circuit.name}-${number}`, waits: null,
      trace_phase: (number * 37) % 100, last_tag: null, since_tag: 0, pose: track.pose_at(distance),
    };
    this.aivs.push(aiv);
    return aiv;
  }
  get now() {
    return this.clock.time_ms;
  }

  // ── time ──
  /** @param real_ms since the last call */
  advance(real_ms) {
    if (this.clock.kind === 'virtual' && !this.clock.running) return;
    this.step_by(real_ms * (this.clock.kind === 'virtual' ? this.clock.speed : 1));
  }
  step_by(ms) {
    const longest = this.aivs.length > 1000 ? 200 : 50;
    for (let left = ms; left > 0; left -= longest) {
      const slice = Math.min(longest, left);
      this.clock.time_ms += slice;
      this.step(slice / 1000);
    }
  }

  step(dt) {
    this.walk(dt);
    const few = this.aivs.length <= 200;
    const bodies = few ? [...this.virtualObjects, ...this.boxes.map((box) => ({ ...box, physical: true }))] : [];
    const by_track = new Map();
    for (const aiv of this.aivs) {
      const list = by_track.get(aiv.track);
      if (list) list.push(aiv);
      else by_track.set(aiv.track, [aiv]);
    }
    for (const [track, list] of by_track) {
      list.sort((a, b) => a.distance - b.distance);
      list.forEach((aiv, i) => {
        const next = list[(i + 1) % list.length];
        const gap = list.length > 1 ? (((next.distance - aiv.distance) % track.lap) + track.lap) % track.lap : track.lap;
        this.drive(aiv, gap, bodies, dt);
      });
    }
    if (few) this.see();
    this.follow_commands();
    this.send_messages(dt);
  }
  drive(aiv, gap, bodies, dt) {
    let target_speed = aiv.paused || aiv.lost_at ? 0 : profiles[aiv.imposed ?? 'normal'] * (0.85 + 0.3 * ((aiv.number * 7) % 10) / 10);
    aiv.waits = null;
    if (gap < 0.34) {
      target_speed = 0;
      aiv.waits = 'the AIV ahead';
    }
    aiv.brakingFor = null;
    aiv.field = false;
    aiv.ahead = null;
    const { x, y, heading } = aiv.pose;
    for (const body of bodies) {
      const dx = body.x - x;
      const dy = body.y - y;
      const ahead = dx * Math.cos(heading) + dy * Math.sin(heading) - half_length - body.radius;
      const aside = Math.abs(-dx * Math.sin(heading) + dy * Math.cos(heading)) - body.radius;
      if (ahead < -0.1 || ahead > see_m || aside > 0.09) continue;
      if (body.physical && (aiv.ahead === null || ahead < aiv.ahead)) aiv.ahead = Math.max(0.02, ahead);
      if (ahead > 0.3) continue;
      target_speed = 0;
      if (body.physical) aiv.field = true;
      else aiv.brakingFor = body.id;
    }
    aiv.speed = Math.max(0, aiv.speed + Math.max(-1.2 * dt, Math.min(0.5 * dt, target_speed - aiv.speed)));
    aiv.distance += aiv.speed * dt;
    aiv.pose = aiv.track.pose_at(aiv.distance);
    aiv.battery = Math.max(0, aiv.battery - 0.002 * dt);
    aiv.since_tag += aiv.speed * dt;
    if (this.aivs.length <= 200) {
      for (const tag of this.tags) {
        const p = tag.track === aiv.track ? (((aiv.distance - tag.distance) % aiv.track.lap) + aiv.track.lap) % aiv.track.lap : Infinity;
        if (p < aiv.speed * dt + 1e-9) Object.assign(aiv, { last_tag: tag.number, since_tag: p });
      }
    }
  }
  walk(dt) {
    for (const virtualObject of this.virtualObjects) {
      if (!virtualObject.path || virtualObject.path.length < 2) continue;
      const legs = virtualObject.path.slice(1).map((p, i) => Math.hypot(p[0] - virtualObject.path[i][0], p[1] - virtualObject.path[i][1]));
      if (virtualObject.repeat === 'loop') legs.push(Math.hypot(virtualObject.path[0][0] - virtualObject.path.at(-1)[0], virtualObject.path[0][1] - virtualObject.path.at(-1)[1]));
      const length = legs.reduce((a, b) => a + b, 0);
      if (length <= 0) continue;
      virtualObject.walked += virtualObject.speed * dt;
      let at = virtualObject.walked;
      let back = false;
      if (virtualObject.repeat === 'loop') at %= length;
      else if (virtualObject.repeat === 'back and forth') {
        at %= 2 * length;
        back = at > length;
        if (back) at = 2 * length - at;
      } else at = Math.min(at, length);
      let leg = 0;
      while (leg < legs.length - 1 && at > legs[leg]) at -= legs[leg++];
      const from = virtualObject.path[leg];
      const to = virtualObject.path[(leg + 1) % virtualObject.path.length];
      const ratio = legs[leg] > 0 ? at / legs[leg] : 0;
      virtualObject.x = from[0] + (to[0] - from[0]) * ratio;
      virtualObject.y = from[1] + (to[1] - from[1]) * ratio;
      virtualObject.heading = Math.atan2(to[1] - from[1], to[0] - from[0]) + (back ? Math.PI : 0);
      virtualObject.moving = virtualObject.repeat !== 'once' || virtualObject.walked < length;
    }
  }
  see() {
    for (const box of this.boxes) {
      for (const aiv of this.aivs) {
        if (aiv.augmented || aiv.lost_at) continue;
        const reach = Math.hypot(box.x - aiv.pose.x, box.y - aiv.pose.y);
        if (reach > 0.8 || aiv.ahead === null) continue;
        let obstacle = this.detected.find((one) => one.box === box.id);
        if (!obstacle) {
          obstacle = { id: `S${this.next_number(this.detected)}`, handle: this.handles.detected++, box: box.id, x: box.x + 0.006, y: box.y - 0.004, radius: box.radius * 0.95, detectedBy: [], first_ms: this.now, last_ms: this.now };
          this.detected.push(obstacle);
          this.traces.add(this.now, aiv.serial, 'AIV_Server', 'detected_obstacle', `cosiva/v1/detected_obstacle/${aiv.id}`, `an obstacle at ${obstacle.x.toFixed(2)}, ${obstacle.y.toFixed(2)}`, { headerId: 1, timestamp: new Date(this.now).toISOString(), mapId: this.circuit.name, obstacle: { x: obstacle.x, y: obstacle.y, radius: obstacle.radius, distance: aiv.ahead }, clear: aiv.ahead });
        }
        obstacle.last_ms = this.now;
        if (!obstacle.detectedBy.includes(aiv.id)) obstacle.detectedBy.push(aiv.id);
      }
    }
    const gone = (one) => !this.boxes.some((box) => box.id === one.box) && this.aivs.some((aiv) => Math.hypot(aiv.pose.x - one.x, aiv.pose.y - one.y) < 0.2);
    this.detected = this.detected.filter((one) => !gone(one));
  }
  next_number(list) {
    const taken = new Set(list.map((one) => Number(/\d+$/.exec(one.id)?.[0])));
    let n = 1;
    while (taken.has(n)) n++;
    return n;
  }
  follow_commands() {
    for (const command of this.commands) {
      if (command.state !== 'issued' && command.state !== 'accepted') continue;
      const aiv = this.aivs.find((candidate) => candidate.id === command.vehicle);
      const age = this.now - command.time_ms;
      if (command.state === 'issued' && age > 34) Object.assign(command, { state: 'accepted', accepted_ms: age });
      if (command.state !== 'accepted' || !aiv) continue;
      const observed = command.command === 'stop' ? aiv.speed < 0.01 : aiv.speed > 0.05 || command.command === 'cancel';
      if (observed) Object.assign(command, { state: 'materialised', materialised_ms: age });
      else if (age > 5000) Object.assign(command, { state: 'failed', reason: 'not observed within 5 s' });
    }
    if (this.commands.length > 200) this.commands.splice(0, 100);
  }
  /** What it is about to do, to one near it; now and then it follows that one through a crossing. */
  send_intent(aiv, row, map) {
    const next = this.aivs[(this.aivs.indexOf(aiv) + 1) % this.aivs.length];
    if (next === aiv) return;
    const cell = `${Math.floor(row.x / 3)}_${Math.floor(row.y / 3)}`;
    this.traces.add(this.now, aiv.serial, next.serial, 'V2X', `cosiva/v1/v2x/${map}/${cell}/${aiv.id}`, `${row.speed.toFixed(3)} m/s; X1 in 0.900 s, not yet its own`, intent_of(row, this.now, map));
    if (Math.floor(aiv.distance / 6) === aiv.convoys) return;
    aiv.convoys = Math.floor(aiv.distance / 6);
    this.traces.add(this.now, 'AIV_Server', aiv.serial, 'convoy', '', `convoy of 2 through X1 and X4, behind ${next.id}`, null);
  }
  /** Messages as the real parts would send them; of large fleets only the first few vehicles' are recorded. */
  send_messages(dt) {
    const map = this.circuit.name;
    for (const aiv of this.aivs.slice(0, 12)) {
      if (aiv.lost_at) continue;
      const before = aiv.trace_phase;
      aiv.trace_phase += dt * 1000;
      const crossed = (period) => Math.floor(before / period) !== Math.floor(aiv.trace_phase / period);
      if (!crossed(100)) continue;
      const row = this.row(aiv);
      this.traces.add(this.now, aiv.serial, 'AIV_Server', 'visualization', topic_of(aiv.id, 'visualization'), `${row.x.toFixed(3)}, ${row.y.toFixed(3)}, ${row.heading.toFixed(3)} rad, ${row.speed.toFixed(2)} m/s`, visualization_of(row, this.now, map));
      if (crossed(1000)) this.traces.add(this.now, aiv.serial, 'AIV_Server', 'state', topic_of(aiv.id, 'state'), `order ${row.orderId} update ${row.orderUpdateId}, last node ${row.lastNode}, ${row.driving ? 'driving' : 'stopped'}`, state_of(row, this.now, map));
      if (crossed(1000)) this.send_intent(aiv, row, map);
      const update = Math.floor(aiv.distance / 0.6);
      if (update !== aiv.orderUpdateId) {
        aiv.orderUpdateId = update;
        this.traces.add(this.now, 'AIV_Server', aiv.serial, 'order', topic_of(aiv.id, 'order'), `order ${row.orderId} update ${update}: 4 nodes, 3 released`, order_of({ ...row, orderUpdateId: update }, this.now, map));
      }
      if (aiv.brakingFor !== aiv.perceived) {
        const braking = aiv.brakingFor !== null;
        aiv.perceived = aiv.brakingFor;
        this.traces.add(this.now, 'AIV_Server', aiv.serial, 'virtual_obstacles', `cosiva/v1/virtual_obstacles/${aiv.id}`, braking ? `${aiv.brakingFor} ahead` : 'nothing ahead', { headerId: update, timestamp: new Date(this.now).toISOString(), mapId: map, bodies: this.virtualObjects.filter((virtualObject) => virtualObject.id === aiv.brakingFor).map(({ id, kind, x, y, heading, radius }) => ({ id, kind, x, y, heading, length: 0, radius, vx: 0, vy: 0 })) });
        this.traces.add(this.now + 9, aiv.serial, 'AIV_Server', 'virtual_obstacles_ack', `cosiva/v1/virtual_obstacles_ack/${aiv.id}`, braking ? `brakes for ${aiv.brakingFor}` : 'goes on', { virtualObstaclesHeaderId: update, decided: new Date(this.now + 4).toISOString(), braking, body: aiv.perceived ?? '', distance: 0.28 });
      }
    }
    const second = Math.floor(this.now / 1000);
    if (second !== this.heartbeat_s) {
      this.heartbeat_s = second;
      this.traces.add(this.now, 'AIV_Server', '*', 'heartbeat', 'cosiva/v1/server/heartbeat', 'alive', { headerId: second % 100000, timestamp: new Date(this.now).toISOString() });
    }
  }
}
