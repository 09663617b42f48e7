// Runs, pauses and steps the platform's virtual time. A platform on the wall clock refuses with a notice.
import { api } from './api';
import type { Platform } from './platform.svelte';

const live_time = 'This platform runs on the wall clock. Only virtual time can be paused and stepped; start one with `cosiva up --virtual-time`.';

export async function play(platform: Platform, running?: boolean): Promise<void> {
  const clock = platform.run?.clock;
  if (clock?.kind !== 'virtual') return platform.report(live_time, 'news');
  await platform.request('Clock', api.clock({ running: running ?? !clock.running }));
}

/** Advances virtual time by `ms`, and pauses it first if it runs. */
export async function step(platform: Platform, ms: number): Promise<void> {
  const clock = platform.run?.clock;
  if (clock?.kind !== 'virtual') return platform.report(live_time, 'news');
  if (clock.running && (await platform.request('Clock', api.clock({ running: false }))) === null) return;
  await platform.request('Step', api.step(ms));
}
