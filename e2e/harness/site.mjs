// One platform: `cosiva up` on a store, with a private broker or behind a lossy proxy, its processes, and how they are
// killed, frozen and started again.
import { appendFileSync, mkdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { alive, all_processes, cosiva_binary, descendants, eventually, free_port, hopeless, listening_ports, Program, send_signal, start_broker, within } from '../lib/platform.mjs';
import { LossyProxy } from './lossy_proxy.mjs';

const end_ms = 15_000;

export class Site {
  /** @param scope  has after(), as a test; its folder is kept by the caller */
  static async start(scope, { folder, store, aivs, seed, topology, token, log }) {
    const site = new Site();
    Object.assign(site, { scope, folder, store, aivs, seed, topology, token, log, frozen: new Map(), starts: 0, text: '' });
    site.port = await free_port();
    if (topology === 'proxy') {
      await site.start_own_broker();
      site.proxy = await LossyProxy.start(site.own_broker.port);
    }
    await site.start_up();
    return site;
  }

  async start_own_broker(port) {
    if (port === undefined) {
      this.own_broker = await start_broker(this.scope, this.folder);
      return;
    }
    const program = new Program(this.scope, this.own_broker.program.spawned.spawnfile, ['-c', path.join(this.folder, 'test-broker.conf')], { name: 'mosquitto' });
    this.own_broker = { ...this.own_broker, program };
  }

  async start_up() {
    mkdirSync(path.join(this.folder, 'log'), { recursive: true });
    const args = ['up', '--zone', 'lacet4', '--aivs', String(this.aivs), '--seed', String(this.seed), '--port', String(this.port), '--store', this.store, '--respawn', '2', '--headless'];
    args.push('--run-dir', path.join(this.folder, `run${++this.starts}`), '--log-dir', path.join(this.folder, 'log'));
    if (this.proxy) args.push('--broker', `127.0.0.1:${this.proxy.port}`);
    const env = { ...process.env, XDG_STATE_HOME: path.join(this.folder, 'state'), COSIVA_CHAOS: this.token };
    this.up = new Program(this.scope, cosiva_binary(), args, { cwd: this.folder, env, name: 'cosiva up' });
    for (const stream of [this.up.spawned.stdout, this.up.spawned.stderr]) stream.on('data', (chunk) => appendFileSync(path.join(this.folder, 'log', 'up.log'), chunk.toString().replaceAll(/^(?=.)/gm, `${new Date().toISOString()} `)));
  }

  url() {
    return `http://127.0.0.1:${this.port}`;
  }

  /** The running process of a part: its id, or null. `part` is up, server, plant, broker or aivN. */
  pid(part) {
    if (part === 'up') return this.up.gone ? null : this.up.pid;
    if (part === 'broker' && this.own_broker) return this.own_broker.program.gone ? null : this.own_broker.program.pid;
    const found = descendants(this.up.pid).find(({ argv }) => {
      if (part === 'broker') return /mosquitto$/.test(argv[0] ?? '');
      if (!part.startsWith('aiv')) return argv[1] === part;
      return argv[1] === 'aiv' && argv[argv.indexOf('--number') + 1] === part.slice(3);
    });
    return found?.pid ?? null;
  }

  parts() {
    return ['up', 'server', 'plant', 'broker', ...Array.from({ length: this.aivs }, (_, i) => `aiv${i + 1}`)];
  }

  broker_port() {
    if (this.own_broker) return this.own_broker.port;
    return eventually('the broker listens', () => {
      if (this.up.gone) throw hopeless('`up` has ended');
      const pid = this.pid('broker');
      return pid && listening_ports(pid)[0];
    });
  }

  /** The server takes another port where its own is busy: harmless, but worth a line. */
  server_port() {
    const pid = this.pid('server');
    return pid ? listening_ports(pid)[0] : undefined;
  }

  /** kill -9, and waits until the process has ended. Returns its former id, or null. */
  async kill(part) {
    const pid = this.pid(part);
    if (!pid || !send_signal(pid, 'SIGKILL')) return null;
    this.frozen.delete(pid);
    await eventually(`${part} is dead`, () => !alive(pid), { within_ms: 5_000, every_ms: 5 });
    return pid;
  }

  freeze(part, pid = this.pid(part)) {
    if (!pid || !send_signal(pid, 'SIGSTOP')) return null;
    this.frozen.set(pid, part);
    return pid;
  }

  thaw(pid) {
    this.frozen.delete(pid);
    send_signal(pid, 'SIGCONT');
  }

  thaw_all() {
    for (const pid of [...this.frozen.keys()]) this.thaw(pid);
  }

  /** All living processes that this run's platforms have started, found by a variable of their environment. */
  processes() {
    return all_processes().filter(({ pid, state }) => {
      if (state === 'Z' || pid === process.pid) return false;
      try {
        return readFileSync(`/proc/${pid}/environ`, 'latin1').includes(`COSIVA_CHAOS=${this.token}`);
      } catch {
        return false;
      }
    });
  }

  /** Ends `up` as an operator does. Returns {code, signal}, or null when it did not end in time. */
  async end() {
    this.thaw_all();
    send_signal(this.up.pid, 'SIGINT');
    return within(this.up.ended, end_ms, null);
  }

  async close() {
    await this.proxy?.close();
    await this.own_broker?.program.kill_all();
  }
}
