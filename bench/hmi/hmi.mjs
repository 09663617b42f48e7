#!/usr/bin/env node
// Measures the page and its server with synthetic AIVs (hmi_server):
//   frames    frames per second and script time per frame in headless Chromium, for each number of AIVs
//   heap      growth of the page's heap over --minutes, at --heap-vehicles
//   clients   many live clients at 30 Hz with and without one that never reads: the others' intervals and latencies, and
//             the server's memory
//
//     node bench/hmi/hmi.mjs [--what frames,heap,clients] [--vehicles 100,1000,10000] [--seconds 20] [--minutes 30]
//                            [--clients 50] [--rounds 3] [--json FILE] [--server build/release/bench/hmi_server]
import { open_browser } from '../../e2e/lib/browser.mjs';
import { Program, eventually, sleep, source_dir } from '../../e2e/lib/platform.mjs';
import { NeverReads, Reader } from './live_client.mjs';
import { arguments_over, figures, quantile, report, table, with_cleanup } from './lib.mjs';
import { existsSync, readFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';

const options = arguments_over({
  what: 'frames,heap,clients',
  vehicles: '100,1000,10000',
  seconds: 20,
  minutes: 30,
  heap_vehicles: 100,
  clients: 50,
  clients_vehicles: 100,
  rounds: 3,
  scale: 0,
  json: '',
  server: process.env.HMI_SERVER ?? path.join(source_dir, 'build/release/bench/hmi_server'),
});

async function serve(t, vehicles) {
  if (!existsSync(options.server)) throw new Error(`there is no ${options.server}: build it (target bench_hmi_server), or name it with --server`);
  const args = ['--vehicles', String(vehicles), ...(options.scale > 0 ? ['--scale', String(options.scale)] : [])];
  const program = new Program(t, options.server, args, { name: 'hmi_server' });
  const facts = await eventually('hmi_server listens', () => /^\{.*\}$/m.exec(program.words)?.[0], { within_ms: 10_000 }).then(JSON.parse);
  return { program, facts, url: `http://127.0.0.1:${facts.port}` };
}

function memory_mb(pid) {
  return Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;
}

async function metrics(session) {
  const { metrics: list } = await session.send('Performance.getMetrics');
  return Object.fromEntries(list.map(({ name, value }) => [name, value]));
}

/** The page, with a frame counter injected. */
async function open_counted(t, browser, url) {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  const errors = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(url);
  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable', { timeDomain: 'timeTicks' });
  await session.send('HeapProfiler.enable');
  return { page, session, errors };
}

/** Intervals between animation frames for this long [ms]. */
function count_frames(page, ms) {
  return page.evaluate(
    (span) =>
      new Promise((resolve) => {
        const intervals = [];
        let last = performance.now();
        const end = last + span;
        const frame = (now) => {
          intervals.push(now - last);
          last = now;
          if (now < end) requestAnimationFrame(frame);
          else resolve(intervals.slice(1));
        };
        requestAnimationFrame(frame);
      }),
    ms,
  );
}

async function measure_frames(browser, vehicles) {
  return with_cleanup(async (t) => {
    const { facts, url } = await serve(t, vehicles);
    const { page, session, errors } = await open_counted(t, browser, url);
    await sleep(3_000);
    const before = await metrics(session);
    const intervals = await count_frames(page, options.seconds * 1000);
    const after = await metrics(session);
    const frames = intervals.length;
    const per_frame = (name) => ((after[name] - before[name]) * 1000) / frames;
    await page.close();
    if (errors.length > 0) throw new Error(`the page failed: ${errors[0]}`);
    return {
      AIVs: vehicles,
      'frames/s': (1000 * frames) / intervals.reduce((sum, one) => sum + one, 0),
      'interval p50 ms': quantile(intervals, 0.5),
      'interval p99 ms': quantile(intervals, 0.99),
      'script ms/frame': per_frame('ScriptDuration'),
      'task ms/frame': per_frame('TaskDuration'),
      'layout+style ms/frame': per_frame('LayoutDuration') + per_frame('RecalcStyleDuration'),
      'snapshot kB': facts.snapshot_bytes / 1000,
    };
  });
}

async function heap_mb(session) {
  // Twice: memory that finalisers free goes with the second.
  for (let i = 0; i < 2; ++i) await session.send('HeapProfiler.collectGarbage');
  return (await metrics(session)).JSHeapUsedSize / 1e6;
}

async function measure_heap(browser) {
  return with_cleanup(async (t) => {
    const { url } = await serve(t, options.heap_vehicles);
    const { page, session, errors } = await open_counted(t, browser, url);
    await sleep(Math.min(30_000, options.minutes * 6_000)); // filled once: histories, caches
    const samples = [{ minute: 0, 'heap MB': await heap_mb(session) }];
    const start = Date.now();
    const steps = Math.max(1, Math.min(10, Math.round(options.minutes)));
    for (let i = 1; i <= steps; ++i) {
      await sleep(start + (options.minutes * 60_000 * i) / steps - Date.now());
      samples.push({ minute: (options.minutes * i) / steps, 'heap MB': await heap_mb(session) });
    }
    await page.close();
    if (errors.length > 0) throw new Error(`the page failed: ${errors[0]}`);
    return { minutes: options.minutes, vehicles: options.heap_vehicles, growth_mb: samples.at(-1)['heap MB'] - samples[0]['heap MB'], samples };
  });
}

/** One phase: the intervals and latencies of all readers, and the server's memory second by second. */
async function listen(readers, pid, seconds) {
  for (const reader of readers) reader.note(true);
  const memory = [];
  for (let i = 0; i < seconds; ++i) {
    await sleep(1_000);
    memory.push(memory_mb(pid));
  }
  for (const reader of readers) reader.note(false);
  return {
    intervals: readers.flatMap((reader) => reader.intervals),
    latencies: readers.flatMap((reader) => reader.latencies),
    memory,
  };
}

async function measure_clients() {
  return with_cleanup(async (t) => {
    const { program, facts, url } = await serve(t, options.clients_vehicles);
    const readers = Array.from({ length: options.clients - 1 }, () => new Reader(url));
    t.after(() => readers.forEach((reader) => reader.close()));
    await Promise.all(readers.map((reader) => reader.opened));
    await sleep(2_000);
    const phases = { without: [], with: [] };
    let connections = 0;
    // Alternately, so that other load on the machine affects both.
    for (let round = 0; round < options.rounds; ++round) {
      phases.without.push(await listen(readers, program.pid, options.seconds));
      const bad = new NeverReads(facts.port);
      await sleep(1_000);
      phases.with.push(await listen(readers, program.pid, options.seconds));
      connections += bad.connections;
      bad.close();
      await sleep(500);
    }
    const rows = Object.entries(phases).map(([name, all]) => {
      const intervals = figures(all.flatMap((phase) => phase.intervals));
      const latencies = figures(all.flatMap((phase) => phase.latencies));
      const memory = all.flatMap((phase) => phase.memory);
      return {
        'one never reads': name === 'with' ? 'yes' : 'no',
        frames: intervals.count,
        'interval p50 ms': intervals.p50,
        'interval p99 ms': intervals.p99,
        'latency p50 ms': latencies.p50,
        'latency p99 ms': latencies.p99,
        'server MB first': memory[0],
        'server MB last': memory.at(-1),
        'server MB max': Math.max(...memory),
      };
    });
    const p99 = (phase, what) => quantile(phase[what], 0.99);
    const median_ratio = (what) => quantile(phases.with.map((phase, i) => p99(phase, what) / p99(phases.without[i], what)), 0.5);
    return {
      clients: options.clients,
      vehicles: options.clients_vehicles,
      rows,
      ratio_interval_p99: median_ratio('intervals'),
      ratio_latency_p99: median_ratio('latencies'),
      never_reads_connections: connections,
    };
  });
}

const wanted = new Set(options.what.split(','));
const result = { machine: { cores: os.cpus().length, model: os.cpus()[0]?.model, load: os.loadavg()[0] } };
await with_cleanup(async (t) => {
  const browser = wanted.has('frames') || wanted.has('heap') ? await open_browser(t) : null;
  if (wanted.has('frames')) {
    result.frames = [];
    for (const vehicles of options.vehicles.split(',').map(Number)) result.frames.push(await measure_frames(browser, vehicles));
    table('Frames in headless Chromium (goals: 55 frames/s at 1 000 AIVs, 30 at 10 000)', result.frames);
  }
  if (wanted.has('clients')) {
    result.clients = await measure_clients();
    table(`${options.clients} live clients, ${options.clients_vehicles} AIVs`, result.clients.rows);
    console.log(`  p99 with it / without it: interval ${result.clients.ratio_interval_p99.toFixed(2)}, latency ${result.clients.ratio_latency_p99.toFixed(2)} (median of ${options.rounds} rounds; goal: unchanged)`);
  }
  if (wanted.has('heap')) {
    result.heap = await measure_heap(browser);
    table(`Heap of the page at ${options.heap_vehicles} AIVs (goal: under 5 MB of growth in 30 minutes)`, result.heap.samples);
    console.log(`  growth ${result.heap.growth_mb.toFixed(2)} MB in ${options.minutes} minutes`);
  }
});
report(options, result);
