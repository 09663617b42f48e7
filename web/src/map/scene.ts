// The three layers of the circuit: the zone below, repainted when the view changes; moving objects in the centre; labels and
// sketches above. The scene chooses the renderer and replaces it when the WebGL context is lost or restored.
import { Canvas2dRenderer } from './canvas2d';
import type { Aiv, Zone } from '../live/contract';
import { kind_aiv, flags_kind_mask, flags_status_shift } from '../live/frames';
import { Markers, type Marked } from './map_markers';
import { Trails, trails_max } from './trails';
import { ZoneDrawing } from './zone_drawing';
import { spot_px, type BodiesShown, type BodySize, type Colours, type Renderer } from './renderer';
import type { Size, View } from './view';
import { WebglRenderer } from './webgl';

export interface SceneContent extends Omit<Marked, 'body'> {
  selected: string | null;
  hovered: string | null;
  /** closed sections */
  closed: readonly string[];
  /** handles of AIVs with an abnormal condition */
  alarms: ReadonlySet<number>;
}

export interface Canvases {
  zone: HTMLCanvasElement;
  graphics: HTMLCanvasElement;
  flat: HTMLCanvasElement;
  markers: HTMLCanvasElement;
}

/** Above this number of vehicles, bands, outlines and beams are drawn only for marked ones. */
const details_max = 120;

export class MapScene {
  private readonly drawing: ZoneDrawing;
  private readonly markers: Markers;
  private readonly trails = new Trails();
  private renderer: Renderer;
  private flat: Canvas2dRenderer | null = null;
  private size: Size = { width: 0, height: 0 };
  private ratio = 1;
  private colours: Colours | null = null;
  private vehicle = { length_m: 0.2, width_m: 0.12 };
  private readonly shown: BodiesShown = { persons: true, obstacles: true };
  private readonly cleanup: () => void;

  constructor(
    private readonly canvases: Canvases,
    private readonly forced: string | null,
  ) {
    this.drawing = new ZoneDrawing(canvases.zone);
    this.markers = new Markers(canvases.markers);
    this.renderer = this.choose();
    const lost = (event: Event) => {
      event.preventDefault();
      this.use(this.flat_renderer());
    };
    const restored = () => this.use(this.choose());
    canvases.graphics.addEventListener('webglcontextlost', lost);
    canvases.graphics.addEventListener('webglcontextrestored', restored);
    this.cleanup = () => {
      canvases.graphics.removeEventListener('webglcontextlost', lost);
      canvases.graphics.removeEventListener('webglcontextrestored', restored);
    };
  }

  get kind(): Renderer['kind'] {
    return this.renderer.kind;
  }

  close(): void {
    this.cleanup();
    this.renderer.close();
  }

  resize(size: Size, pixel_ratio: number): void {
    this.size = size;
    this.ratio = pixel_ratio;
    this.drawing.resize(size, pixel_ratio);
    this.renderer.resize(size, pixel_ratio);
    this.markers.resize(size, pixel_ratio);
  }
  set_colours(colours: Colours): void {
    this.colours = colours;
    this.drawing.set_colours(colours);
    this.renderer.set_colours(colours);
    this.markers.set_colours(colours);
  }
  set_zone(zone: Zone | null): void {
    if (zone) this.vehicle = zone.vehicle;
    this.drawing.set_zone(zone);
    this.markers.set_zone(zone);
  }

  paint(content: SceneContent): void {
    if (!this.colours || this.size.width === 0) return;
    const { view, hidden, positions, index } = content;
    const body = body_size(this.vehicle, view, positions.count);
    this.drawing.set_hidden(hidden);
    this.drawing.set_closed(content.closed);
    this.drawing.paint(view);
    this.shown.persons = !hidden.has('persons');
    this.shown.obstacles = !hidden.has('obstacles');
    const selected = index.handle(content.selected);
    this.renderer.begin(view, body, content.dim);
    this.below(content, this.colours, selected);
    // For spots a halo replaces the outline: it has the same effect, and thousands of outlines would be too slow.
    const spots = body.half_width < spot_px;
    if (spots) this.halos(content, this.colours.alarm, body.half_length + 4);
    this.renderer.bodies(positions, this.shown, (slot) => index.radius(positions.handle[slot]!));
    if (!spots) for (const handle of content.alarms) this.outline(positions, handle, 4, 2.5, this.colours.alarm);
    this.above(content, this.colours, selected, index.handle(content.hovered));
    this.renderer.end();
    this.markers.paint({ ...content, body });
  }

  /** Draws the ground markings under the vehicles. */
  private below(content: SceneContent, colours: Colours, selected: number): void {
    const { positions, hidden, index } = content;
    const many = positions.count > details_max;
    for (let i = 0; i < positions.count; i++) {
      const handle = positions.handle[i]!;
      if (many && handle !== selected) continue;
      const entry = index.by_handle.get(handle);
      if (!entry) continue;
      if (entry.kind === 'aiv') {
        const state = positions.flags[i]! >> flags_status_shift;
        if (!hidden.has('reserved') && state !== 5) this.renderer.band(entry.reserved, entry.reserved.length / 2, 1.15 * this.vehicle.width_m, 5, colours.states[state]!, handle === selected ? 0.42 : 0.26);
        if (!hidden.has('ranges')) this.ranges(entry.aiv, positions.x[i]!, positions.y[i]!, positions.heading[i]!, colours);
      } else if (entry.kind !== 'detected' && entry.path && !hidden.has('persons')) {
        this.renderer.band(entry.path, entry.path.length / 2, 0, 2, colours.person, 0.6);
        for (let k = 0; k < entry.path.length; k += 2) this.renderer.disc(entry.path[k]!, entry.path[k + 1]!, 0, 3, colours.person, 0.8);
      }
    }
    if (!hidden.has('trails')) this.draw_trails(content, colours, selected);
  }

  /** Draws the last obstacle scan; each beam is as long as its free distance. */
  private ranges(aiv: Aiv, x: number, y: number, heading: number, colours: Colours): void {
    const { ranges } = aiv;
    if (!ranges) return;
    const front = 0.5 * this.vehicle.length_m;
    const from_x = x + front * Math.cos(heading);
    const from_y = y + front * Math.sin(heading);
    ranges.m.forEach((reach, i) => {
      const direction = heading + ranges.first + i * ranges.width;
      this.renderer.sector(from_x, from_y, direction, 0.48 * ranges.width, reach ?? 1, reach === null ? colours.select : colours.alarm, reach === null ? 0.16 : 0.5);
    });
  }

  private draw_trails({ positions, view }: SceneContent, colours: Colours, selected: number): void {
    this.trails.leave(positions, selected);
    for (const [handle, trail] of this.trails.entries()) {
      const slot = positions.slot(handle);
      if (slot < 0 || trail.count < 3) continue;
      const state = positions.flags[slot]! >> flags_status_shift;
      if (state === 5) continue;
      const last = trail.count - 1;
      const steps = Math.min(positions.count > trails_max ? 14 : 8, last);
      for (let k = 0; k < steps; k++) {
        const from = Math.floor((k * last) / steps);
        const to = Math.floor(((k + 1) * last) / steps);
        const piece = trail.points.subarray(2 * from, 2 * to + 2);
        this.renderer.band(piece, to - from + 1, Math.max(0.014, 2 / view.scale), 2, colours.states[state]!, 0.6 * ((k + 1) / steps) ** 1.6);
      }
    }
  }

  /** Draws outlines of chosen, hovered and abnormal vehicles, and the three positions of a vehicle (twin, report, ground truth). */
  private above(content: SceneContent, colours: Colours, selected: number, hovered: number): void {
    const { positions, hidden, index, alarms, ground_truth } = content;
    const opinions = !hidden.has('opinions');
    const many = positions.count > details_max;
    this.outline(positions, hovered, 4, 1.5, colours.ink);
    this.outline(positions, selected, alarms.has(selected) ? 8 : 4, 2.5, colours.select);
    if (!opinions) return;
    for (let i = 0; i < positions.count; i++) {
      if ((positions.flags[i]! & flags_kind_mask) !== kind_aiv || (many && positions.handle[i] !== selected)) continue;
      const entry = index.by_handle.get(positions.handle[i]!);
      const heading = entry?.kind === 'aiv' && entry.aiv.reported ? entry.aiv.reported.heading : positions.heading[i]!;
      this.renderer.outline(positions.x[i]!, positions.y[i]!, positions.heading[i]!, 0, 1.5, 'solid', colours.ink);
      this.renderer.outline(positions.x[i]! + positions.reported_dx[i]!, positions.y[i]! + positions.reported_dy[i]!, heading, 1, 1.75, 'dashed', colours.estimate);
    }
    if (ground_truth && !(many && ground_truth.vehicles.length > details_max)) {
      for (const { x, y, heading } of ground_truth.vehicles) this.renderer.outline(x, y, heading, 2, 1.75, 'dotted', colours.ground_truth);
    }
  }

  private halos({ positions, alarms }: SceneContent, colour: string, pixels: number): void {
    for (const handle of alarms) {
      const slot = aiv_slot(positions, handle);
      if (slot >= 0) this.renderer.disc(positions.x[slot]!, positions.y[slot]!, 0, pixels, colour, 0.85);
    }
  }

  private outline(positions: SceneContent['positions'], handle: number, grow: number, width: number, colour: string): void {
    const slot = aiv_slot(positions, handle);
    if (slot < 0) return;
    this.renderer.outline(positions.x[slot]!, positions.y[slot]!, positions.heading[slot]!, grow, width, 'solid', colour);
  }

  private choose(): Renderer {
    const graphics = this.forced === 'canvas2d' ? null : WebglRenderer.make(this.canvases.graphics);
    const renderer = graphics ?? this.flat_renderer();
    this.show(renderer);
    return renderer;
  }
  private flat_renderer(): Canvas2dRenderer {
    this.flat ??= new Canvas2dRenderer(this.canvases.flat);
    return this.flat;
  }
  private use(renderer: Renderer): void {
    this.renderer = renderer;
    renderer.resize(this.size, this.ratio);
    if (this.colours) renderer.set_colours(this.colours);
    this.show(renderer);
  }
  private show(renderer: Renderer): void {
    this.canvases.graphics.hidden = renderer.kind !== 'webgl2';
    this.canvases.flat.hidden = renderer.kind !== 'canvas2d';
  }
}

/** The slot of a vehicle in the positions; −1 if the handle is unknown or no vehicle. */
function aiv_slot(positions: SceneContent['positions'], handle: number): number {
  const slot = handle < 0 ? -1 : positions.slot(handle);
  return slot >= 0 && (positions.flags[slot]! & flags_kind_mask) === kind_aiv ? slot : -1;
}

/** The drawn vehicle size: to scale with a visible minimum, which is smaller in large fleets to reduce overlaps. */
export function body_size(vehicle: { length_m: number; width_m: number }, view: View, count: number): BodySize {
  const least = count > 2_000 ? 3.2 : count > 400 ? 4.5 : 7;
  const grow = Math.max(1, least / (vehicle.width_m * view.scale));
  const half_length = 0.5 * vehicle.length_m * view.scale * grow;
  const half_width = 0.5 * vehicle.width_m * view.scale * grow;
  if (half_width >= 9) return { half_length, half_width, shape_behind: 0.62 * half_length, shape_radius: 0.36 * half_width };
  return { half_length, half_width, shape_behind: 0.18 * half_length, shape_radius: half_width >= 3.4 ? 0.54 * half_width : 0 };
}
