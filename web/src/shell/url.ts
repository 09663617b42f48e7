// The view as the fragment of the address: short enough to read, and parsed leniently.
import type { Theme } from './theme.svelte';

export const frame_names = ['supervision', 'states', 'circuit', 'traces'] as const;
export type FrameName = (typeof frame_names)[number];
/** The titles of the article's figure 2. */
export const frame_titles: Readonly<Record<FrameName, string>> = {
  supervision: 'Supervision of AIVs',
  states: 'States of AIVs',
  circuit: 'Circuit',
  traces: 'Traces of communications between AIVs',
};

export const panel_names = ['bijection', 'alarms', 'boards', 'battery', 'gvs', 'log'] as const;
export type PanelName = (typeof panel_names)[number];

export const panel_titles: Readonly<Record<PanelName, string>> = {
  bijection: 'Bijection',
  alarms: 'Alarms',
  boards: 'Boards',
  battery: 'Batteries',
  gvs: 'GVS: image of the camera',
  log: 'Log of commands',
};

export interface ViewState {
  frame: FrameName | null;
  panel: PanelName | null;
  select: string | null;
  follow: boolean;
  filter: string;
  /** key of a column, with a minus sign in front for descending order */
  sort: string;
  /** filter of the communications: agent (empty: all), search_text, and the kinds left out */
  agent: string;
  search_text: string;
  kinds_off: readonly string[];
  diagram: boolean;
  theme: Theme;
  /** null: the default layers */
  layers_off: readonly string[] | null;
}

export const default_view: ViewState = {
  frame: null, panel: null, select: null, follow: false, filter: '', sort: 'number', agent: '', search_text: '', kinds_off: [], diagram: false, theme: 'system', layers_off: null,
};

const names_in = (text: string | null): string[] => (text ?? '').split(',').filter((name) => name !== '').slice(0, 50);
const one_of = <T extends string>(names: readonly T[], text: string | null): T | undefined => names.find((name) => name === text);

/**
 * The view of an address. An empty fragment sets nothing. Any other fragment sets the whole view, so that a link shows the
 * same to every user, except the theme, which is set only if it is named. Invalid values are ignored.
 */
export function view_of(hash: string): Partial<ViewState> {
  const params = new URLSearchParams(hash.replace(/^#/, ''));
  if (params.size === 0) return {};
  const { theme: _own, ...view }: Partial<ViewState> = { ...default_view };
  const frame = one_of(frame_names, params.get('frame'));
  if (frame) view.frame = frame;
  const panel = one_of(panel_names, params.get('panel'));
  if (panel) view.panel = panel;
  const select = params.get('select');
  if (select) view.select = select;
  if (params.get('follow') === '1') view.follow = true;
  const filter = params.get('filter');
  if (filter !== null) view.filter = filter.slice(0, 200);
  const sort = params.get('sort');
  if (sort && /^-?[a-z]+$/i.test(sort)) view.sort = sort;
  view.agent = (params.get('agent') ?? '').slice(0, 200);
  view.search_text = (params.get('search_text') ?? '').slice(0, 200);
  view.kinds_off = names_in(params.get('without'));
  view.diagram = params.get('diagram') === '1';
  const theme = one_of(['system', 'light', 'dark'] as const, params.get('theme'));
  const off = params.get('off');
  if (off !== null) view.layers_off = names_in(off);
  return theme ? { ...view, theme } : view;
}

/** The address of a view, which names only values other than the defaults. */
export function hash_of(view: ViewState): string {
  const parts: [string, string][] = [];
  if (view.frame) parts.push(['frame', view.frame]);
  if (view.panel) parts.push(['panel', view.panel]);
  if (view.select !== null) parts.push(['select', view.select]);
  if (view.follow && view.select !== null) parts.push(['follow', '1']);
  if (view.filter !== '') parts.push(['filter', view.filter]);
  if (view.sort !== default_view.sort) parts.push(['sort', view.sort]);
  if (view.agent !== '') parts.push(['agent', view.agent]);
  if (view.search_text !== '') parts.push(['search_text', view.search_text]);
  if (view.kinds_off.length > 0) parts.push(['without', view.kinds_off.join(',')]);
  if (view.diagram) parts.push(['diagram', '1']);
  if (view.theme !== 'system') parts.push(['theme', view.theme]);
  if (view.layers_off !== null) parts.push(['off', view.layers_off.join(',')]);
  // Slashes and commas are allowed in a fragment, and CoSiVA/AIV2 reads better than CoSiVA%2FAIV2.
  const text = parts.map(([name, value]) => `${name}=${encodeURIComponent(value).replace(/%2F/g, '/').replace(/%2C/g, ',')}`).join('&');
  return text === '' ? '' : `#${text}`;
}
