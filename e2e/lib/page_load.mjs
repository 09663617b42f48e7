// How long the tasks of a page's main thread are, and when a click leaves it.
import { readFileSync } from 'node:fs';
import path from 'node:path';

/** Before the page is opened: records long tasks, and for each click the times of its handler and of its request. */
export async function observe(page) {
  await page.addInitScript(() => {
    const observed = { long_tasks_ms: [], clicks: [] };
    globalThis.observed = observed;
    new PerformanceObserver((list) => observed.long_tasks_ms.push(...list.getEntries().map(({ duration }) => duration))).observe({ type: 'longtask' });
    const wall_ms = () => performance.timeOrigin + performance.now();
    // In the capture phase: before the handlers of the page, of which the first sends the Stop.
    addEventListener('click', () => observed.clicks.push({ handler_ms: wall_ms() }), { capture: true });
    const { fetch } = globalThis;
    globalThis.fetch = (url, init) => {
      const last = observed.clicks.at(-1);
      if (init?.method === 'POST' && last && last.request_ms === undefined) last.request_ms = wall_ms();
      return fetch(url, init);
    };
  });
}

/** Removes and returns {long_tasks_ms, clicks}: milliseconds of wall time since 1970 in `clicks`. */
export function take(page) {
  return page.evaluate(() => ({ long_tasks_ms: globalThis.observed.long_tasks_ms.splice(0), clicks: globalThis.observed.clicks.splice(0) }));
}

/** Processor times of the tasks of the main thread during `action` [ms], longest first: whatever else the machine does. */
export async function task_times(browser, page, folder, action) {
  const file = path.join(folder, 'trace.json');
  await browser.startTracing(page, { path: file, categories: ['toplevel'] });
  await action();
  await browser.stopTracing();
  const { traceEvents } = JSON.parse(readFileSync(file));
  const thread = ({ pid, tid }) => `${pid} ${tid}`;
  const mains = new Set(traceEvents.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain').map(thread));
  const tasks = traceEvents.filter((event) => event.ph === 'X' && /RunTask$/.test(event.name) && event.tdur !== undefined && mains.has(thread(event)));
  return tasks.map(({ tdur }) => tdur / 1000).sort((a, b) => b - a);
}
