// One run: executes a plan against real processes, and checks after each episode what must always hold.
import { execFile } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, readdirSync } from 'node:fs';
import { monitorEventLoopDelay } from 'node:perf_hooks';
import path from 'node:path';
import { Worker } from 'node:worker_threads';
import { alive, cosiva_binary, eventually, send_signal, sleep } from '../lib/platform.mjs';
import { CommandStates, differences_or_stopped, fleet_problem, in_store, missing_commands, repeated_commands, settings_after, unfinished_commands } from './checks.mjs';
import { idle_connections, send_large_body } from './clients.mjs';
import { begin_netem } from './netem.mjs';
import { Operators, serials_of } from './operators.mjs';
import { Site } from './site.mjs';
import { SmallDisk } from './small_disk.mjs';
import { Witness } from './witness.mjs';

const start_ms = 90_000; // of `up`, also on a busy machine
const recovery_ms = 10_000; // from the end of the faults until every AIV is ONLINE
const hold_after_recovery_ms = 4_000;
const drive_ms = 30_000;
const driven_m = 0.15;
const command_end_ms = 9_000; // a command fails by itself after 5 s
const disk_notice_ms = 3_000;
const durable_ms = 2_000; // of a working server on a working disk, from a Stop's response until its record is durable
const body_delay_ms = 2_000; // of any other request while a large body is evaluated
const orphans_end_ms = 8_000;

/** The time since then, as far as the server was observed: this program may have been delayed itself. */
function observed_ms(from_ms) {
  return Math.min(Date.now() - from_ms, 600);
}

export class Harness {
  /** @param disk_megabytes  60 kB/s are recorded with four AIVs, and large bodies, too */
  constructor(scope, { plan, seed, aivs, minutes, folder, print, disk_megabytes = 300 + Math.ceil(minutes * 12), violations_max = 20 }) {
    Object.assign(this, { scope, plan, seed, aivs, minutes, folder, print_line: print, disk_megabytes, violations_max });
    this.violations = [];
    this.counts = {};
    this.began_ms = Date.now();
    this.token = `${process.pid}-${seed}-${this.began_ms}`;
    this.lag = monitorEventLoopDelay({ resolution: 20 });
    this.lag.enable();
    this.server_faults = 0;
    this.pending = new Set();
    this.enders = new Set();
    this.stop_was_lost = new Set(); // serial numbers
    this.hindrances = { begun: 0, present: 0 };
  }

  print(text) {
    this.print_line(`${((Date.now() - this.began_ms) / 1_000).toFixed(2).padStart(8)}  ${text}`);
  }

  count(what) {
    this.counts[what] = (this.counts[what] ?? 0) + 1;
  }

  violation(what, evidence = {}) {
    const lag_ms = Math.round(this.lag.max / 1e6);
    this.violations.push({ at_s: (Date.now() - this.began_ms) / 1_000, what, evidence, lag_ms, episode: this.episode_name });
    this.print(`VIOLATION ${what}: ${JSON.stringify(evidence)} (episode ${this.episode_name}, largest lag of the harness ${lag_ms} ms)`);
  }

  // --- run ----------------------------------------------------------------------------------------------------------

  async run() {
    const store = path.join(this.folder, 'store');
    this.disk = SmallDisk.make(store, this.disk_megabytes, () => this.site?.pid('server'));
    this.store = store;
    this.print(`disk of the store: ${this.disk.kind}`);
    this.witness = new Witness((what, evidence) => this.violation(what, evidence));
    try {
      for (const [index, session] of this.plan.entries()) {
        if (this.time_is_up()) break;
        await this.run_session(session, index + 1);
      }
    } finally {
      clearInterval(this.poller);
      await this.witness.leave();
      this.end_all_faults();
      this.lag.disable();
      await this.reader?.terminate();
      await this.site?.up.kill_all();
      await this.site?.close();
      this.disk.remove();
    }
  }

  time_is_up() {
    return Date.now() - this.began_ms > this.minutes * 60_000 || this.violations.length >= this.violations_max;
  }

  async run_session({ topology, episodes }, number) {
    const folder = path.join(this.folder, `session${number}`);
    mkdirSync(folder);
    this.episode_name = `${number}.0`;
    this.print(`session ${number}: ${topology === 'proxy' ? "the harness's own broker behind a lossy proxy" : 'private broker of `up`'}`);
    this.witness.allow_teleports();
    this.site = await Site.start(this.scope, { folder, store: this.store, aivs: this.aivs, seed: this.seed, topology, token: this.token });
    this.operators ??= new Operators(() => this.site.url(), this.aivs);
    this.states ??= new CommandStates();
    this.begin_polling();
    await this.follow_broker();
    if (!(await this.recovered(start_ms, 'the start'))) throw new Error(`the platform does not start:\n${this.site.up.words.slice(-2000)}`);
    for (const [index, episode] of episodes.entries()) {
      if (this.time_is_up()) break;
      await this.run_episode(episode, `${number}.${index + 1}`);
    }
    await this.end_session();
  }

  async end_session() {
    clearInterval(this.poller);
    await this.witness.leave();
    const ended = await this.site.end();
    if (!ended) this.violation('`up` did not end within 15 s of SIGINT', { output: this.site.up.words.slice(-500) });
    else this.print(`up has ended: ${ended.signal ?? `exit ${ended.code}`}`);
    const left = this.site.processes();
    if (left.length > 0) this.violation('processes are left', left.map(({ pid, argv }) => `${pid} ${argv.slice(0, 2).join(' ')}`));
    await this.site.up.kill_all();
    await this.site.close();
    await this.check_store('the end of the session');
  }

  begin_polling() {
    this.slowest_ms = 0;
    let busy = false;
    clearInterval(this.poller);
    this.poller = setInterval(async () => {
      if (busy) return;
      busy = true;
      try {
        this.states.accept(await this.operators.get('snapshot'));
      } catch {
        // A server that is dead, frozen or starting.
      }
      busy = false;
    }, 250);
  }

  async follow_broker() {
    await this.witness.follow(await this.site.broker_port());
  }

  // --- episodes -----------------------------------------------------------------------------------------------------

  async run_episode({ kind, actions }, name) {
    this.episode_name = name;
    this.lag.reset();
    this.count(`episode ${kind}`);
    this.print(`episode ${name}: ${kind}`);
    const began_ms = Date.now();
    this.episode_log_from = this.operators.log.length;
    for (const action of actions) {
      await sleep(Math.max(0, began_ms + action.at_ms - Date.now()));
      const done = this.act(action).catch((error) => this.print(`${action.what} was not possible: ${error.message}`));
      this.pending.add(done);
      done.finally(() => this.pending.delete(done));
    }
    while (this.pending.size > 0) await Promise.all([...this.pending]);
    this.end_all_faults();
    this.print('faults have ended');
    await this.check_after_episode();
  }

  end_all_faults() {
    for (const end of [...this.enders]) end();
    this.enders.clear();
    this.site?.thaw_all();
    this.site?.proxy?.end_faults();
    this.disk?.free();
  }

  /** Ends a fault after its time, or with the episode, whichever is first. */
  async lasting(ms, end) {
    const once = () => this.enders.delete(once) && end();
    this.enders.add(once);
    await sleep(ms);
    once();
  }

  act(action) {
    this.count(action.what === 'kill' || action.what === 'freeze' ? `${action.what} ${action.part.replace(/\d+/, '')}` : action.what === 'net' ? `net ${action.mode}` : action.what);
    const { at_ms: _, ...shown } = action;
    if (action.what !== 'command') this.print(JSON.stringify(shown));
    return {
      kill: () => this.kill(action),
      freeze: () => this.freeze(action),
      net: () => this.lasting(action.ms, this.site.proxy.begin(action)),
      netem: () => this.lasting(action.ms, begin_netem(action)),
      idle: () => this.idle(action),
      body: () => this.large_body(action),
      fill: () => this.fill(action),
      command: () => this.command(action.operator, action.body),
      command_then_kill: () => this.command_then_kill(action),
    }[action.what]();
  }

  // --- faults -------------------------------------------------------------------------------------------------------

  async kill({ part, examine, back_ms }) {
    if (part === 'server' || part === 'up') ++this.server_faults;
    if (part === 'up') return this.kill_up(back_ms);
    if (part === 'plant') this.witness.allow_teleports();
    if (part === 'server' && examine) return this.kill_server_and_examine();
    if (!(await this.site.kill(part))) return this.print(`${part} is not running`);
    if (part === 'broker' && this.site.own_broker) {
      await sleep(back_ms);
      await this.site.start_own_broker(this.site.own_broker.port);
    }
    await this.verify_store(`the death of ${part}`);
  }

  /** Nothing starts the server again while the store is read as the kill left it. */
  async kill_server_and_examine() {
    const up = this.site.freeze('up');
    if (!(await this.site.kill('server'))) this.print('server is not running');
    await this.check_store('the death of the server');
    if (up) this.site.thaw(up);
  }

  async kill_up(back_ms) {
    this.site.thaw_all();
    this.witness.allow_teleports();
    const former = this.site.processes();
    await this.site.kill('up');
    await sleep(back_ms);
    await this.site.start_up();
    const left = () => former.filter(({ pid }) => alive(pid));
    await eventually('the parts of the killed `up` end', () => left().length === 0, { within_ms: orphans_end_ms }).catch(() =>
      this.violation('parts of the killed `up` are left', left().map(({ pid, argv }) => `${pid} ${argv.slice(0, 2).join(' ')}`)),
    );
    await this.follow_broker().catch(() => {});
    if (!this.site.up.gone) return;
    this.violation('`up` did not start again on its store', { output: this.site.up.words.slice(-700) });
    await this.site.start_up();
    await this.follow_broker();
  }

  async freeze({ part, ms }) {
    if (part === 'plant') this.witness.allow_teleports(); // a plant that hangs is killed
    if (part === 'server' || part === 'up') ++this.server_faults;
    const pid = this.site.freeze(part);
    if (!pid) return this.print(`${part} is not running`);
    const unhinder = part === 'server' ? this.hinder() : () => {};
    await this.lasting(ms, () => this.site.thaw(pid));
    unhinder();
  }

  async idle({ count, ms }) {
    const close = idle_connections(this.site.port, count);
    const unhinder = this.hinder();
    await this.lasting(ms, close);
    unhinder();
  }

  async large_body({ megabytes, path: where }) {
    const pid = this.site.pid('server');
    const ours = this.server_faults;
    const began_ms = Date.now();
    const sent = send_large_body(this.site.port, where, megabytes);
    const slowest_ms = await this.slowest_request_until(sent);
    const status = await sent;
    this.print(`${megabytes} MB to ${where}: ${status} after ${Date.now() - began_ms} ms; other requests took ${slowest_ms} ms at most`);
    if (slowest_ms > body_delay_ms && this.server_faults === ours) this.violation('a large body delayed other requests', { where, status, slowest_ms });
    if (status >= 200 && status < 300) this.violation('a meaningless body was accepted', { where, status });
    if (pid && this.site.pid('server') !== pid && this.server_faults === ours) this.violation('the server was ended by a large body', { where, status, ms: Date.now() - began_ms, up: this.site.up.words.slice(-300) });
    if (status === 'LATE' && this.site.pid('server') === pid && !this.site.frozen.has(pid)) this.violation('no response to a large body within a minute', { where });
  }

  /** How long a request took at most until the promise was settled, less the delays by this program and other faults. */
  async slowest_request_until(promise) {
    let settled = false;
    promise.finally(() => (settled = true));
    let slowest_ms = 0;
    while (!settled) {
      const lag = monitorEventLoopDelay({ resolution: 5 });
      lag.enable();
      const began_ms = Date.now();
      const { begun } = this.hindrances;
      await this.operators.get('snapshot', 5_000).catch(() => {});
      lag.disable();
      const hindered = this.hindrances.present > 0 || this.hindrances.begun !== begun;
      if (!hindered) slowest_ms = Math.max(slowest_ms, Math.round(Date.now() - began_ms - lag.max / 1e6));
      await sleep(50);
    }
    return slowest_ms;
  }

  /** A fault begins that delays the server's responses. Returns the function that ends it. */
  hinder() {
    ++this.hindrances.begun;
    ++this.hindrances.present;
    return () => --this.hindrances.present;
  }

  async command(operator, body) {
    const server = this.site.pid('server');
    const entry_of = this.operators.give(operator, body);
    if (body.command === 'restart') for (const serial of serials_of(body, this.aivs)) this.witness.release(Number(serial.slice(3)));
    const entry = await entry_of;
    this.print(`operator ${operator}: ${body.command} ${body.vehicle}${body.speed ? ` ${body.speed}` : ''}: ${entry.outcome} ${entry.status ?? entry.reason} ${entry.id ?? entry.error?.code ?? ''}`);
    if (entry.outcome === 'confirmed' && body.command === 'stop') this.accept_stop(entry, server);
    if (entry.status === 503 && !entry.error?.message) this.violation('503 without a reason', entry);
    return entry;
  }

  accept_stop(entry, server) {
    if (!entry.states_durable) this.violation('the response to a Stop does not state whether it is durable', entry);
    entry.server = server ?? this.site.pid('server');
    if (!entry.durable) this.follow_durability(entry);
    this.hold(entry);
  }

  /** A restart that may still take effect makes the outcome open; the store decides then. */
  hold(entry) {
    const lost = () => !entry.durable && this.site.pid('server') !== entry.server;
    for (const serial of serials_of(entry.body, this.aivs)) {
      if (this.operators.restart_is_open(serial) || this.restarted_since(serial, entry)) continue;
      this.witness.hold(Number(serial.slice(3)), `${entry.id} stop ${entry.body.vehicle}`, { lost });
    }
  }

  /** A Stop must become durable while its server and the disk work. What the server was prevented from does not count. */
  async follow_durability(entry) {
    const { site } = this;
    let worked_ms = 0;
    let hindered = false;
    for (let before_ms = Date.now(); this.site === site && site.pid('server') === entry.server && worked_ms < durable_ms; ) {
      const shown = await this.operators.get(`commands/${entry.id}`, 500).catch(() => null);
      if (shown?.durable) {
        entry.durable = true;
        if (!hindered) this.slowest_durable_ms = Math.max(this.slowest_durable_ms ?? 0, worked_ms + observed_ms(before_ms));
        return;
      }
      entry.durable_reason = shown?.reason ?? entry.durable_reason;
      if (this.disk.full || site.frozen.has(entry.server)) {
        hindered = true;
        worked_ms = 0;
      } else worked_ms += observed_ms(before_ms);
      before_ms = Date.now();
      await sleep(25);
    }
    if (worked_ms >= durable_ms) this.violation(`a Stop is not durable ${durable_ms / 1_000} s after its response although the disk works`, { id: entry.id, reason: entry.durable_reason });
  }

  /** Of the Stops that were not durable when their server ended: which the store contains, and which are lost. */
  settle_stops(commands) {
    const server = this.site.pid('server');
    for (const entry of this.operators.log) {
      if (entry.outcome !== 'confirmed' || entry.durable !== false || entry.lost || entry.server === server) continue;
      entry.durable = in_store(entry, commands);
      entry.lost = !entry.durable;
      if (!entry.lost) continue;
      this.count('Stop lost before it was durable');
      this.print(`Stop ${entry.id} was not durable when the server ended, and is not in the store`);
      for (const serial of serials_of(entry.body, this.aivs)) this.stop_was_lost.add(serial);
    }
  }

  restarted_since(serial, stop) {
    return this.operators.concerning(serial).some(({ body, done_ms, outcome }) => body.command === 'restart' && outcome !== 'refused' && done_ms >= stop.sent_ms);
  }

  /** The process is found before, so that the kill follows the response within `after_ms`. */
  async command_then_kill({ operator, body, after_ms }) {
    const server = this.site.pid('server');
    const entry = await this.command(operator, body);
    if (entry.outcome !== 'confirmed' || !server) return;
    await sleep(Math.max(0, entry.done_ms + after_ms - Date.now()));
    ++this.server_faults;
    const up = this.site.freeze('up', this.site.up.pid);
    send_signal(server, 'SIGKILL');
    const dead_ms = Date.now();
    await eventually('server is dead', () => !alive(server), { within_ms: 5_000, every_ms: 5 });
    await this.check_store(`the death of the server ${dead_ms - entry.done_ms} ms after a response`);
    if (up) this.site.thaw(up);
  }

  // --- full disk ----------------------------------------------------------------------------------------------------

  async fill({ ms, strict }) {
    if (!this.disk.can_fill) return this.print('the disk cannot be filled here');
    await this.disk.fill();
    const until_ms = Date.now() + ms;
    const ended = this.lasting(ms, () => this.disk.free());
    if (strict) await this.check_full_disk(until_ms);
    await ended;
    this.print('the disk has space again');
    if (strict) await this.check_freed_disk();
  }

  async check_full_disk(until_ms) {
    const noticed = await this.repeated_until(Math.min(until_ms, Date.now() + disk_notice_ms), { command: 'limit', vehicle: 'CoSiVA/AIV1', speed: 0.3 }, ({ status }) => status === 503);
    if (!noticed) return this.violation('commands are not refused with 503 while the disk is full', { last: this.operators.log.at(-1) });
    if (!/\S/.test(noticed.error?.message ?? '')) this.violation('a refusal without a reason', noticed);
    this.print(`refused: ${noticed.error?.code}: ${noticed.error?.message}`);
    const stop = await this.command('A', { command: 'stop', vehicle: '*' });
    if (stop.status !== 202) this.violation('a Stop was not accepted while the disk is full', { status: stop.status, error: stop.error, reason: stop.reason });
    stop.disk_full = true;
  }

  async check_freed_disk() {
    const accepted = await this.repeated_until(Date.now() + disk_notice_ms, { command: 'limit', vehicle: 'CoSiVA/AIV1', speed: 0.31 }, ({ status }) => status === 202);
    if (!accepted) this.violation('commands are refused although the disk has space again', { last: this.operators.log.at(-1) });
  }

  async repeated_until(end_ms, body, good) {
    while (Date.now() < end_ms) {
      const entry = await this.command('A', body);
      if (good(entry)) return entry;
      await sleep(200);
    }
    return null;
  }

  // --- checks -------------------------------------------------------------------------------------------------------

  /** `cosiva journal verify` on the store as it is; its output. */
  async verify_store(when) {
    const verify = () =>
      new Promise((resolve) => {
        const options = { encoding: 'utf8', timeout: 60_000 };
        execFile(cosiva_binary(), ['journal', 'verify', this.store], options, (error, stdout, stderr) => resolve({ status: error ? (error.code ?? error.signal) : 0, output: stdout + stderr }));
      });
    let { status, output } = await verify();
    if (status !== 0 && this.site.pid('server')) {
      // The server may have replaced a segment during the reading.
      this.print(`\`journal verify\` of a running server's store: ${output.trim().slice(-300)}; once more`);
      ({ status, output } = await verify());
    }
    if (status !== 0) this.violation(`\`journal verify\` fails after ${when}`, { status, output: output.slice(-500) });
    return output;
  }

  /** Both readings of the store, which must agree; what both contain, or null where it is damaged. */
  async check_store(when) {
    if (!existsSync(this.store) || !readdirSync(this.store).some((name) => name.endsWith('.segment'))) return null;
    const own = await this.read_store();
    if (own.damage) this.violation(`the store is damaged after ${when}`, { damage: own.damage });
    const verified = await this.verify_store(when);
    const server_is_dead = !this.site.pid('server');
    if (server_is_dead && !own.damage && !verified.includes(own.hash)) this.violation('two readings of the store differ', { own: own.hash, verified });
    if (own.damage) return null;
    if (server_is_dead) this.check_confirmed(own, when);
    return own;
  }

  /** The harness's own reading. One at a time, since a reading continues the one before. */
  read_store() {
    this.reader ??= new Worker(new URL('./store_worker.mjs', import.meta.url), { workerData: { folder: this.store } });
    const before = this.reading ?? Promise.resolve();
    this.reading = before.then(
      () =>
        new Promise((resolve) => {
          this.reader.once('message', resolve);
          this.reader.postMessage('read');
        }),
    );
    return this.reading;
  }

  check_confirmed({ commands }, when) {
    this.settle_stops(commands);
    const log = this.operators.log.filter(({ missed }) => !missed);
    const missing = missing_commands(log, commands);
    for (const entry of missing) entry.missed = true;
    if (missing.length > 0) {
      const shown = missing.map(({ operator, body, id, sent_ms, done_ms, disk_full }) => ({ operator, body, id, confirmed: new Date(done_ms).toISOString(), ms_before: Date.now() - done_ms, took_ms: done_ms - sent_ms, disk_full }));
      this.violation('confirmed commands are not in the store', { when, commands: shown });
    }
    for (const entry of repeated_commands(log, commands)) {
      if (entry.repeated) continue;
      entry.repeated = true;
      this.print(`the store executes command ${entry.id} (${JSON.stringify(entry.body)}) more than once`);
    }
  }

  async check_after_episode() {
    const recovered = await this.recovered(recovery_ms, 'the faults');
    await sleep(hold_after_recovery_ms);
    const own = await this.check_store(`episode ${this.episode_name}`);
    if (own) {
      this.check_confirmed(own, `episode ${this.episode_name}`);
      if (recovered) await this.check_settings(own.commands);
    }
    await this.check_restart();
  }

  /** Waits until every AIV is ONLINE with exactly one twin. */
  async recovered(within_ms, what) {
    const began_ms = Date.now();
    let problem = '';
    while (Date.now() - began_ms < within_ms) {
      try {
        problem = fleet_problem(await this.operators.get('snapshot'), await this.operators.get('bijection'), this.aivs);
      } catch (error) {
        problem = `no response of the server: ${error.cause?.code ?? error.message}`;
      }
      if (problem === '') {
        this.print(`every AIV is online with its twin ${((Date.now() - began_ms) / 1_000).toFixed(1)} s after ${what}`);
        return true;
      }
      await sleep(100);
    }
    this.violation(`not every AIV is online with exactly one twin within ${within_ms / 1_000} s after ${what}`, { problem, up: this.site.up.words.slice(-600) });
    // What takes longer still has to come.
    const late = await eventually('', async () => fleet_problem(await this.operators.get('snapshot'), await this.operators.get('bijection'), this.aivs) === '', { within_ms: 60_000, every_ms: 300 }).catch(() => false);
    this.print(late ? `recovered after ${((Date.now() - began_ms) / 1_000).toFixed(1)} s` : 'not recovered within another minute');
    return false;
  }

  /** Each vehicle obeys the last commands in the store's order, and every confirmed command has an end. */
  async check_settings(commands) {
    const settings = settings_after(commands, this.aivs);
    let found = [];
    let excused = [];
    const end_ms = Date.now() + command_end_ms;
    for (;;) {
      try {
        const snapshot = await this.operators.get('snapshot');
        this.states.accept(snapshot);
        found = snapshot.aivs.filter(({ augmented }) => !augmented).map((aiv) => ({ vehicle: aiv.id, wanted: settings.get(`AIV${aiv.number}`), differences: differences_or_stopped(aiv, settings.get(`AIV${aiv.number}`), this.stop_was_lost.has(`AIV${aiv.number}`)) }));
        found = found.filter(({ differences: some }) => some.length > 0);
        excused = found.filter(({ vehicle }) => this.failed_with_reason(vehicle, commands));
        found = found.filter((one) => !excused.includes(one));
        const unfinished = unfinished_commands(this.operators, this.states, snapshot, settings, this.stop_was_lost);
        if (found.length === 0 && unfinished.length === 0) break;
        if (Date.now() > end_ms) {
          if (found.length > 0) this.violation("vehicles do not obey the last commands in the store's order", found);
          if (unfinished.length > 0) this.violation('confirmed commands have no end', unfinished);
          break;
        }
      } catch {
        if (Date.now() > end_ms) return this.violation('no snapshot although all faults have ended');
      }
      await sleep(250);
    }
    for (const { vehicle, wanted, differences: some } of excused) {
      const reason = this.failed_with_reason(vehicle, commands);
      this.count('command that failed');
      this.print(`NOTE ${vehicle} differs from ${JSON.stringify(wanted)} (${some}), and the snapshot lists why: ${reason}`);
    }
    for (const entry of this.operators.log) entry.checked = true;
    for (const [serial, { stopped }] of settings) {
      const state = this.witness.states.get(serial);
      if (state && state.paused !== undefined && state.paused !== stopped) this.print(`the last state of ${serial} on the broker: paused ${state.paused}, by the store ${stopped}`);
    }
  }

  /** The reason for which the snapshot lists one of the vehicle's last commands as failed, other than a newer command; or ''. */
  failed_with_reason(vehicle, commands) {
    const serial = vehicle.split('/')[1];
    const last_ms = Math.max(...commands.filter(({ json }) => json.vehicle && serials_of(json, this.aivs).includes(serial)).map(({ accepted_ms }) => accepted_ms));
    const failed = [...this.states.seen.values()].filter(({ vehicle: of, state, reason, time_ms }) => (of === vehicle || of === '*') && state === 'failed' && !/^superseded/.test(reason) && time_ms > last_ms - 1_000);
    return failed.map(({ id, command, reason }) => `${id} ${command}: ${reason}`).join('; ');
  }

  async check_restart() {
    for (const body of [{ command: 'circulate', vehicle: '*' }, { command: 'restart', vehicle: '*' }]) {
      const accepted = await this.repeated_until(Date.now() + 5_000, body, ({ status }) => status === 202);
      if (!accepted) return this.violation(`${body.command} is not accepted although all faults have ended`, { last: this.operators.log.at(-1) });
    }
    this.stop_was_lost.clear();
    const before = this.witness.distances();
    const waiting = () => [...this.witness.distances()].filter(([number, distance]) => distance - (before.get(number) ?? 0) < driven_m).map(([number]) => `AIV${number}`);
    const began_ms = Date.now();
    try {
      await eventually('every AIV drives', () => this.witness.vehicles.size === this.aivs && waiting().length === 0, { within_ms: drive_ms, every_ms: 100 });
      this.print(`every AIV drives ${((Date.now() - began_ms) / 1_000).toFixed(1)} s after restart`);
    } catch {
      const snapshot = await this.operators.get('snapshot').catch(() => null);
      const known = snapshot?.aivs.map(({ id, status, paused, connection, errors, waitsFor, fieldViolation, offRoute, section, s, orderId, mission, speedLimit }) => ({ id, status, paused, connection, errors, waitsFor, fieldViolation, offRoute, section, s, orderId, mission, speedLimit }));
      this.violation(`not every AIV drives within ${drive_ms / 1_000} s after restart`, { waiting: waiting(), known, crossings: snapshot?.crossings, deadlocks: snapshot?.deadlocks?.open });
    }
  }

  /** The last lines of the parts' logs, for the report of a violation. */
  log_tails(bytes = 1_500) {
    const folders = readdirSync(this.folder).filter((name) => name.startsWith('session')).map((name) => path.join(this.folder, name, 'log')).filter((folder) => existsSync(folder));
    return folders.flatMap((folder) => readdirSync(folder).filter((name) => name.endsWith('.log')).map((name) => `${path.join(folder, name)}\n${readFileSync(path.join(folder, name), 'utf8').slice(-bytes)}`));
  }
}

