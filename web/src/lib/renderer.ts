// What any way of painting the circuit must do. Today Canvas2D; for fleets above some 2 000 AIVs a WebGL layer fits here.
import type { Zone } from './contract';
import type { StateKey } from './status';
import type { Size, View } from './view';

export interface VehicleMark {
  id: string;
  x: number;
  y: number;
  heading: number;
  mark: string;
  state: StateKey;
  alarm: boolean;
  /** where it says it is */
  reported: { x: number; y: number; heading: number } | null;
  /** x, y, x, y … in map metres, oldest first */
  trail: Float64Array | null;
}

export interface HeldCrossing {
  name: string;
  holder: string | null;
  waiting: number;
}

export interface Frame {
  view: View;
  vehicles: readonly VehicleMark[];
  crossings: readonly HeldCrossing[];
  /** names of the layers that are switched off */
  hidden: ReadonlySet<string>;
  selected: string | null;
  /** false: the picture is old */
  live: boolean;
}

export interface Renderer {
  resize(size: Size, pixel_ratio: number): void;
  set_zone(zone: Zone | null): void;
  /** Reads the page's colours again, after a change of theme. */
  set_colours(colours: Colours): void;
  draw(frame: Frame): void;
}

export interface Colours {
  ground: string;
  road: string;
  road_edge: string;
  line: string;
  crossing: string;
  held: string;
  tag: string;
  beacon: string;
  label: string;
  ink: string;
  on_state: string;
  select: string;
  alarm: string;
  states: Readonly<Record<StateKey, string>>;
}

const names: Readonly<Record<keyof Omit<Colours, 'states'>, string>> = {
  ground: '--ground', road: '--road', road_edge: '--road-edge', line: '--road-line', crossing: '--crossing', held: '--held',
  tag: '--tag', beacon: '--beacon', label: '--map-label', ink: '--ink', on_state: '--on-state', select: '--accent', alarm: '--alarm',
};

/** The style sheet is the one source of colours, for the canvas too. */
export function read_colours(element: Element): Colours {
  const style = getComputedStyle(element);
  const read = (name: string) => style.getPropertyValue(name).trim() || '#888';
  const plain = Object.fromEntries(Object.entries(names).map(([key, name]) => [key, read(name)]));
  const state = (key: StateKey) => read(`--state-${key}`);
  return {
    ...(plain as Omit<Colours, 'states'>),
    states: { normal: state('normal'), stopped: state('stopped'), slow: state('slow'), medium: state('medium'), fast: state('fast'), lost: state('lost') },
  };
}
