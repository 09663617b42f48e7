// The interface of the renderers for moving objects: WebGL2 with one draw call, and Canvas2D as the fallback. Objects are
// painted in the order of the calls.
import type { Positions } from '../live/positions';
import type { StateKey } from '../live/status';
import type { Size, View } from './view';

/** The line style of an outline; three coinciding outlines can thus be distinguished without colour. */
export type Line = 'solid' | 'dashed' | 'dotted';

/** Below this half width a vehicle is drawn as a spot [px]. */
export const spot_px = 2.4;

/** The drawn size of a vehicle [CSS pixels]: to scale, with a visible minimum. */
export interface BodySize {
  half_length: number;
  half_width: number;
  /** the state shape on the roof: its offset behind the centre, and its radius; 0: too small to be recognised */
  shape_behind: number;
  shape_radius: number;
}

export interface Renderer {
  readonly kind: 'webgl2' | 'canvas2d';
  resize(size: Size, pixel_ratio: number): void;
  /** Reads the colours of the page again after a change of theme. */
  set_colours(colours: Colours): void;
  /** @param dim  true if the shown data is stale */
  begin(view: View, body: BodySize, dim: boolean): void;
  /** Draws a band along `count` points x, y, x, y … [m], at least `pixels_min` wide. */
  band(points: ArrayLike<number>, count: number, width_m: number, pixels_min: number, colour: string, alpha: number): void;
  /** Draws a circular sector of `radius_m` around a point, between two directions. */
  sector(x: number, y: number, direction: number, half_angle: number, radius_m: number, colour: string, alpha: number): void;
  disc(x: number, y: number, radius_m: number, pixels_min: number, colour: string, alpha: number): void;
  /** Draws the outline of a vehicle, `grow` pixels outside its body. */
  outline(x: number, y: number, heading: number, grow: number, width: number, line: Line, colour: string): void;
  /** Draws all vehicles, persons and obstacles. `radius_of` gives the radius of the object in a slot [m]. */
  bodies(positions: Positions, show: BodiesShown, radius_of: (slot: number) => number): void;
  end(): void;
  close(): void;
}

export interface BodiesShown {
  persons: boolean;
  obstacles: boolean;
}

export interface Colours {
  ground: string;
  road: string;
  road_edge: string;
  line: string;
  arc: string;
  clothoid: string;
  charger: string;
  crossing: string;
  held: string;
  tag: string;
  beacon: string;
  label: string;
  ink: string;
  panel: string;
  on_state: string;
  select: string;
  alarm: string;
  virtual: string;
  person: string;
  obstacle: string;
  estimate: string;
  ground_truth: string;
  states: readonly string[];
}

const names: Readonly<Record<keyof Omit<Colours, 'states'>, string>> = {
  ground: '--ground', road: '--road', road_edge: '--road-edge', line: '--road-line', arc: '--road-arc', clothoid: '--road-clothoid', charger: '--charger', crossing: '--crossing', held: '--held',
  tag: '--tag', beacon: '--beacon', label: '--map-label', ink: '--ink', panel: '--panel', on_state: '--on-state', select: '--accent', alarm: '--alarm',
  virtual: '--orange', person: '--person', obstacle: '--obstacle', estimate: '--estimate', ground_truth: '--ground-truth',
};

/** The states in the order of the status field of the binary frames. */
export const state_order: readonly StateKey[] = ['normal', 'stopped', 'slow', 'medium', 'fast', 'lost'];

/** Reads the colours from the style sheet, their only source. */
export function read_colours(element: Element): Colours {
  const style = getComputedStyle(element);
  const read = (name: string) => style.getPropertyValue(name).trim() || '#888';
  const plain = Object.fromEntries(Object.entries(names).map(([key, name]) => [key, read(name)]));
  return { ...(plain as Omit<Colours, 'states'>), states: state_order.map((key) => read(`--state-${key}`)) };
}

/** Packs a colour, #rgb or #rrggbb, as red | green « 8 | blue « 16. */
export function packed(colour: string): number {
  const digits = /^#([0-9a-f]{3}|[0-9a-f]{6})$/i.exec(colour.trim())?.[1];
  if (!digits) return 0x888888;
  const long = digits.length === 6 ? digits : [...digits].map((digit) => digit + digit).join('');
  const value = parseInt(long, 16);
  return ((value >> 16) & 0xff) | (value & 0xff00) | ((value & 0xff) << 16);
}

/**
 * The closed outline of a vehicle, `grow` pixels outside its body: x forward, y sideways, x, y … [CSS px]. The buffer is
 * reused, because the outline is the same for all vehicles of a frame.
 */
export function body_outline(body: BodySize, grow: number): Float32Array {
  const key = `${body.half_length} ${body.half_width} ${grow}`;
  const known = outlines.get(key);
  if (known) return known;
  const { half_width } = body;
  const l = body.half_length + grow;
  const w = half_width + grow;
  // The same corners as in the shader: cut at the rear, narrowed at the front.
  const cut = 0.267 * half_width + 0.586 * grow;
  const front = l - 0.45 * half_width - 0.409 * grow;
  const tip = 0.18 * half_width + 0.257 * grow;
  const points = new Float32Array([0, -w, front, -w, l, -tip, l, tip, front, w, cut - l, w, -l, w - cut, -l, cut - w, cut - l, -w, 0, -w]);
  if (outlines.size > 40) outlines.clear();
  outlines.set(key, points);
  return points;
}
const outlines = new Map<string, Float32Array>();
