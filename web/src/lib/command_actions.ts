// What each key and each entry of the list of commands does. The table of keys says which; here it is done.
import { api } from './api';
import type { Action, MapAction } from './keys';
import { layout } from './layout.svelte';
import type { Platform } from './platform.svelte';
import { theme } from './theme.svelte';
import { tool } from './tool.svelte';

export type Act = (action: Action) => void;

export const live_time = 'This platform runs on the wall\u2019s clock. Only virtual time can be paused and stepped; start one with `cosiva up --virtual-time`.';

export function actions_of(platform: Platform, map: (action: MapAction) => void): Act {
  return (action) => {
    switch (action) {
      case 'stop all':
        return void platform.command('stop', '*');
      case 'stop selected':
        return void platform.command('stop', platform.targets);
      case 'next':
        return platform.select_next(1);
      case 'previous':
        return platform.select_next(-1);
      case 'follow':
        if (platform.selected === null) return platform.say('Select an AIV to follow it.', 'news');
        platform.following = !platform.following;
        return;
      case 'search':
        return focus_search();
      case 'play':
        return void play(platform);
      case 'step':
        return void step(platform, 100);
      case 'long step':
        return void step(platform, 1_000);
      case 'theme':
        return theme.next();
      case 'help':
        layout.help_open = !layout.help_open;
        return;
      case 'palette':
        layout.palette_open = !layout.palette_open;
        return;
      case 'frame 1':
      case 'frame 2':
      case 'frame 3':
      case 'frame 4':
        return layout.frame_number(Number(action.slice(-1)));
      case 'close':
        return close(platform);
      default:
        map(action);
    }
  };
}

export async function play(platform: Platform, running?: boolean): Promise<void> {
  const clock = platform.run?.clock;
  if (clock?.kind !== 'virtual') return platform.say(live_time, 'news');
  await platform.ask('Clock', api.clock({ running: running ?? !clock.running }));
}

/** Time that runs is paused first: a step is asked for to look closely. */
export async function step(platform: Platform, ms: number): Promise<void> {
  const clock = platform.run?.clock;
  if (clock?.kind !== 'virtual') return platform.say(live_time, 'news');
  if (clock.running && (await platform.ask('Clock', api.clock({ running: false }))) === null) return;
  await platform.ask('Step', api.step(ms));
}

function focus_search(): void {
  if (layout.frame !== null && layout.frame !== 'supervision') layout.frame = null;
  setTimeout(() => document.getElementById('search-aivs')?.focus());
}

/** One thing at a time, the most passing first. */
function close(platform: Platform): void {
  const focused = document.activeElement;
  if (focused instanceof HTMLInputElement && focused.type === 'search') {
    if (focused.value === '') return focused.blur();
    focused.value = '';
    focused.dispatchEvent(new Event('input', { bubbles: true }));
    return;
  }
  if (tool.name !== 'look') return tool.done();
  if (platform.chosen.size > 0) platform.chosen = new Set();
  else if (platform.selected !== null) platform.select(null);
  else if (layout.frame !== null) layout.frame = null;
  else layout.panel = null;
}
