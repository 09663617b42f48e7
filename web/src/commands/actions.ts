// Carries out the actions of keys, buttons and the list of commands.
import type { Act, MapAction } from '../shell/keys';
import { layout } from '../shell/layout.svelte';
import type { Platform } from '../live/platform.svelte';
import { play, step } from '../live/virtual_clock';
import { theme } from '../shell/theme.svelte';
import { tool } from './tool.svelte';

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
        if (platform.selected === null) return platform.report('Select an AIV to follow it.', 'news');
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

function focus_search(): void {
  if (layout.frame !== null && layout.frame !== 'supervision') layout.frame = null;
  setTimeout(() => document.getElementById('search-aivs')?.focus());
}

/** Closes the topmost item: the search text, the tool, the choice, the selection, the full frame, then the panel. */
function close(platform: Platform): void {
  const focused = document.activeElement;
  if (focused instanceof HTMLInputElement && focused.type === 'search') {
    if (focused.value === '') return focused.blur();
    focused.value = '';
    focused.dispatchEvent(new Event('input', { bubbles: true }));
    return;
  }
  if (tool.name !== 'none') return tool.done();
  if (platform.chosen.size > 0) platform.chosen = new Set();
  else if (platform.selected !== null) platform.select(null);
  else if (layout.frame !== null) layout.frame = null;
  else layout.panel = null;
}
