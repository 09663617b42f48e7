#!/usr/bin/env node
// A long run of the server: --aivs vehicles report --hz states per second each, from one process, over a real broker, and the
// server stores all of it. Sampled every --every seconds: resident memory and open descriptors of the server, size of its
// store, and the ages of the twins. Reported: their slopes over the second half of the run, and what did not arrive. At the
// end the server is killed with SIGKILL and started on its store again: the time until its page responds with the zone.
//
//     node bench/endurance.mjs [--minutes 20] [--aivs 1000] [--hz 10] [--keep 20GB] [--zone plant1000] [--every 10]
//                              [--store DIR] [--json FILE]
// Vehicles, broker and server share this machine. The age of a twin is the time since its last report was received, so
// that at 10 Hz it is 50 ms in the mean and 100 ms at most where nothing waits.
import { readdirSync, readFileSync, statSync } from 'node:fs';
import path from 'node:path';
import { Bus } from '../e2e/lib/bus.mjs';
import { cosiva_binary, eventually, free_port, Program, sleep, source_dir, start_broker, work_folder, zone_file } from '../e2e/lib/platform.mjs';
import { ReportingFleet } from '../e2e/lib/reporting_fleet.mjs';
import { arguments_over, quantile, report, table, with_cleanup } from './hmi/lib.mjs';

const options = arguments_over({ minutes: 20, aivs: 1000, hz: 10, keep: '20GB', zone: 'plant1000', every: 10, store: '', json: '' });

const megabyte = 1e6;
const clock_ticks = 100; // of /proc/PID/stat per second, on Linux

function status_of(pid) {
  const pages = Number(readFileSync(`/proc/${pid}/statm`, 'utf8').split(' ')[1]);
  const stat = readFileSync(`/proc/${pid}/stat`, 'utf8');
  const fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
  return { memory_mb: (pages * 4096) / megabyte, descriptors: readdirSync(`/proc/${pid}/fd`).length, cpu_s: (Number(fields[11]) + Number(fields[12])) / clock_ticks };
}

function bytes_in(folder) {
  let bytes = 0;
  for (const name of readdirSync(folder, { recursive: true })) {
    try {
      bytes += statSync(path.join(folder, name)).size;
    } catch {
      // Retention removed the segment during the scan.
    }
  }
  return bytes;
}

/** Of a straight line through the points by least squares, per minute. */
function slope_per_minute(samples, value) {
  const n = samples.length;
  const mean = (of) => samples.reduce((sum, one) => sum + of(one), 0) / n;
  const at = (one) => one.s / 60;
  const [x, y] = [mean(at), mean(value)];
  const spread = samples.reduce((sum, one) => sum + (at(one) - x) ** 2, 0);
  return samples.reduce((sum, one) => sum + (at(one) - x) * (value(one) - y), 0) / spread;
}

class LongRun {
  async start(t) {
    this.t = t;
    this.folder = work_folder(t);
    this.store = options.store || path.join(this.folder, 'store');
    this.broker = await start_broker(t);
    const bus = await Bus.open(t, this.broker.port, []);
    await bus.client.publishAsync('cosiva/v1/zone/toml', readFileSync(zone_file(options.zone)), { qos: 1, retain: true });
    await this.start_server();
    const count = options.aivs;
    this.fleet = await ReportingFleet.start(t, { broker_port: this.broker.port, zone: options.zone, count, hz: options.hz });
    await eventually('all vehicles are shown', async () => (await this.get('snapshot')).aivs.length === count, { within_ms: 60_000, every_ms: 500 });
  }

  /** Returns how long it took until the server responded with its zone [s]. */
  async start_server() {
    const port = await free_port();
    // Another master control gives the orders: what is measured is not the planning.
    const args = ['server', '--broker', this.broker.address, '--port', String(port), '--no-drive', '--keep', options.keep, '--store', this.store];
    args.push('--vehicles-max', String(Math.max(2000, options.aivs)), '--web', path.join(source_dir, 'web/dist'));
    const began_ms = performance.now();
    this.server = new Program(this.t, cosiva_binary(), args, { cwd: this.folder });
    this.url = `http://127.0.0.1:${port}`;
    await eventually('the server shows the zone', async () => (await this.get('zone'))?.name === options.zone, { within_ms: 120_000, every_ms: 10 });
    return (performance.now() - began_ms) / 1000;
  }

  async get(what) {
    return (await fetch(`${this.url}/api/v1/${what}`)).json();
  }

  async sample(began_ms) {
    const { aivs } = await this.get('snapshot');
    const ages = aivs.map(({ age_ms }) => age_ms);
    const missed = aivs.reduce((sum, aiv) => sum + (aiv.missed ?? 0), 0);
    const { memory_mb, descriptors, cpu_s } = status_of(this.server.pid);
    const s = (performance.now() - began_ms) / 1000;
    return { s, memory_mb, descriptors, age_p50_ms: quantile(ages, 0.5), age_p99_ms: quantile(ages, 0.99), shown: aivs.length, missed, store_gb: bytes_in(this.store) / 1e9, cpu_s };
  }

  async run() {
    const samples = [];
    const began_ms = performance.now();
    for (let next_ms = began_ms; next_ms <= began_ms + options.minutes * 60_000; next_ms += options.every * 1000) {
      await sleep(Math.max(0, next_ms - performance.now()));
      samples.push(await this.sample(began_ms));
      if (process.stderr.isTTY) process.stderr.write(`\r${(samples.at(-1).s / 60).toFixed(1)} of ${options.minutes} min `);
    }
    return samples;
  }

  async restart() {
    this.server.spawned.kill('SIGKILL');
    await this.server.ended;
    return this.start_server();
  }
}

await with_cleanup(async (t) => {
  const run = new LongRun();
  await run.start(t);
  const samples = await run.run();
  const restart_s = await run.restart();
  const late = samples.filter(({ s }) => s >= samples.at(-1).s / 2);
  const last = samples.at(-1);
  const result = {
    aivs: options.aivs,
    hz: options.hz,
    minutes: last.s / 60,
    memory_mb: last.memory_mb,
    memory_kb_per_minute: slope_per_minute(late, ({ memory_mb }) => memory_mb) * 1000,
    descriptors: last.descriptors,
    descriptors_per_minute: slope_per_minute(late, ({ descriptors }) => descriptors),
    age_p99_ms: quantile(late.map(({ age_p99_ms }) => age_p99_ms), 0.5),
    age_p99_max_ms: Math.max(...late.map(({ age_p99_ms }) => age_p99_ms)),
    missed: last.missed,
    store_gb: last.store_gb,
    server_cores: (last.cpu_s - samples[0].cpu_s) / (last.s - samples[0].s),
    restart_s,
  };
  const rows = samples.filter((_, i) => i % Math.max(1, Math.floor(samples.length / 20)) === 0 || i === samples.length - 1);
  table('over time', rows);
  table(`${options.aivs} vehicles at ${options.hz} Hz; slopes and ages over the second half`, Object.entries(result).map(([figure, value]) => ({ figure, value })));
  report(options, { result, samples });
});
process.exit(0);
