// The entries of the map's context menu, for the object under the pointer and for that position.
import { api } from '../live/api';
import { operator_commands, presence_commands } from '../commands/operator_commands';
import type { CommandName, Point } from '../live/contract';
import { layout } from '../shell/layout.svelte';
import { section_at } from './geometry';
import type { MapState, Menu } from './map_state.svelte';
import { short } from '../live/rows';
import { tool } from '../commands/tool.svelte';

export interface MenuItem {
  word: string;
  act: () => void;
  virtual?: boolean;
  danger?: boolean;
}
export interface MenuGroup {
  title: string;
  items: MenuItem[];
}

export function groups_of(map: MapState, { hit, point }: Menu): MenuGroup[] {
  return [...(hit ? of_hit(map, hit) : []), ...of_section(map, point), of_position(map, point)];
}

/** Above this number of names the menu lists none; the list of commands finds them by typing. */
const names_max = 8;

function of_section(map: MapState, [x, y]: Point): MenuGroup[] {
  const { platform } = map;
  const section = platform.zone && section_at(platform.zone, x, y, 0);
  if (!section) return [];
  return [{ title: section, items: [{ word: platform.is_closed(section) ? 'Open this section' : 'Close this section', act: () => void platform.close_section(section) }] }];
}

/** Vehicles that can be sent to a station; the chosen ones come first. */
function of_station(map: MapState, to: string): MenuItem[] {
  const { platform } = map;
  const { targets } = platform;
  const first = targets.length > 0 ? targets : platform.rows.slice(0, names_max).map((row) => row.id);
  return first.map((id) => ({ word: `Send ${short(id)} here`, act: () => void platform.go(id, to) }));
}

function missions(map: MapState, id: string): MenuItem[] {
  const { platform } = map;
  const stations = platform.zone?.stations ?? [];
  const items = stations.slice(0, names_max).map(({ name }) => ({ word: `Go to ${name}`, act: () => void platform.go(id, name) }));
  if (stations.length > names_max) {
    items.push({
      word: `Go to one of ${stations.length} …`,
      act: () => {
        platform.select(id);
        layout.palette_open = true;
      },
    });
  }
  items.push({ word: 'Circulate', act: () => void platform.circulate(id, null) });
  for (const loop of (platform.zone?.loops ?? []).slice(0, names_max)) items.push({ word: `Circulate on ${loop}`, act: () => void platform.circulate(id, loop) });
  return items;
}

function of_hit(map: MapState, hit: NonNullable<Menu['hit']>): MenuGroup[] {
  const { platform } = map;
  const { id } = hit;
  const items: MenuItem[] = [];
  if (hit.kind === 'aiv') {
    const give = (command: CommandName) => () => void platform.command(command, id);
    const wanted: readonly CommandName[] = ['slow', 'medium', 'fast', 'stop', 'restart'];
    items.push(...wanted.map((command) => ({ word: word_of(command), act: give(command), danger: command === 'stop' })));
    items.push(...missions(map, id));
    const aiv = platform.rows.find((row) => row.id === id)?.aiv;
    if (aiv) items.push(...presence_commands(aiv).map(({ command, word }) => ({ word, act: give(command) })));
    const followed = platform.following && platform.selected === id;
    items.push({
      word: followed ? 'Stop following' : 'Follow',
      act: () => {
        platform.select(id);
        platform.following = !followed;
      },
    });
  }
  if (hit.movable) {
    items.push({ word: 'Move…', act: () => tool.move(id) });
    items.push({ word: 'Remove', act: () => void platform.remove_virtual_object(id) });
  }
  if (hit.kind === 'station') items.push(...of_station(map, id));
  if (hit.kind === 'plant') items.push({ word: 'Remove', act: () => void platform.request(`Remove ${id}`, api.remove_plant_obstacle(id)) });
  if (hit.kind === 'tag') {
    items.push({ word: `Edit tag ${id}`, act: () => map.begin('edit tags', { points: [], tag: Number(id) }) });
    items.push({ word: `Remove tag ${id}`, act: () => void map.do({ what: 'edit zone', edit: { removeTags: [Number(id)] } }) });
  }
  return items.length === 0 ? [] : [{ title: hit.kind === 'tag' ? `Tag ${id}` : short(id), items }];
}

function of_position(map: MapState, at: Point): MenuGroup {
  const add = (word: string, what: 'add aiv' | 'add person' | 'add obstacle' | 'add plant obstacle') => ({ word, act: () => void map.do({ what, at }), virtual: what !== 'add plant obstacle' });
  const begin = (name: 'draw walk' | 'measure') => () => map.begin(name, { points: [at], tag: null });
  return {
    title: 'Here',
    items: [
      add('Add virtual AIV', 'add aiv'), add('Add person', 'add person'), { word: 'Add walking person…', act: begin('draw walk'), virtual: true }, add('Add obstacle', 'add obstacle'),
      ...(map.platform.ground_truth ? [add('Add physical obstacle', 'add plant obstacle')] : []),
      { word: 'Measure from here', act: begin('measure') }, { word: 'Centre the map here', act: () => map.show({ ...map.view, x: at[0], y: at[1] }) },
    ],
  };
}

function word_of(command: CommandName): string {
  const known = operator_commands.find((one) => one.command === command);
  return known?.word ?? command;
}
