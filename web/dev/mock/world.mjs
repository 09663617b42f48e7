// Made-up vehicles, persons, obstacles and a zone that can be edited: the state of the mock server. The physics
// is not modelled; a page only needs data in the platform's formats.
import { Motion } from './motion.mjs';
import { action_of, topic_of } from './traces.mjs';
import { draw_zone, nearest_position, position_of } from './tracks.mjs';

const operator_commands = ['stop', 'slow', 'medium', 'fast', 'restart', 'cancel'];
const status_words = ['Normal', 'stopped', 'slow speed', 'medium speed', 'fast speed'];

/** Thrown for an invalid request; the server turns it into an error response. */
export class Refusal extends Error {
  constructor(status, code, message) {
    super(message);
    Object.assign(this, { status, code });
  }
}

export class World extends Motion {
  /** Another zone, while they drive: each is put on a section of it, and the last one is off-route, as an example. */
  switch_zone({ name, file }) {
    if (name === undefined) {
      this.refused = { origin: file ?? 'a file', why: 'line 3: the mock reads no files', at: this.now };
      throw new Refusal(422, 'zone.mock', `${file}: line 3: the mock reads no files.`);
    }
    if (!['lacet4', 'yard'].includes(name)) throw new Refusal(404, 'zone.missing', `There is no zone ${name}.`);
    const from = this.circuit.name;
    const { commands, command_number } = this;
    this.load(name, this.count);
    Object.assign(this, { commands, command_number });
    const last = this.aivs.at(-1);
    Object.assign(last, { paused: true, offRoute: 'it is 0.82 m from every section' });
    this.switched = { at: this.now, from, first_moving_ms: 431, snapped: this.aivs.length - 1, offRoute: [last.id] };
    return { revision: this.zone_revision, name };
  }
  suggest_beacons() {
    const { origin } = this.zone.beacons ?? {};
    if (!origin) throw new Refusal(409, 'zone.beacons', 'This zone has no beacons.');
    return { origin: [origin[0] + 0.07, origin[1] + 0.03], now_m: 1.92, longest_free_m: 0.61 };
  }
  get zone() {
    this.zone_cache ??= draw_zone(this.circuit, this.tags, this.pitch);
    return this.zone_cache;
  }
  run() {
    return { name: 'mock', scenario: this.scenario, version: '0.3.0', clock: { ...this.clock } };
  }

  // ── its state ──
  status_of(aiv) {
    if (aiv.speed < 0.01) return 1;
    return aiv.imposed === 'slow' ? 2 : aiv.imposed === 'medium' ? 3 : aiv.imposed === 'fast' ? 4 : 0;
  }
  lost(aiv) {
    return aiv.lost_at !== null && this.now - aiv.lost_at > 1000;
  }
  positions() {
    const records = this.aivs.map((aiv) => ({
      handle: aiv.handle, kind: 0, status: this.lost(aiv) ? 5 : this.status_of(aiv), augmented: aiv.augmented, blocked: aiv.field || aiv.brakingFor !== null,
      x: aiv.pose.x, y: aiv.pose.y, heading: aiv.pose.heading, speed: aiv.speed, dx: -aiv.drift - aiv.speed * 0.03 * Math.cos(aiv.pose.heading), dy: aiv.drift - aiv.speed * 0.03 * Math.sin(aiv.pose.heading),
    }));
    for (const virtualObject of this.virtualObjects) records.push({ handle: virtualObject.handle, kind: virtualObject.kind === 'person' ? 1 : 2, status: 0, augmented: true, blocked: false, x: virtualObject.x, y: virtualObject.y, heading: virtualObject.heading, speed: virtualObject.moving ? virtualObject.speed : 0, dx: 0, dy: 0 });
    for (const one of this.detected) records.push({ handle: one.handle, kind: 2, status: 0, augmented: false, blocked: false, x: one.x, y: one.y, heading: 0, speed: 0, dx: 0, dy: 0 });
    return records.sort((a, b) => a.handle - b.handle);
  }
  ground_truth() {
    const wobble = (n, phase) => 0.004 * Math.sin(this.now / 900 + n + phase);
    return {
      type: 'ground_truth',
      vehicles: this.aivs.filter((aiv) => !aiv.augmented).slice(0, 200).map(({ number, pose }) => ({ number, x: pose.x + wobble(number, 0), y: pose.y + wobble(number, 1.3), heading: pose.heading + wobble(number, 2) * 3 })),
      obstacles: this.boxes,
    };
  }
  row(aiv) {
    const { pose } = aiv;
    const lost = this.lost(aiv);
    const age = aiv.lost_at ? this.now - aiv.lost_at : 20 + ((this.now + 31 * aiv.number) % 100);
    const heading = Math.atan2(Math.sin(pose.heading), Math.cos(pose.heading));
    const stopped = aiv.speed < 0.01;
    const ranges = this.aivs.length <= 200 ? { ranges: { first: -0.6, width: 0.15, m: Array.from({ length: 9 }, (_, i) => (aiv.ahead !== null && aiv.ahead !== undefined && i > 2 && i < 6 ? aiv.ahead : null)) } } : {};
    const reserved = this.aivs.length <= 2000 ? Array.from({ length: 9 }, (_, i) => aiv.track.pose_at(aiv.distance + (i * Math.max(0.05, aiv.paused ? 0.05 : 0.9)) / 8)).map((p) => [p.x, p.y]) : [];
    const boards = this.aivs.length <= 200 && !aiv.augmented ? { boards: ['PILS', 'PRAV', 'DOBS', 'RALI'].map((board, i) => ({ board, health: aiv.board_down === board ? 'lost' : 'ok', firmware: '1a2b3c4d', uptime_ms: (this.now % 1e8) | 0, frames: 61000 + i * 300, framesBad: i === 2 ? 3 : 0, framesMissed: i, selfTest: 0 })), power: { voltage_v: 11.4 + aiv.battery / 100, current_a: 0.3 + aiv.speed, temperature_c: 24 + (aiv.number % 5) } } : {};
    return {
      id: aiv.id, handle: aiv.handle, number: aiv.number, augmented: aiv.augmented, connection: aiv.lost_at && age > 1500 ? 'CONNECTIONBROKEN' : 'ONLINE', lost, status: status_words[this.status_of(aiv)],
      x: pose.x, y: pose.y, heading, speed: aiv.speed, section: pose.section, s: pose.s, priority: aiv.priority,
      reported: { x: pose.x - aiv.drift - aiv.speed * 0.03 * Math.cos(heading), y: pose.y + aiv.drift - aiv.speed * 0.03 * Math.sin(heading), heading }, age_ms: age, divergence_m: aiv.drift * (0.6 + 0.4 * Math.sin(this.now / 700 + aiv.number)),
      battery: aiv.battery, lastTag: aiv.last_tag, sinceTag_m: aiv.since_tag, lastNode: `${pose.section}@${Math.floor(pose.s / 0.3) * 300}`, orderId: aiv.orderId, orderUpdateId: aiv.orderUpdateId,
      driving: !stopped, paused: aiv.paused, fieldViolation: aiv.field, waitsFor: stopped && !aiv.paused ? aiv.waits : null, brakingFor: aiv.brakingFor, errors: aiv.field ? ['An obstacle is in its path'] : [],
      reserved, ...boards, ...ranges, contract: { matched: true, divergence: aiv.drift < 0.03, age: !aiv.lost_at },
    };
  }
  crossings() {
    return this.circuit.crossings.map(({ name, x, y }) => {
      const near = this.aivs.filter((aiv) => Math.hypot(aiv.pose.x - x, aiv.pose.y - y) < 0.3);
      return { name, heldBy: near[0]?.id ?? null, waiting: near.slice(1).map((aiv) => aiv.id) };
    });
  }
  bijection() {
    const real = this.aivs.filter((aiv) => !aiv.augmented);
    const lost = real.filter((aiv) => aiv.lost_at).length;
    const drift = real.reduce((most, aiv) => Math.max(most, aiv.drift), 0);
    const done = this.commands.filter((command) => command.state === 'materialised');
    return {
      physical: real.length, virtual: real.length, matched: real.length, matched_ratio: 1, orphans: [], augmented: this.aivs.length - real.length + this.virtualObjects.length,
      divergence_m: statistics(drift * 0.7, Math.max(0.0112, drift), 48_000), divergence_rad: statistics(0.004, 0.02, 48_000), age_ms: statistics(54, lost ? 1800 : 108, 48_000),
      commands: { issued: this.commands.length, accepted: this.commands.filter((c) => c.accepted_ms !== null).length, materialised: done.length, failed: this.commands.filter((c) => c.state === 'failed').length, latency_ms: statistics(done.length ? 480 : 0, done.length ? 910 : 0, done.length) },
      events: { count: 412, latency_ms: statistics(48, 131, 412), by_kind: { arrival: 4, tag: 380, obstacle: 9, stop: 19, battery: 0 } },
      effects: { perceived_ms: statistics(18, 41, 37), brakes_ms: statistics(21, 44, 12), shown_ms: statistics(62, 97, 5) },
      held_ratio: lost ? 0.981 : 0.9994, held: { divergence: true, age: !lost, actual: true, commands: true, events: true, effects: true }, contract: { divergence_p99_m: 0.03, age_p99_ms: 150, command_p99_ms: 2000, event_p99_ms: 500, effect_p99_ms: 200 },
    };
  }
  snapshot() {
    const perceived_by = (virtualObject) => this.aivs.filter((aiv) => aiv.brakingFor === virtualObject.id).map((aiv) => aiv.id);
    return {
      time: new Date(this.now).toISOString(), time_ms: this.now, zoneRevision: this.zone_revision,
      zoneEdits: { undo: this.undo_stack.length, redo: this.redo_stack.length, unsaved: !this.saved },
      zone: { name: this.circuit.name, revision: this.zone_revision, closed: [...this.closed].sort(), refused: this.refused ?? null, switched: this.switched ?? null },
      aivs: this.aivs.map((aiv) => ({ ...this.row(aiv), mission: aiv.mission ?? { kind: 'circulate', loop: null, state: 'driving' }, map: this.circuit.name, offRoute: aiv.offRoute ?? null })),
      virtualObjects: this.virtualObjects.map((virtualObject) => ({ id: virtualObject.id, handle: virtualObject.handle, kind: virtualObject.kind, x: virtualObject.x, y: virtualObject.y, heading: virtualObject.heading, radius: virtualObject.radius, speed: virtualObject.speed, ...(virtualObject.path ? { path: virtualObject.path, repeat: virtualObject.repeat } : {}), perceivedBy: perceived_by(virtualObject), since_ms: virtualObject.since_ms })),
      obstacles: this.detected.map(({ id, handle, x, y, radius, detectedBy, first_ms, last_ms }) => ({ id, handle, x, y, radius, detectedBy, first_ms, last_ms })),
      crossings: this.aivs.length <= 200 ? this.crossings() : [], bijection: this.bijection(), commands: this.commands.slice(-50),
    };
  }

  // ── its commands ──
  command(body) {
    if (body.command === 'close' || body.command === 'open') {
      if (!this.zone.sections.some((one) => one.name === body.section)) throw new Refusal(400, 'command.section', `There is no section ${body.section}.`);
      this.closed[body.command === 'close' ? 'add' : 'delete'](body.section);
      return { id: `c${++this.command_number}` };
    }
    if (body.command === 'go' || body.command === 'circulate') {
      const sent = this.aivs.filter((aiv) => body.vehicle === '*' || aiv.id === body.vehicle);
      if (sent.length === 0) throw new Refusal(404, 'command.vehicle', `There is no AIV ${body.vehicle}.`);
      for (const aiv of sent) aiv.mission = body.command === 'go' ? { kind: 'go', to: body.to, state: 'driving' } : { kind: 'circulate', loop: body.loop ?? null, state: 'driving' };
      return { id: `c${++this.command_number}` };
    }
    if (!operator_commands.includes(body.command)) throw new Refusal(400, 'command.unknown', `There is no command “${body.command}”. Send one of: ${operator_commands.join(', ')}.`);
    const wanted = body.vehicle === '*' ? this.aivs.map((aiv) => aiv.id) : (body.vehicles ?? [body.vehicle]);
    const chosen = wanted.map((id) => {
      const aiv = this.aivs.find((candidate) => candidate.id === id);
      if (!aiv) throw new Refusal(404, 'command.vehicle', `There is no AIV ${id}. Choose one of the list.`);
      return aiv;
    });
    this.traces.add(this.now, 'operator', 'AIV_Server', 'command', '', JSON.stringify(body), body);
    for (const aiv of chosen) {
      const command = { id: `c${++this.command_number}`, vehicle: aiv.id, command: body.command, state: 'issued', time_ms: this.now, accepted_ms: null, materialised_ms: null, reason: '' };
      this.commands.push(command);
      if (aiv.lost_at) Object.assign(command, { state: 'failed', reason: 'offline' });
      else if (body.command === 'stop') aiv.paused = true;
      else if (body.command === 'restart') Object.assign(aiv, { paused: false, imposed: null });
      else if (body.command !== 'cancel') aiv.imposed = body.command;
      if (chosen.length <= 12) this.traces.add(this.now + 2, 'AIV_Server', aiv.serial, 'instantActions', topic_of(aiv.id, 'instantActions'), `${body.command} ${command.id}`, action_of(aiv.id, this.now, body.command, command.id));
    }
    return { id: `c${this.command_number}` };
  }
  number_field(value, name) {
    if (typeof value !== 'number' || !Number.isFinite(value)) throw new Refusal(400, 'virtual_object.field', `“${name}” must be a number, in metres.`);
    return value;
  }
  inside(x, y) {
    const [x0, y0, x1, y1] = this.circuit.bounds;
    if (x < x0 - 0.5 || x > x1 + 0.5 || y < y0 - 0.5 || y > y1 + 0.5) throw new Refusal(400, 'virtual_object.position', `${x.toFixed(2)}, ${y.toFixed(2)} is off the zone. Choose a position on the map.`);
  }
  pose_from(body) {
    if (body.path !== undefined) {
      if (!Array.isArray(body.path) || body.path.length < 2) throw new Refusal(400, 'virtual_object.path', 'A walk needs at least two points.');
      body.path.forEach(([x, y]) => this.inside(this.number_field(x, 'path'), this.number_field(y, 'path')));
      return { x: body.path[0][0], y: body.path[0][1], path: body.path, speed: body.speed ?? 0.2, repeat: body.repeat ?? 'once', walked: 0, moving: true };
    }
    const x = this.number_field(body.x, 'x');
    const y = this.number_field(body.y, 'y');
    this.inside(x, y);
    return { x, y, speed: 0, moving: false };
  }
  add_virtual_object(body) {
    this.traces.add(this.now, 'operator', 'AIV_Server', 'command', '', `add ${body.kind}`, { command: 'add', virtualObject: body });
    if (body.kind === 'aiv') {
      const virtual = this.aivs.filter((aiv) => aiv.augmented);
      const number = this.next_number(virtual);
      const position = body.section !== undefined ? position_of(this.circuit, body.section, body.s ?? 0) : body.x !== undefined ? nearest_position(this.circuit, body.x, body.y) : this.room();
      if (!position) throw new Refusal(400, 'virtual_object.section', `There is no section ${body.section} of that length.`);
      const near = this.aivs.some((aiv) => aiv.track === position.track && Math.abs(aiv.track.pose_at(aiv.distance).x - position.track.pose_at(position.distance).x) < 0.15 && Math.abs(aiv.track.pose_at(aiv.distance).y - position.track.pose_at(position.distance).y) < 0.15);
      if (near) throw new Refusal(409, 'virtual_object.position', 'An AIV is already there. Choose a free position on the circuit.');
      const aiv = this.make_aiv(number, true, position);
      aiv.speed = 0;
      return { id: aiv.serial };
    }
    if (body.kind !== 'person' && body.kind !== 'obstacle') throw new Refusal(400, 'virtual_object.kind', 'A virtual object is of kind aiv, person or obstacle.');
    const list = this.virtualObjects.filter((virtualObject) => virtualObject.kind === body.kind);
    const id = `${body.kind === 'person' ? 'P' : 'O'}${this.next_number(list)}`;
    this.virtualObjects.push({ id, handle: this.handles.virtualObject++, kind: body.kind, heading: 0, radius: body.radius ?? (body.kind === 'person' ? 0.06 : 0.08), since_ms: this.now, ...this.pose_from(body) });
    return { id };
  }
  room() {
    const track = this.circuit.tracks[0];
    let best = { track, distance: 0, gap: -1 };
    for (let distance = 0; distance < track.lap; distance += 0.1) {
      const p = track.pose_at(distance);
      const gap = Math.min(...this.aivs.map((aiv) => Math.hypot(aiv.pose.x - p.x, aiv.pose.y - p.y)), 9);
      if (gap > best.gap) best = { track, distance, gap };
    }
    return best;
  }
  find_virtual_object(id) {
    const virtualObject = this.virtualObjects.find((candidate) => candidate.id === id);
    if (!virtualObject) throw new Refusal(404, 'virtual_object.not_found', `There is nothing called ${id} (any more).`);
    return virtualObject;
  }
  move_virtual_object(id, body) {
    const aiv = this.aivs.find((candidate) => candidate.augmented && (candidate.id === id || candidate.serial === id));
    if (aiv) {
      Object.assign(aiv, nearest_position(this.circuit, body.x, body.y));
      aiv.pose = aiv.track.pose_at(aiv.distance);
      return { id };
    }
    const virtualObject = this.find_virtual_object(id);
    const position = this.pose_from(body);
    if (!position.path) {
      delete virtualObject.path;
      delete virtualObject.repeat;
    }
    Object.assign(virtualObject, position);
    return { id };
  }
  remove_virtual_object(id) {
    const aiv = this.aivs.findIndex((candidate) => candidate.augmented && (candidate.id === id || candidate.serial === id));
    if (aiv >= 0) this.aivs.splice(aiv, 1);
    else this.virtualObjects.splice(this.virtualObjects.indexOf(this.find_virtual_object(id)), 1);
    return { removed: 1 };
  }
  remove_all() {
    const removed = this.virtualObjects.length + this.aivs.filter((aiv) => aiv.augmented).length;
    this.virtualObjects = [];
    this.aivs = this.aivs.filter((aiv) => !aiv.augmented);
    return { removed };
  }
  priorities(body) {
    for (const [id, priority] of Object.entries(body)) {
      const aiv = this.aivs.find((candidate) => candidate.id === id);
      if (!aiv) throw new Refusal(404, 'priorities.vehicle', `There is no AIV ${id}.`);
      if (!Number.isInteger(priority) || priority < 0 || priority > 999) throw new Refusal(400, 'priorities.range', 'A priority is a whole number from 0 to 999; higher goes first.');
      aiv.priority = priority;
    }
    return {};
  }
  add_box(body) {
    const x = this.number_field(body.x, 'x');
    const y = this.number_field(body.y, 'y');
    this.inside(x, y);
    const id = body.id ?? `box${this.next_number(this.boxes)}`;
    this.boxes.push({ id, x, y, radius: body.radius ?? 0.05 });
    return { id };
  }
  remove_box(id) {
    const at = this.boxes.findIndex((box) => box.id === id);
    if (at < 0) throw new Refusal(404, 'plant.none', `There is no physical obstacle ${id}.`);
    this.boxes.splice(at, 1);
    return { removed: 1 };
  }

  // ── the zone's edits ──
  tag_position(edit) {
    if (!Number.isInteger(edit.number) || edit.number < 1) throw new Refusal(400, 'edit.number', 'A tag has a whole number from 1 on.');
    const position = edit.section !== undefined ? position_of(this.circuit, edit.section, edit.s) : nearest_position(this.circuit, edit.x, edit.y);
    if (!position) throw new Refusal(400, 'edit.position', `Section ${edit.section} has no such position.`);
    if (position.off > 0.3) throw new Refusal(400, 'edit.position', `Tag ${edit.number} would lie ${position.off.toFixed(2)} m from every section; put it within 0.30 m of one.`);
    return { number: edit.number, track: position.track, distance: position.distance };
  }
  edit_zone(edit) {
    let tags = [...this.tags];
    for (const one of edit.addTags ?? []) {
      if (tags.some((tag) => tag.number === one.number)) throw new Refusal(409, 'edit.taken', `There is a tag ${one.number} already. Choose another number.`);
      tags.push(this.tag_position(one));
    }
    for (const one of edit.moveTags ?? []) {
      if (!tags.some((tag) => tag.number === one.number)) throw new Refusal(404, 'edit.none', `There is no tag ${one.number} to move.`);
      tags = tags.map((tag) => (tag.number === one.number ? this.tag_position(one) : tag));
    }
    for (const number of edit.removeTags ?? []) {
      if (!tags.some((tag) => tag.number === number)) throw new Refusal(404, 'edit.none', `There is no tag ${number} to remove.`);
      tags = tags.filter((tag) => tag.number !== number);
    }
    let { pitch } = this;
    const wanted = edit.beacons?.pitch ?? edit.beaconPitch;
    if (wanted !== undefined) {
      if (pitch === null) throw new Refusal(409, 'edit.beacons', 'This zone has no beacons.');
      if (!(wanted >= 0.05 && wanted <= 10)) throw new Refusal(400, 'edit.pitch', 'The beacons’ pitch must lie between 0.05 m and 10 m.');
      pitch = wanted;
    }
    this.undo_stack.push({ tags: this.tags, pitch: this.pitch });
    this.redo_stack = [];
    return this.zone_changed(tags, pitch);
  }
  zone_changed(tags, pitch) {
    Object.assign(this, { tags: tags.sort((a, b) => a.number - b.number), pitch, zone_cache: null, saved: false });
    return { revision: ++this.zone_revision };
  }
  undo() {
    const before = this.undo_stack.pop();
    if (!before) throw new Refusal(409, 'edit.undo', 'There is nothing to undo.');
    this.redo_stack.push({ tags: this.tags, pitch: this.pitch });
    return this.zone_changed(before.tags, before.pitch);
  }
  redo() {
    const after = this.redo_stack.pop();
    if (!after) throw new Refusal(409, 'edit.redo', 'There is nothing to redo.');
    this.undo_stack.push({ tags: this.tags, pitch: this.pitch });
    return this.zone_changed(after.tags, after.pitch);
  }

  // ── the clock ──
  set_clock(body) {
    if (this.clock.kind === 'wall') throw new Refusal(409, 'clock.wall', 'This run is on the wall’s clock, which cannot be stopped. Start one with virtual time instead.');
    if (body.speed !== undefined && !(body.speed >= 0.1 && body.speed <= 100)) throw new Refusal(400, 'clock.speed', 'The speed must lie between 0.1 and 100.');
    if (typeof body.running === 'boolean') this.clock.running = body.running;
    if (body.speed !== undefined) this.clock.speed = body.speed;
    return {};
  }
  step_clock(body) {
    if (this.clock.kind === 'wall') throw new Refusal(409, 'clock.wall', 'This run is on the wall’s clock, which cannot be stepped.');
    if (this.clock.running) throw new Refusal(409, 'clock.runs', 'Stop the clock first; then it can be stepped.');
    if (!(body.ms >= 1 && body.ms <= 10_000)) throw new Refusal(400, 'clock.step', 'A step is 1 to 10000 ms long.');
    this.step_by(body.ms);
    return {};
  }
}

const statistics = (p50, p99, n) => ({ count: n, mean: p50 * 1.05, p50, p99, max: p99 * 1.2 });
