// The schedule of a run: what is injected when, drawn from a seed and nothing else.
import { Random } from './random.mjs';

const faults_ms = 8_000; // of an episode: faults begin within this time
const freeze_ms = [100, 8_000];
const episode_kinds = ['stop', 'free', 'disk'];
export const setting_commands = ['slow', 'medium', 'fast', 'limit'];

function vehicle_name(number) {
  return `CoSiVA/AIV${number}`;
}

/** Draws the episodes of one session, in which one `cosiva up` (and its successors on the same store) is running. */
class Draw {
  constructor(random, { aivs, netem, topology }) {
    Object.assign(this, { random, aivs, netem, topology });
  }

  part() {
    const aiv = `aiv${this.random.integer(1, this.aivs)}`;
    return this.random.one_of(['server', 'server', 'broker', 'plant', aiv, aiv]);
  }

  client() {
    return this.random.one_of(['*', 'server', 'plant', `aiv${this.random.integer(1, this.aivs)}`]);
  }

  kill(part) {
    return { what: 'kill', part, examine: this.random.chance(0.5), back_ms: this.random.spread(50, 3_000) };
  }

  freeze(part) {
    return { what: 'freeze', part, ms: this.random.spread(...freeze_ms) };
  }

  net() {
    const mode = this.random.one_of(['delay', 'stall', 'cut', 'half_open', 'refuse']);
    const ms = mode === 'cut' ? 0 : this.random.spread(200, 6_000);
    return { what: 'net', mode, client: this.client(), ms, ...(mode === 'delay' ? { delay_ms: this.random.spread(10, 1_500) } : {}) };
  }

  netem_fault() {
    return { what: 'netem', delay_ms: this.random.spread(1, 200), loss_percent: this.random.integer(0, 30), ms: this.random.spread(500, 6_000) };
  }

  clients() {
    return this.random.chance(0.5) ? { what: 'idle', count: this.random.integer(50, 300), ms: this.random.integer(2_000, 6_000) } : { what: 'body', megabytes: 60, path: this.random.one_of(['commands', 'zone/switch']) };
  }

  /** A setting of a vehicle's speed, or a mission: a command that does not end a Stop. */
  command() {
    const name = this.random.one_of([...setting_commands, 'limit', 'circulate']);
    const vehicle = this.random.chance(0.2) ? '*' : vehicle_name(this.random.integer(1, this.aivs));
    // Four decimals, so that almost every limit differs from the others.
    return { command: name, vehicle, ...(name === 'limit' ? { speed: this.random.integer(1_000, 4_000) / 10_000 } : {}) };
  }

  stop_or_restart() {
    return { command: this.random.one_of(['stop', 'restart']), vehicle: this.random.chance(0.3) ? '*' : vehicle_name(this.random.integer(1, this.aivs)) };
  }

  /** @param count  of faults; no two concern the same part, and `up` is killed once at most */
  faults(count, kinds) {
    const chosen = [];
    const parts = new Set();
    while (chosen.length < count) {
      const kind = this.random.one_of(kinds);
      let fault;
      if (kind === 'kill' || kind === 'freeze') {
        const part = this.part();
        if (parts.has(part)) continue;
        parts.add(part);
        fault = kind === 'kill' ? this.kill(part) : this.freeze(part);
      } else if (kind === 'up') {
        if (parts.has('up')) continue;
        parts.add('up');
        fault = this.random.chance(0.6) ? { what: 'kill', part: 'up', examine: false, back_ms: this.random.spread(1, 2_000) } : this.freeze('up');
      } else if (kind === 'net') {
        fault = this.net();
      } else if (kind === 'netem') {
        fault = this.netem_fault();
      } else {
        fault = this.clients();
      }
      chosen.push({ at_ms: this.random.integer(0, faults_ms - 1_000), ...fault });
    }
    return chosen;
  }

  kinds() {
    return ['kill', 'kill', 'kill', 'freeze', 'freeze', 'up', 'clients', ...(this.topology === 'proxy' ? ['net', 'net', 'net'] : []), ...(this.netem ? ['netem'] : [])];
  }

  stop_episode() {
    const at_ms = this.random.integer(500, 5_000);
    const stop = { command: 'stop', vehicle: this.random.chance(0.7) ? '*' : vehicle_name(this.random.integer(1, this.aivs)) };
    const actions = this.faults(this.random.integer(2, 4), this.kinds());
    // Half of all Stops meet a vehicle or the server at a bad time: dead before it, or killed by its response.
    if (this.random.chance(0.25)) actions.push({ at_ms: Math.max(0, at_ms - this.random.integer(50, 1_500)), ...this.kill(`aiv${this.random.integer(1, this.aivs)}`) });
    if (this.random.chance(0.25)) actions.push({ at_ms, what: 'command_then_kill', operator: 'A', body: stop, after_ms: this.random.spread(1, 200) - 1 });
    else actions.push({ at_ms, what: 'command', operator: 'A', body: stop });
    for (let i = this.random.integer(0, 4); i > 0; --i) actions.push({ at_ms: this.random.integer(at_ms, faults_ms), what: 'command', operator: 'B', body: this.command() });
    return actions;
  }

  free_episode() {
    const actions = this.faults(this.random.integer(1, 3), this.kinds());
    for (let at_ms = this.random.integer(0, 1_000); at_ms < faults_ms; at_ms += this.random.integer(200, 1_500)) {
      if (this.random.chance(0.3)) {
        // Two operators contradict each other within a few milliseconds.
        const first = this.stop_or_restart();
        const second = { ...first, command: first.command === 'stop' ? 'restart' : 'stop' };
        actions.push({ at_ms, what: 'command', operator: 'A', body: first });
        actions.push({ at_ms: at_ms + this.random.integer(0, 5), what: 'command', operator: 'B', body: second });
      } else {
        actions.push({ at_ms, what: 'command', operator: this.random.one_of(['A', 'B']), body: this.random.chance(0.3) ? this.stop_or_restart() : this.command() });
      }
    }
    if (this.random.chance(0.4)) actions.push({ at_ms: this.random.integer(0, faults_ms), what: 'command_then_kill', operator: 'A', body: this.command(), after_ms: this.random.spread(1, 50) - 1 });
    return actions;
  }

  /** Alone, what must hold while the disk is full is checked strictly; among other faults, only what must hold afterwards. */
  disk_episode() {
    const alone = this.random.chance(0.6);
    const fill = { at_ms: this.random.integer(300, 1_500), what: 'fill', strict: alone, ms: this.random.integer(4_000, 6_000) };
    if (alone) return [fill];
    const actions = [fill, ...this.faults(this.random.integer(1, 2), ['kill', 'freeze'])];
    if (this.random.chance(0.3)) {
      const at_ms = fill.at_ms + this.random.integer(300, 1_500);
      actions.push({ at_ms, what: 'command', operator: 'A', body: { command: 'stop', vehicle: '*' } });
      actions.push({ at_ms: at_ms + this.random.integer(0, 1_500), ...this.kill(this.random.one_of(['server', 'up'])) });
    }
    for (let i = 4; i > 0; --i) actions.push({ at_ms: this.random.integer(0, faults_ms), what: 'command', operator: 'B', body: this.random.chance(0.3) ? this.stop_or_restart() : this.command() });
    return actions;
  }

  episode(kind) {
    const actions = { stop: () => this.stop_episode(), free: () => this.free_episode(), disk: () => this.disk_episode() }[kind]();
    return { kind, actions: actions.sort((a, b) => a.at_ms - b.at_ms) };
  }
}

/**
 * @returns {{topology: 'private'|'proxy', episodes: {kind: string, actions: object[]}[]}[]} sessions; more than fit into
 * `minutes`, since recovery takes a different time in each run
 */
export function make_plan({ seed, minutes, aivs, disk = true, netem = false }) {
  const random = new Random(seed);
  const kinds = disk ? episode_kinds : episode_kinds.filter((kind) => kind !== 'disk');
  const sessions = [];
  let bag = [];
  let topology = random.one_of(['private', 'proxy']);
  for (let left = Math.ceil((minutes * 60_000) / 12_000) + 1; left > 0; ) {
    const draw = new Draw(random, { aivs, netem, topology });
    const episodes = [];
    for (let count = Math.min(left, random.integer(3, 5)); count > 0; --count, --left) {
      if (bag.length === 0) bag = random.shuffled(kinds);
      episodes.push(draw.episode(bag.pop()));
    }
    sessions.push({ topology, episodes });
    topology = topology === 'private' ? 'proxy' : 'private';
  }
  return sessions;
}
