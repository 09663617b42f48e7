// The 2D overlay above the map: numbers, names, holders of crossings, and the sketch of the active tool. The number of labels
// is limited to what can be read.
import type { Point, Primitive, GroundTruth, Zone } from '../live/contract';
import { kind_aiv, flags_kind_mask, flags_status_shift } from '../live/frames';
import { context_2d, resize_canvas } from './canvas';
import { distance, nearest_on_tracks } from './geometry';
import type { MapIndex } from './hit_index';
import { tag_reach_m, type Sketch } from './tools';
import { map_font, centre_of, radius_of } from './zone_drawing';
import type { Positions } from '../live/positions';
import type { BodySize, Colours } from './renderer';
import type { ToolName } from '../commands/tool.svelte';
import { to_screen, type Pixel, type Size, type View } from './view';

/** Above this number, labels are unreadable and cost time. */
export const words_max = 300;

export interface Drawing {
  tool: ToolName;
  sketch: Sketch;
  /** position of the pointer or the crosshair on the map */
  pointer: Point | null;
  cross: Point | null;
  /** the dragged object and its new position */
  drag: { kind: 'virtualObject' | 'tag'; id: string; from: Point; to: Point } | null;
}

export interface HeldCrossing {
  name: string;
  holder: string | null;
  waiting: number;
}

export interface Marked {
  view: View;
  body: BodySize;
  positions: Positions;
  index: MapIndex;
  ground_truth: GroundTruth | null;
  zone: Zone | null;
  hidden: ReadonlySet<string>;
  crossings: readonly HeldCrossing[];
  drawing: Drawing;
  server_ms: number;
  dim: boolean;
}

export class Markers {
  private readonly context: CanvasRenderingContext2D;
  private size: Size = { width: 0, height: 0 };
  private ratio = 1;
  private clean = true;
  private colours: Colours | null = null;
  private crossing_of = new Map<string, Primitive>();
  private zone: Zone | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = context_2d(canvas);
  }

  resize(size: Size, pixel_ratio: number): void {
    this.size = size;
    this.ratio = pixel_ratio;
    resize_canvas(this.canvas, size, pixel_ratio);
    this.clean = true;
  }
  set_colours(colours: Colours): void {
    this.colours = colours;
  }
  set_zone(zone: Zone | null): void {
    this.zone = zone;
    this.crossing_of = new Map((zone?.primitives ?? []).filter((p) => p.layer === 'crossing' && p.shape !== 'text' && p.label).map((p) => [p.label!, p]));
  }

  paint(marked: Marked): void {
    const { context, colours } = this;
    if (!colours || this.size.width === 0) return;
    // An empty overlay is not cleared again: without a graphics card, clearing costs as much as painting.
    if (!this.clean) {
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, this.canvas.width, this.canvas.height);
      this.clean = true;
    }
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.globalAlpha = marked.dim ? 0.45 : 1;
    context.textBaseline = 'middle';
    if (!marked.hidden.has('crossings')) for (const crossing of marked.crossings) this.crossing(crossing, marked.view, colours);
    this.bodies(marked, colours);
    if (marked.ground_truth && !marked.hidden.has('obstacles')) this.plant_obstacles(marked, colours);
    context.globalAlpha = 1;
    this.drawing(marked, colours);
  }

  private bodies(marked: Marked, colours: Colours): void {
    const { positions, index, body, view, hidden } = marked;
    const { context } = this;
    const on_roof = body.half_width >= 9;
    const pixels = Math.min(1.25 * body.half_width, 21);
    const labelled = !on_roof && positions.count <= 120;
    let words = 0;
    context.textAlign = 'center';
    for (let i = 0; i < positions.count && words < words_max; i++) {
      const px = this.size.width / 2 + (positions.x[i]! - view.x) * view.scale;
      const py = this.size.height / 2 - (positions.y[i]! - view.y) * view.scale;
      if (px < -30 || py < -30 || px > this.size.width + 30 || py > this.size.height + 30) continue;
      const flags = positions.flags[i]!;
      const kind = flags & flags_kind_mask;
      if (kind === kind_aiv && !on_roof && !labelled) continue;
      const entry = index.by_handle.get(positions.handle[i]!);
      if (!entry) continue;
      words++;
      this.clean = false;
      if (entry.kind === 'aiv' && on_roof) {
        const lost = flags >> flags_status_shift === 5;
        // The number is drawn between the state shape at the rear and the front.
        const ahead = 0.08 * body.half_length;
        const room = (0.82 * body.half_length) / (0.62 * entry.label.length);
        context.font = `700 ${Math.round(Math.min(pixels, room))}px ${map_font}`;
        context.fillStyle = lost ? colours.states[5]! : colours.on_state;
        context.fillText(entry.label, px + ahead * Math.cos(positions.heading[i]!), py - ahead * Math.sin(positions.heading[i]!) + 0.5);
      } else if (entry.kind === 'aiv') {
        this.word(entry.label, px, py - body.half_length - 8, colours.ink, colours);
      } else if (entry.kind === 'person' ? hidden.has('persons') : hidden.has('obstacles')) {
        continue;
      } else {
        const reach = Math.max(index.radius(positions.handle[i]!) * view.scale, 6);
        const age_s = entry.kind === 'detected' ? Math.max(0, Math.round((marked.server_ms - entry.obstacle.last_ms) / 1000)) : 0;
        const text = entry.kind === 'detected' ? `${entry.id} · detected ${age_s < 1 ? 'now' : age_s < 120 ? `${age_s} s ago` : `${Math.round(age_s / 60)} min ago`}` : entry.id;
        this.word(text, px, py - reach - 9, colours.ink, colours);
      }
    }
  }

  /** Text with an outline in the background colour, readable on any ground. */
  private word(text: string, px: number, py: number, colour: string, colours: Colours, weight = 600): void {
    const { context } = this;
    this.clean = false;
    context.font = `${weight} 11px ${map_font}`;
    context.textAlign = 'center';
    context.lineWidth = 3;
    context.lineJoin = 'round';
    context.strokeStyle = colours.ground;
    context.strokeText(text, px, py);
    context.fillStyle = colour;
    context.fillText(text, px, py);
  }

  /** Physical obstacles of the emulated plant, dotted, whether an AIV has detected them or not. */
  private plant_obstacles({ ground_truth, view }: Marked, colours: Colours): void {
    const { context } = this;
    for (const { id, x, y, radius } of ground_truth?.obstacles ?? []) {
      const { px, py } = to_screen(view, this.size, x, y);
      const reach = Math.max(radius * view.scale, 5) + 3;
      context.beginPath();
      context.arc(px, py, reach, 0, 2 * Math.PI);
      context.setLineDash([2, 2.5]);
      context.lineWidth = 1.75;
      context.strokeStyle = colours.ground_truth;
      context.stroke();
      context.setLineDash([]);
      this.word(id, px, py + reach + 8, colours.ground_truth, colours);
    }
  }

  /** Labels an occupied crossing with its holder, and outlines the crossing. */
  private crossing({ name, holder, waiting }: HeldCrossing, view: View, colours: Colours): void {
    const primitive = this.crossing_of.get(name);
    if (!primitive || holder === null) return;
    const { context } = this;
    const centre = centre_of(primitive.points);
    const at = to_screen(view, this.size, centre.x, centre.y);
    const reach = radius_of(primitive) * view.scale;
    if (reach < 9) return;
    this.clean = false;
    context.beginPath();
    if (primitive.shape === 'disc') context.arc(at.px, at.py, reach, 0, 2 * Math.PI);
    else {
      primitive.points.forEach(([x, y], i) => {
        const p = to_screen(view, this.size, x, y);
        if (i === 0) context.moveTo(p.px, p.py);
        else context.lineTo(p.px, p.py);
      });
      context.closePath();
    }
    context.lineWidth = 2;
    context.setLineDash(waiting > 0 ? [] : [6, 4]);
    context.strokeStyle = colours.held;
    context.stroke();
    context.setLineDash([]);
    // On a small map the label would hide too much; only the outline is drawn.
    if (reach < 14) return;
    const text = waiting > 0 ? `${name} · ${holder} +${waiting}` : `${name} · ${holder}`;
    context.font = `600 11px ${map_font}`;
    context.textAlign = 'center';
    const width = context.measureText(text).width + 12;
    // The label is placed away from the centre of the zone, where roads leave room.
    const away = this.away(centre.x, centre.y);
    const x = at.px + away.x * (reach + width / 2 + 4);
    const y = at.py - away.y * (reach + 12);
    context.beginPath();
    context.roundRect(x - width / 2, y - 9, width, 18, 9);
    context.fillStyle = colours.held;
    context.fill();
    context.fillStyle = colours.ground;
    context.fillText(text, x, y + 0.5);
  }

  private away(x: number, y: number): { x: number; y: number } {
    const [x0, y0, x1, y1] = this.zone?.bounds ?? [0, 0, 0, 0];
    const dx = x - (x0 + x1) / 2;
    const dy = y - (y0 + y1) / 2;
    const norm = Math.hypot(dx, dy);
    return norm < 1e-6 ? { x: 0, y: 1 } : { x: dx / norm, y: dy / norm };
  }

  private drawing({ drawing, view, zone }: Marked, colours: Colours): void {
    const { tool, sketch, drag } = drawing;
    const at = drawing.cross ?? drawing.pointer;
    const screen = (point: Point) => to_screen(view, this.size, point[0], point[1]);
    if (drag) this.dragged(drag, screen, zone, colours);
    if (tool === 'none') return;
    this.clean = false;
    if (tool === 'edit tags' && zone) this.tags(zone, sketch.tag, view, colours);
    if ((tool === 'draw walk' || tool === 'measure') && sketch.points.length > 0) this.path(tool, sketch.points, at, screen, colours);
    if (at && !drag && (tool === 'add aiv' || tool === 'edit tags') && zone) this.snap(tool, at, zone, screen, colours);
    if (at && (tool === 'add person' || tool === 'add obstacle' || tool === 'add plant obstacle' || tool === 'move object')) {
      this.circle(screen(at), (tool === 'add person' ? 0.06 : 0.08) * view.scale, tool === 'add plant obstacle' ? colours.ground_truth : tool === 'add person' ? colours.person : colours.virtual, [4, 3]);
    }
    if (drawing.cross) this.cross(screen(drawing.cross), colours);
  }

  private dragged(drag: NonNullable<Drawing['drag']>, screen: (point: Point) => Pixel, zone: Zone | null, colours: Colours): void {
    const { context } = this;
    this.clean = false;
    const nearest = drag.kind === 'tag' && zone ? nearest_on_tracks(zone, drag.to[0], drag.to[1]) : null;
    const lands = drag.kind === 'virtualObject' || (nearest !== null && nearest.distance <= tag_reach_m);
    const to = screen(nearest && lands ? [nearest.x, nearest.y] : drag.to);
    const from = screen(drag.from);
    context.beginPath();
    context.moveTo(from.px, from.py);
    context.lineTo(to.px, to.py);
    context.setLineDash([4, 4]);
    context.lineWidth = 1.5;
    context.strokeStyle = lands ? colours.select : colours.alarm;
    context.stroke();
    context.setLineDash([]);
    this.circle(to, 10, lands ? colours.select : colours.alarm, []);
    const beyond = drag.id.slice(drag.id.indexOf('/') + 1);
    this.word(drag.kind === 'tag' ? `tag ${drag.id}` : beyond, to.px, to.py - 20, lands ? colours.select : colours.alarm, colours);
  }

  private tags(zone: Zone, chosen: number | null, view: View, colours: Colours): void {
    const many = (zone.tags ?? []).length > words_max;
    for (const tag of zone.tags ?? []) {
      const at = to_screen(view, this.size, tag.x, tag.y);
      if (at.px < -20 || at.py < -20 || at.px > this.size.width + 20 || at.py > this.size.height + 20) continue;
      const reach = Math.max(0.02 * view.scale, 5) + 3;
      this.circle(at, reach, tag.number === chosen ? colours.select : colours.ink, [], tag.number === chosen ? 3 : 1.25);
      if (!many && view.scale < 220) this.word(String(tag.number), at.px, at.py - reach - 7, colours.ink, colours);
    }
  }

  private path(tool: ToolName, points: readonly Point[], at: Point | null, screen: (point: Point) => Pixel, colours: Colours): void {
    const { context } = this;
    const colour = tool === 'measure' ? colours.select : colours.person;
    const all = at ? [...points, at] : points;
    const pixels = all.map(screen);
    context.beginPath();
    pixels.forEach(({ px, py }, i) => (i === 0 ? context.moveTo(px, py) : context.lineTo(px, py)));
    context.lineWidth = 2;
    context.setLineDash(tool === 'measure' ? [] : [7, 5]);
    context.strokeStyle = colour;
    context.stroke();
    context.setLineDash([]);
    points.forEach((_, i) => this.dot(pixels[i]!, colour, colours));
    for (let i = 1; i < all.length; i++) {
      const length = distance(all[i - 1]!, all[i]!);
      const a = pixels[i - 1]!;
      const b = pixels[i]!;
      if (Math.hypot(a.px - b.px, a.py - b.py) < 44) continue;
      this.word(length < 1 ? `${(100 * length).toFixed(1)} cm` : `${length.toFixed(3)} m`, (a.px + b.px) / 2, (a.py + b.py) / 2 - 9, colours.ink, colours);
    }
  }

  /** Highlights the position on the circuit that a press would use. */
  private snap(tool: ToolName, at: Point, zone: Zone, screen: (point: Point) => Pixel, colours: Colours): void {
    const nearest = nearest_on_tracks(zone, at[0], at[1]);
    if (!nearest || (tool === 'edit tags' && nearest.distance > tag_reach_m / 2)) return;
    this.circle(screen([nearest.x, nearest.y]), tool === 'add aiv' ? 12 : 7, tool === 'add aiv' ? colours.virtual : colours.select, [3, 2.5]);
  }

  private circle({ px, py }: Pixel, radius: number, colour: string, dash: number[], width = 2): void {
    const { context } = this;
    this.clean = false;
    context.beginPath();
    context.arc(px, py, Math.max(radius, 5), 0, 2 * Math.PI);
    context.setLineDash(dash);
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.stroke();
    context.setLineDash([]);
  }
  private dot({ px, py }: Pixel, colour: string, colours: Colours): void {
    const { context } = this;
    context.beginPath();
    context.arc(px, py, 4.5, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.fill();
    context.lineWidth = 1.5;
    context.strokeStyle = colours.ground;
    context.stroke();
  }
  private cross({ px, py }: Pixel, colours: Colours): void {
    const { context } = this;
    for (const [width, colour] of [[4, colours.ground], [1.75, colours.select]] as const) {
      context.beginPath();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) {
        context.moveTo(px + 4 * dx, py + 4 * dy);
        context.lineTo(px + 18 * dx, py + 18 * dy);
      }
      context.lineWidth = width;
      context.strokeStyle = colour;
      context.stroke();
    }
  }
}
