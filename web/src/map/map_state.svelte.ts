// The state of the Circuit frame (view, hit, tool), shared by its canvas, menus and panels.
import { api } from '../live/api';
import type { Point } from '../live/contract';
import { layout } from '../shell/layout.svelte';
import type { Hit } from './hit_index';
import { MapIndex } from './hit_index';
import type { Drawing, HeldCrossing } from './map_markers';
import { drop_tag, empty_sketch, enter, erase, finish, press, type Doing, type Sketch, type Step } from './tools';
import type { Platform } from '../live/platform.svelte';
import { short } from '../live/rows';
import { tool, type ToolName } from '../commands/tool.svelte';
import { between, fit, pan, to_map, to_screen, zoom_at, type Pixel, type Size, type View } from './view';

/** Duration of the transition from one zone to the next [ms]. */
const flight_ms = 450;

/** Layers of the page, besides those of the zone. */
export const own_layers = [
  { name: 'reserved', word: 'Reserved paths' },
  { name: 'crossings', word: 'Held crossings' },
  { name: 'trails', word: 'Trails' },
  { name: 'persons', word: 'Persons and their paths' },
  { name: 'obstacles', word: 'Obstacles' },
  { name: 'opinions', word: 'Estimate, twin and ground truth' },
  { name: 'ranges', word: 'Sensor range' },
] as const;
export const zone_words: Readonly<Record<string, string>> = {
  road: 'Sections', line: 'Centre lines', crossing: 'Crossings', tag: 'RFID tags', beacon: 'Beacons', station: 'Stations', pivot: 'Turning positions', section: 'Section names and directions', label: 'Names',
};
const off_at_first: readonly string[] = ['opinions', 'ranges'];

export interface Menu {
  /** position of the menu in the frame */
  at: Pixel;
  /** the map position that its entries refer to */
  point: Point;
  hit: Hit | null;
}

export class MapState {
  readonly index = new MapIndex();
  view = $state.raw<View>({ x: 0, y: 0, scale: 250 });
  size = $state.raw<Size>({ width: 0, height: 0 });
  /** whether the view shows the whole zone and is fitted again when the window changes */
  fitted = $state(true);
  layers_open = $state(false);
  hover = $state.raw<{ at: Pixel; hit: Hit } | null>(null);
  menu = $state.raw<Menu | null>(null);
  sketch = $state.raw<Sketch>(empty_sketch);
  /** pointer position on the map */
  pointer: Point | null = null;
  /** the crosshair that the arrow keys move */
  cross = $state.raw<Point | null>(null);
  drag = $state.raw<Drawing['drag']>(null);
  private begun = empty_sketch;
  private flight: { from: View; to: View; since_ms: number } | null = null;
  readonly hidden = $derived<ReadonlySet<string>>(new Set(layout.layers_off ?? off_at_first));

  /** whether the minimap is useful: the view shows only a part of the zone, and the map has room for it */
  readonly zoomed_in = $derived.by(() => {
    const { zone } = this.platform;
    if (!zone || this.size.width < 420) return false;
    const [x0, y0, x1, y1] = zone.bounds;
    return this.view.scale * (x1 - x0) > 1.25 * this.size.width || this.view.scale * (y1 - y0) > 1.25 * this.size.height;
  });
  readonly crossings = $derived.by((): HeldCrossing[] => {
    const name = (id: string) => {
      const entry = this.index.by_id.get(id);
      return entry?.kind === 'aiv' ? entry.label : short(id);
    };
    return this.platform.crossings.map((one) => ({ name: one.name, holder: one.heldBy === null ? null : name(one.heldBy), waiting: one.waiting.length }));
  });

  readonly platform: Platform;

  constructor(platform: Platform) {
    this.platform = platform;
  }

  // ── the view ──
  show(view: View): void {
    this.flight = null;
    this.view = view;
    this.fitted = false;
    this.platform.following = false;
  }
  show_all(): void {
    this.platform.following = false;
    this.fitted = true;
    const { zone } = this.platform;
    this.flight = null;
    if (zone && this.size.width > 0) this.view = fit(zone.bounds, this.size, 34);
  }
  /** Shows a new zone whole, with an animated transition unless the user prefers reduced motion. */
  fly_to_all(now_ms: number, still = matchMedia('(prefers-reduced-motion: reduce)').matches): void {
    const from = this.view;
    this.show_all();
    if (still || this.size.width === 0) return;
    this.flight = { from, to: this.view, since_ms: now_ms };
    this.view = from;
  }
  /** Updates the view before each painted frame. */
  fly(now_ms: number): void {
    if (!this.flight) return;
    const { from, to, since_ms } = this.flight;
    const ratio = (now_ms - since_ms) / flight_ms;
    this.view = ratio >= 1 ? to : between(from, to, ratio);
    if (ratio >= 1) this.flight = null;
  }
  zoom(factor: number, at: Pixel = { px: this.size.width / 2, py: this.size.height / 2 }): void {
    this.show(zoom_at(this.view, this.size, at.px, at.py, factor));
  }
  pan(dx: number, dy: number): void {
    this.show(pan(this.view, dx, dy));
  }
  point(at: Pixel): Point {
    const { x, y } = to_map(this.view, this.size, at.px, at.py);
    return [x, y];
  }
  /** Tolerance around the pointer [m], so that small objects are easier to hit. */
  get slack(): number {
    return 9 / this.view.scale;
  }
  toggle_layer(name: string): void {
    const next = new Set(this.hidden);
    if (!next.delete(name)) next.add(name);
    const off = [...next].sort();
    layout.layers_off = off.join() === [...off_at_first].sort().join() ? null : off;
  }

  // ── the crosshair ──
  move_cross(dx: number, dy: number): void {
    const at = this.cross ? to_screen(this.view, this.size, this.cross[0], this.cross[1]) : { px: this.size.width / 2, py: this.size.height / 2 };
    const px = at.px + dx;
    const py = at.py + dy;
    // At the border of the view the map pans.
    const over_x = Math.min(0, px - 20) + Math.max(0, px - this.size.width + 20);
    const over_y = Math.min(0, py - 20) + Math.max(0, py - this.size.height + 20);
    this.cross = this.point({ px, py });
    if (over_x !== 0 || over_y !== 0) this.pan(-over_x, -over_y);
  }
  show_cross(): void {
    this.cross ??= [this.view.x, this.view.y];
  }

  // ── the tools ──
  press(at: Point, hit: Hit | null): void {
    this.take(press(tool.name, this.sketch, at, hit, this.platform.zone));
  }
  enter(at: Point, hit: Hit | null): void {
    this.take(enter(tool.name, this.sketch, at, hit, this.platform.zone));
  }
  finish(): void {
    this.take(finish(tool.name, this.sketch));
  }
  erase(): void {
    this.take(erase(tool.name, this.sketch));
  }
  drop_tag(number: number, at: Point): void {
    const { zone } = this.platform;
    if (zone) void this.do(drop_tag(number, at, zone).doing);
  }
  choose_tag(number: number | null): void {
    this.sketch = { ...this.sketch, tag: number };
  }
  /** Starts a tool with a given sketch. */
  begin(name: Exclude<ToolName, 'none'>, sketch: Sketch): void {
    if (tool.name === name) this.sketch = sketch;
    else {
      this.begun = sketch;
      tool.choose(name);
    }
  }
  /** Clears the sketch when the tool changes. */
  tool_changed(): void {
    this.sketch = this.begun;
    this.begun = empty_sketch;
    this.cross = null;
    this.drag = null;
  }

  private take(step: Step): void {
    const target = tool.target;
    this.sketch = step.sketch;
    if (step.doing) void this.do(step.doing, target);
    if (step.done) tool.done();
  }

  async do(doing: Doing, target: string | null = null): Promise<void> {
    const { platform } = this;
    switch (doing.what) {
      case 'report':
        return platform.report(doing.text, 'news');
      case 'edit zone':
        return void (await platform.request('Zone', api.edit_zone(doing.edit)));
      case 'close or open':
        return platform.close_section(doing.section);
      case 'add walk': {
        const added = await platform.request('Walker', api.add_walk(doing.path, tool.walk_speed, tool.walk_repeat));
        return added ? platform.select(added.id) : undefined;
      }
      case 'move object':
        if (target !== null) await platform.request(`Move ${short(target)}`, api.move_virtual_object(short(target), { x: doing.at[0], y: doing.at[1] }));
        return;
      default: {
        const position = { x: doing.at[0], y: doing.at[1] };
        const add = { 'add aiv': api.add_aiv, 'add person': api.add_person, 'add obstacle': api.add_obstacle, 'add plant obstacle': api.add_plant_obstacle }[doing.what];
        const added = await platform.request(words[doing.what], add(position));
        if (added && doing.what !== 'add plant obstacle') platform.select(doing.what === 'add aiv' ? full_id(added.id) : added.id);
      }
    }
  }

  // ── the zone's edits ──
  async undo(): Promise<void> {
    await this.platform.request('Undo', api.undo_zone());
  }
  async redo(): Promise<void> {
    await this.platform.request('Redo', api.redo_zone());
  }
  async save(): Promise<void> {
    const saved = await this.platform.request('Save', api.save_zone());
    if (saved) this.platform.report(`The zone is saved in ${saved.file}.`, 'news');
  }
}

const words = { 'add aiv': 'Virtual AIV', 'add person': 'Person', 'add obstacle': 'Obstacle', 'add plant obstacle': 'Physical obstacle' } as const;

/** The API names a virtual AIV by its serial number, whereas its vehicle id includes the manufacturer. */
function full_id(id: string): string {
  return id.includes('/') ? id : `CoSiVA.virtual/${id}`;
}
