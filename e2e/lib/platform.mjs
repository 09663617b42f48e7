// Starts the built `cosiva` as a user would, in a folder of its own, and ends it again.
import { finally_do } from './cleanup.mjs';
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { alive, all_processes, descendants, listening_ports, send_signal } from './processes.mjs';

export const source_dir = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
export const lacet4_length_m = 4 * 1.5 + 4 * 1.5 * Math.PI * 0.6; // A11: 17.31 m
export const artefacts_dir = path.join(source_dir, 'e2e/artefacts');

export function cosiva_binary() {
  const candidates = [process.env.COSIVA_BIN, path.join(source_dir, 'build/release/cosiva'), path.join(source_dir, 'build/debug/cosiva')];
  const found = candidates.find((candidate) => candidate && existsSync(candidate));
  assert.ok(found, 'no cosiva binary: build it, or set COSIVA_BIN');
  return found;
}

export function zone_file(name) {
  return path.join(source_dir, 'zones', `${name}.toml`);
}

export function sleep(ms) {
  return new Promise((resolve) => setTimeout(resolve, ms));
}

/** The result of the promise, or `late` when it takes longer; no timer stays behind to hold the process. */
export async function within(promise, ms, late) {
  let timer;
  const timeout = new Promise((resolve) => {
    timer = setTimeout(resolve, ms, late);
  });
  try {
    return await Promise.race([promise, timeout]);
  } finally {
    clearTimeout(timer);
  }
}

/** An error that does not go away by waiting. */
export function hopeless(text) {
  return Object.assign(new Error(text), { hopeless: true });
}

/** Calls `question` until its result is truthy, and returns that. `what` is named when it never is. */
export async function eventually(what, question, { within_ms = 20_000, every_ms = 50 } = {}) {
  const end = Date.now() + within_ms;
  let last;
  for (;;) {
    try {
      const answer = await question();
      if (answer) return answer;
      last = undefined;
    } catch (error) {
      if (error.hopeless) throw error;
      last = error;
    }
    if (Date.now() > end) throw new Error(`not within ${within_ms} ms: ${what}${last ? ` (${last.message})` : ''}`);
    await sleep(every_ms);
  }
}

/** A complete response, {status, text}. fetch's own time-out is not an Error: a test's report would not show it. */
export async function fetched(url, within_ms, init = {}) {
  try {
    const response = await fetch(url, { ...init, signal: AbortSignal.timeout(within_ms) });
    return { status: response.status, text: await response.text() };
  } catch (error) {
    throw new Error(`${init.method ?? 'GET'} ${url}: ${error.cause?.message ?? error.message}`);
  }
}

/** A TCP port that was free a moment ago. */
export async function free_port() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

/** A temporary folder that is removed with the test; its logs are preserved in artefacts/ when the test failed. */
export function work_folder(t) {
  const folder = mkdtempSync(path.join(os.tmpdir(), 'cosiva-e2e-'));
  finally_do(t, () => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

/** Runs one command to its end. */
export async function cosiva(args, { timeout_ms = 60_000, cwd, binary = cosiva_binary(), on_start } = {}) {
  const child = spawn(binary, args, { cwd, stdio: ['ignore', 'pipe', 'pipe'] });
  let stdout = '';
  let stderr = '';
  child.stdout.on('data', (chunk) => (stdout += chunk));
  child.stderr.on('data', (chunk) => (stderr += chunk));
  const ended = new Promise((resolve, reject) => {
    child.on('error', reject);
    child.on('close', (code, signal) => resolve({ code, signal, stdout, stderr }));
  });
  on_start?.(child);
  const timer = setTimeout(() => {
    for (const { pid } of descendants(child.pid)) send_signal(pid, 'SIGKILL');
    child.kill('SIGKILL');
  }, timeout_ms);
  const result = await ended;
  clearTimeout(timer);
  assert.notEqual(result.signal, 'SIGKILL', `cosiva ${args.join(' ')} did not end within ${timeout_ms} ms\n${stderr.slice(-2000)}`);
  return result;
}

/** Exit 0 and JSON on standard output, or the test fails with the command's output. */
export async function cosiva_json(args, options) {
  const result = await cosiva(args, options);
  assert.equal(result.code, 0, `cosiva ${args.join(' ')}: exit ${result.code}\n${result.stderr.slice(-3000)}\n${result.stdout.slice(-1000)}`);
  return JSON.parse(result.stdout);
}

/** The environment; what a program keeps beyond its run is in its folder, not the user's. */
function own_state(cwd) {
  return cwd ? { ...process.env, XDG_STATE_HOME: path.join(cwd, 'state') } : process.env;
}

/** A long-running `cosiva` (up, server, plant, aiv …) or any other program. */
export class Program {
  constructor(t, binary, args, { cwd, env, name = args[0] } = {}) {
    this.name = name;
    this.words = '';
    this.spawned = spawn(binary, args, { cwd, env: env ?? own_state(cwd), stdio: ['ignore', 'pipe', 'pipe'] });
    this.pid = this.spawned.pid;
    this.spawned.stdout.on('data', (chunk) => (this.words += chunk));
    this.spawned.stderr.on('data', (chunk) => (this.words += chunk));
    this.ended = new Promise((resolve) => this.spawned.on('close', (code, signal) => resolve({ code, signal })));
    this.spawned.on('exit', () => (this.gone = true));
    this.family = new Set([this.pid]);
    finally_do(t, () => this.kill_all());
  }

  /** Ends the program as Ctrl-C does, and waits. */
  async stop({ within_ms = 15_000, signal = 'SIGINT' } = {}) {
    this.remember_family();
    send_signal(this.pid, signal);
    const late = Symbol('late');
    const result = await within(this.ended, within_ms, late);
    assert.notEqual(result, late, `${this.name} did not end within ${within_ms} ms of ${signal}\n${this.words.slice(-2000)}`);
    return result;
  }

  remember_family() {
    for (const { pid } of descendants(this.pid)) this.family.add(pid);
  }

  async kill_all() {
    if (!this.gone) {
      this.remember_family();
      send_signal(this.pid, 'SIGCONT'); // a test may have failed while the program was frozen
      send_signal(this.pid, 'SIGTERM');
      await within(this.ended, 4_000);
    }
    for (const pid of this.family) if (alive(pid)) send_signal(pid, 'SIGKILL');
  }
}

/** `cosiva up`, ready when its page responds and all vehicles have reported. */
export class Platform extends Program {
  static async up(t, { aivs = 4, zone = 'lacet4', args = [], folder = work_folder(t), port, binary = cosiva_binary(), ready = true, own_folders = false, env } = {}) {
    const http_port = port ?? (await free_port());
    const run_dir = path.join(folder, 'run');
    const log_dir = path.join(folder, 'log');
    const all = ['up', '--zone', zone, '--aivs', String(aivs), '--port', String(http_port), ...(own_folders ? [] : ['--run-dir', run_dir, '--log-dir', log_dir]), ...args];
    const platform = new Platform(t, binary, all, { cwd: folder, env, name: 'cosiva up' });
    Object.assign(platform, { folder, run_dir, log_dir, aivs, port: http_port, url: `http://127.0.0.1:${http_port}` });
    finally_do(t, () => platform.keep_logs(t));
    if (ready) await platform.ready();
    return platform;
  }

  async ready(within_ms = 40_000) {
    await eventually(
      `${this.aivs} AIVs online\n${this.words.slice(-1500)}`,
      async () => {
        if (this.gone) throw hopeless(`cosiva up ended early:\n${this.words}`);
        const { aivs } = await this.snapshot();
        this.remember_family();
        return aivs.length === this.aivs && aivs.every((aiv) => aiv.connection === 'ONLINE' && !aiv.lost);
      },
      { within_ms, every_ms: 100 },
    );
  }

  async get(what) {
    const { status, text } = await fetched(`${this.url}/api/v1/${what}`, 3_000);
    assert.equal(status, 200, `GET ${what}: ${status}`);
    return JSON.parse(text);
  }

  snapshot() {
    return this.get('snapshot');
  }

  async aiv(number) {
    const { aivs } = await this.snapshot();
    return aivs.find((aiv) => aiv.number === number);
  }

  /** Any call of the contract: {status, body}; a body that is a string is sent unchanged. */
  async call(method, what, body, headers = { 'content-type': 'application/json' }) {
    const init = body === undefined ? {} : { headers, body: typeof body === 'string' ? body : JSON.stringify(body) };
    const { status, text } = await fetched(`${this.url}/api/v1/${what}`, 5_000, { method, ...init });
    return { status, body: text === '' ? null : JSON.parse(text) };
  }

  /** The same, which must succeed; returns the body. */
  async ask(method, what, body) {
    const answer = await this.call(method, what, body);
    assert.ok(answer.status < 300, `${method} ${what}: ${answer.status} ${JSON.stringify(answer.body)}`);
    return answer.body;
  }

  /** Gives a command; returns its id, or throws with the server's reason. */
  async command(command, vehicle) {
    const response = await fetch(`${this.url}/api/v1/commands`, {
      method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: JSON.stringify({ command, vehicle }),
    });
    const body = await response.json();
    assert.equal(response.status, 202, JSON.stringify(body));
    return body.id;
  }

  /** {name, pid} of the processes that `up` runs, by name. */
  children() {
    const value = JSON.parse(readFileSync(path.join(this.run_dir, 'children.json'), 'utf8'));
    const list = Array.isArray(value) ? value : value.children;
    for (const { pid } of list) if (pid > 0) this.family.add(pid);
    return list;
  }

  child(pattern) {
    return eventually(`a running child ${pattern}`, () => this.children().find(({ name, pid }) => pattern.test(name) && pid > 0 && alive(pid)), { within_ms: 10_000 });
  }

  async kill_child(pattern) {
    const child = await this.child(pattern);
    process.kill(child.pid, 'SIGKILL');
    await eventually(`${child.name} is dead`, () => !alive(child.pid), { within_ms: 2_000, every_ms: 5 });
    return child;
  }

  /** The port of its private broker. */
  async broker_port() {
    return eventually('the broker listens', () => {
      const broker = descendants(this.pid).find(({ argv }) => /mosquitto/.test(argv[0] ?? ''));
      return broker && listening_ports(broker.pid)[0];
    });
  }

  /** Freezes `up` itself, so that no process is restarted while `action` examines the others. */
  async without_supervisor(action) {
    process.kill(this.pid, 'SIGSTOP');
    try {
      return await action();
    } finally {
      process.kill(this.pid, 'SIGCONT');
    }
  }

  keep_logs() {
    if (!process.env.COSIVA_KEEP_LOGS) return;
    const target = path.join(artefacts_dir, `logs-${process.pid}-${this.port}`);
    mkdirSync(target, { recursive: true });
    writeFileSync(path.join(target, 'up.txt'), this.words);
    if (!existsSync(this.log_dir)) return;
    for (const file of readdirSync(this.log_dir, { withFileTypes: true }))
      if (file.isFile()) writeFileSync(path.join(target, file.name), readFileSync(path.join(this.log_dir, file.name)));
  }
}

/** A mosquitto of the test's own, for parts started alone. */
export async function start_broker(t, folder = work_folder(t)) {
  const port = await free_port();
  const file = path.join(folder, 'test-broker.conf');
  writeFileSync(file, `listener ${port} 127.0.0.1\nallow_anonymous true\npersistence false\nmax_queued_messages 0\n`);
  const binary = ['/usr/sbin/mosquitto', '/usr/bin/mosquitto', '/usr/local/sbin/mosquitto'].find((candidate) => existsSync(candidate));
  assert.ok(binary, 'mosquitto is not installed');
  const broker = new Program(t, binary, ['-c', file], { name: 'mosquitto' });
  await eventually('the broker listens', () => listening_ports(broker.pid).includes(port), { within_ms: 5_000 });
  return { port, address: `127.0.0.1:${port}`, program: broker };
}

export { alive, all_processes, descendants, listening_ports, send_signal };
