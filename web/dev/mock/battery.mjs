// A made-up battery test by hand, of the first two vehicles: each waits for its battery, and three minutes after the last
// is in both are at the floor. Then it begins again.
const run_ms = 180_000;
const floor = 20;
const names = ['red', 'blue'];
const pause_ms = 60_000;
const points_max = 240;

export class MockBatteries {
  constructor(world) {
    this.world = world;
    this.curves = new Map();
    this.begin();
  }

  begin() {
    this.began = this.world.now;
    this.ended = null;
    this.slots = names.map((battery, i) => ({ number: i + 1, battery, phase: i === 0 ? 'changing' : 'ready', since: this.world.now, reason: '', started: null, at: null }));
  }

  vehicle(slot) {
    return this.world.aivs.find((aiv) => aiv.number === slot.number && !aiv.augmented);
  }

  /** @returns why not, as [status, code, sentence]; undefined: it is taken */
  ready({ vehicle, battery, charge }) {
    const slot = this.slots.find((one) => one.phase === 'changing' && this.vehicle(one)?.id === vehicle);
    if (!battery) return [400, 'battery.battery', "give the battery's own id, of 1 to 64 bytes"];
    if (!slot) return [409, 'battery.not_requested', `no test wants a battery changed in '${vehicle}' now`];
    if ((charge ?? 100) < 97) slot.reason = `it is not full: ${charge} %`;
    else Object.assign(slot, { phase: 'ready', battery, reason: '' });
    if (this.slots.every((one) => one.phase === 'ready')) for (const one of this.slots) Object.assign(one, { phase: 'running', started: this.world.now });
    return undefined;
  }

  curve(id) {
    return this.curves.get(id);
  }

  /** Each vehicle's battery at present, and a point of its curve each second. */
  advance() {
    const now = this.world.now;
    for (const slot of this.slots) {
      const aiv = this.vehicle(slot);
      if (!aiv || slot.phase !== 'running') continue;
      // Not all alike: the second lasts longer.
      const gone = (now - slot.started) / (run_ms * (1 + 0.05 * slot.number));
      aiv.battery = Math.max(floor, 100 - (100 - floor) * gone);
      if (gone >= 1) Object.assign(slot, { phase: 'ended', at: now });
    }
    if (this.ended === null && this.slots.every((slot) => slot.phase === 'ended')) this.ended = now;
    if (this.ended !== null && now - this.ended > pause_ms) this.begin();
    for (const aiv of this.world.aivs.slice(0, 50)) {
      const points = this.curves.get(aiv.id) ?? [];
      if (now - (points.at(-1)?.[0] ?? 0) >= 1_000) this.curves.set(aiv.id, [...points.slice(1 - points_max), [now, aiv.battery, 11.4 + aiv.battery / 100, 24 + (aiv.number % 5)]]);
    }
  }

  snapshot() {
    this.advance();
    const now = this.world.now;
    const there = this.slots.filter((slot) => this.vehicle(slot));
    const running = there.every((slot) => slot.phase === 'running' || slot.phase === 'ended');
    const progress = there.reduce((sum, slot) => sum + (slot.phase === 'ended' ? 1 : slot.started === null ? 0 : (100 - this.vehicle(slot).battery) / (100 - floor)), 0) / Math.max(1, there.length);
    const wanted = there.filter((slot) => slot.phase === 'changing');
    return {
      changes: wanted.map((slot) => ({ vehicle: this.vehicle(slot).id, battery: slot.battery, run: 1, reason: slot.reason, since_ms: slot.since })),
      test: {
        began_ms: this.began, received_ms: this.ended ?? now, run: 1, runs: 1, floor, progress,
        expectedEnd_ms: running && this.ended === null && progress > 0.01 ? there[0].started + run_ms * 1.1 : null, done: this.ended !== null,
        vehicles: there.map((slot) => ({
          id: this.vehicle(slot).id, battery: slot.battery, phase: slot.phase, stop: slot.phase === 'ended' ? 'floor' : null,
          autonomy_s: slot.started === null ? 0 : ((slot.at ?? now) - slot.started) / 1000, charge: slot.phase === 'changing' ? null : slot.started === null ? 100 : this.vehicle(slot).battery,
        })),
      },
    };
  }
}
