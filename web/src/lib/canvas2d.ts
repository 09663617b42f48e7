// Paints the circuit on a Canvas2D, blindly: shapes on named layers, whatever they mean (A19). The zone is painted once per
// view into a picture of its own; each frame copies it and adds what moves.
import type { Primitive, Zone } from './contract';
import type { Colours, Frame, Renderer, VehicleMark } from './renderer';
import { to_screen, type Size, type View } from './view';

interface LayerStyle {
  fill?: keyof Colours;
  stroke?: keyof Colours;
  alpha?: number;
  /** no thinner or smaller than this on the screen [px] */
  pixels_min?: number;
}

// A layer that is not named here is drawn too, in ink: a new kind of zone must not need a new page.
const styles: Readonly<Record<string, LayerStyle>> = {
  road: { stroke: 'road', fill: 'road', pixels_min: 2 },
  line: { stroke: 'line', fill: 'line', pixels_min: 1 },
  crossing: { fill: 'crossing', stroke: 'crossing', alpha: 0.75 },
  tag: { fill: 'tag', stroke: 'tag', pixels_min: 2.5 },
  beacon: { fill: 'beacon', stroke: 'beacon', pixels_min: 1 },
  station: { fill: 'held', stroke: 'held', alpha: 0.6, pixels_min: 3 },
  label: { fill: 'label' },
};
const other: LayerStyle = { fill: 'label', stroke: 'label', alpha: 0.6, pixels_min: 1 };
const font = 'system-ui, "Segoe UI", Roboto, "Helvetica Neue", sans-serif';

export class Canvas2dRenderer implements Renderer {
  private readonly context: CanvasRenderingContext2D;
  private readonly still = document.createElement('canvas');
  private size: Size = { width: 0, height: 0 };
  private ratio = 1;
  private zone: Zone | null = null;
  private paths: { primitive: Primitive; path: Path2D }[] = [];
  private crossing_of = new Map<string, Primitive>();
  private colours: Colours | null = null;
  private still_key = '';
  private revision = 0;

  constructor(private readonly canvas: HTMLCanvasElement) {
    const context = canvas.getContext('2d', { alpha: false });
    if (!context) throw new Error('this browser has no Canvas2D');
    this.context = context;
  }

  resize(size: Size, pixel_ratio: number): void {
    this.size = size;
    this.ratio = pixel_ratio;
    for (const canvas of [this.canvas, this.still]) {
      canvas.width = Math.max(1, Math.round(size.width * pixel_ratio));
      canvas.height = Math.max(1, Math.round(size.height * pixel_ratio));
    }
    this.revision++;
  }

  set_zone(zone: Zone | null): void {
    this.zone = zone;
    // Layer by layer, in the order in which they first come: a road must not cover its neighbour's centre line.
    const order = [...new Set((zone?.primitives ?? []).map((p) => p.layer))];
    this.paths = (zone?.primitives ?? [])
      .filter((p) => p.points.length > 0)
      .sort((a, b) => order.indexOf(a.layer) - order.indexOf(b.layer))
      .map((primitive) => ({ primitive, path: path_of(primitive) }));
    this.crossing_of = new Map((zone?.primitives ?? []).filter((p) => p.layer === 'crossing' && p.shape !== 'text' && p.label).map((p) => [p.label!, p]));
    this.revision++;
  }

  set_colours(colours: Colours): void {
    this.colours = colours;
    this.revision++;
  }

  draw(frame: Frame): void {
    const { colours, context } = this;
    if (!colours || this.size.width === 0) return;
    const key = `${this.revision} ${frame.view.x} ${frame.view.y} ${frame.view.scale} ${[...frame.hidden].sort().join()}`;
    if (key !== this.still_key) {
      this.still_key = key;
      this.draw_zone(frame, colours);
    }
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = 1;
    context.drawImage(this.still, 0, 0);
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.globalAlpha = frame.live ? 1 : 0.45;
    if (!frame.hidden.has('held')) this.draw_crossings(frame, colours);
    if (!frame.hidden.has('trails')) for (const vehicle of frame.vehicles) this.draw_trail(frame.view, vehicle, colours);
    if (!frame.hidden.has('reported')) for (const vehicle of frame.vehicles) this.draw_reported(frame.view, vehicle, colours);
    for (const vehicle of frame.vehicles) this.draw_vehicle(frame, vehicle, colours);
    context.globalAlpha = 1;
  }

  private draw_zone(frame: Frame, colours: Colours): void {
    const context = this.still.getContext('2d', { alpha: false });
    if (!context) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = colours.ground;
    context.fillRect(0, 0, this.still.width, this.still.height);
    const { view } = frame;
    const scale = view.scale * this.ratio;
    // Painting in map metres, y up; widths below are metres too.
    context.setTransform(scale, 0, 0, -scale, (this.size.width / 2) * this.ratio - view.x * scale, (this.size.height / 2) * this.ratio + view.y * scale);
    context.lineCap = 'round';
    context.lineJoin = 'round';

    // The kerb first, under all roads, so that a road never cuts through the one it crosses.
    if (!frame.hidden.has('road')) {
      context.strokeStyle = colours.road_edge;
      for (const { primitive, path } of this.paths) {
        if (primitive.layer !== 'road' || primitive.shape !== 'polyline') continue;
        context.lineWidth = Math.max(primitive.size_m, 2 / view.scale) + 3 / view.scale;
        context.stroke(path);
      }
    }
    for (const { primitive, path } of this.paths) {
      if (frame.hidden.has(primitive.layer) || primitive.shape === 'text') continue;
      const style = styles[primitive.layer] ?? other;
      context.globalAlpha = style.alpha ?? 1;
      const least = (style.pixels_min ?? 0) / view.scale;
      if (primitive.shape === 'polyline') {
        context.strokeStyle = colour(colours, style.stroke);
        context.lineWidth = Math.max(primitive.size_m, least);
        context.stroke(path);
      } else {
        context.fillStyle = colour(colours, style.fill);
        if (primitive.shape === 'disc' && primitive.size_m < least) context.fill(disc(primitive, least));
        else context.fill(path);
      }
    }
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    for (const { primitive } of this.paths) {
      if (primitive.shape !== 'text' || frame.hidden.has(primitive.layer) || !primitive.label) continue;
      const pixels = Math.min(primitive.size_m * view.scale, 15);
      if (pixels < 7) continue;
      const [x, y] = primitive.points[0]!;
      const at = to_screen(view, this.size, x, y);
      context.globalAlpha = 1;
      context.fillStyle = colour(colours, (styles[primitive.layer] ?? styles['label'])?.fill ?? 'label');
      if (primitive.layer === 'crossing') context.fillStyle = colours.label;
      context.font = `500 ${pixels}px ${font}`;
      context.fillText(primitive.label, at.px, at.py);
    }
    context.globalAlpha = 1;
  }

  /** Who holds a crossing stands beside it, as a small flag on the crossing's own shape. */
  private draw_crossings(frame: Frame, colours: Colours): void {
    const { context } = this;
    for (const { name, holder, waiting } of frame.crossings) {
      const primitive = this.crossing_of.get(name);
      if (!primitive || holder === null) continue;
      context.save();
      const scale = frame.view.scale;
      context.translate(this.size.width / 2, this.size.height / 2);
      context.scale(scale, -scale);
      context.translate(-frame.view.x, -frame.view.y);
      context.lineWidth = 2 / scale;
      context.setLineDash(waiting > 0 ? [] : [6 / scale, 4 / scale]);
      context.strokeStyle = colours.held;
      context.stroke(path_of(primitive));
      context.restore();
      const middle = middle_of(primitive);
      const at = to_screen(frame.view, this.size, middle.x, middle.y);
      const text = waiting > 0 ? `${name} · ${holder} +${waiting}` : `${name} · ${holder}`;
      const reach = radius_of(primitive) * scale;
      if (reach < 9) continue;
      context.font = `600 11px ${font}`;
      context.textAlign = 'center';
      context.textBaseline = 'middle';
      const width = context.measureText(text).width + 12;
      // Outward from the middle of the zone, where the road leaves room.
      const away = this.away(middle.x, middle.y);
      const x = at.px + away.x * (reach + width / 2 + 4);
      const y = at.py - away.y * (reach + 12);
      context.beginPath();
      context.roundRect(x - width / 2, y - 9, width, 18, 9);
      context.fillStyle = colours.held;
      context.fill();
      context.fillStyle = colours.ground;
      context.fillText(text, x, y + 0.5);
    }
  }

  private away(x: number, y: number): { x: number; y: number } {
    const [x0, y0, x1, y1] = this.zone?.bounds ?? [0, 0, 0, 0];
    const dx = x - (x0 + x1) / 2;
    const dy = y - (y0 + y1) / 2;
    const norm = Math.hypot(dx, dy);
    return norm < 1e-6 ? { x: 0, y: 1 } : { x: dx / norm, y: dy / norm };
  }

  private draw_trail(view: View, vehicle: VehicleMark, colours: Colours): void {
    const trail = vehicle.trail;
    if (!trail || trail.length < 4) return;
    const { context } = this;
    const alpha = context.globalAlpha;
    context.strokeStyle = colours.states[vehicle.state];
    context.lineCap = 'butt';
    context.lineWidth = Math.max(2, 0.014 * view.scale);
    const points = trail.length / 2;
    const steps = Math.min(14, points - 1);
    for (let k = 0; k < steps; k++) {
      const from = Math.floor((k * (points - 1)) / steps);
      const to = Math.floor(((k + 1) * (points - 1)) / steps);
      context.globalAlpha = alpha * 0.55 * ((k + 1) / steps) ** 1.6;
      context.beginPath();
      for (let i = from; i <= to; i++) {
        const at = to_screen(view, this.size, trail[2 * i]!, trail[2 * i + 1]!);
        if (i === from) context.moveTo(at.px, at.py);
        else context.lineTo(at.px, at.py);
      }
      context.stroke();
    }
    context.globalAlpha = alpha;
  }

  private draw_reported(view: View, vehicle: VehicleMark, colours: Colours): void {
    if (!vehicle.reported || vehicle.state === 'lost') return;
    const { context } = this;
    const { length, width } = this.body(view);
    const at = to_screen(view, this.size, vehicle.reported.x, vehicle.reported.y);
    context.save();
    context.translate(at.px, at.py);
    context.rotate(-vehicle.reported.heading);
    context.beginPath();
    context.roundRect(-length / 2, -width / 2, length, width, width * 0.24);
    context.strokeStyle = colours.ink;
    context.lineWidth = 1.25;
    context.globalAlpha *= 0.65;
    context.setLineDash([3, 2]);
    context.stroke();
    context.restore();
  }

  private draw_vehicle(frame: Frame, vehicle: VehicleMark, colours: Colours): void {
    const { context } = this;
    const { view } = frame;
    const { length, width } = this.body(view);
    const at = to_screen(view, this.size, vehicle.x, vehicle.y);
    const radius = width * 0.24;
    const lost = vehicle.state === 'lost';
    const tint = colours.states[vehicle.state];
    context.save();
    context.translate(at.px, at.py);

    if (vehicle.id === frame.selected || vehicle.alarm) {
      context.save();
      context.rotate(-vehicle.heading);
      context.beginPath();
      context.roundRect(-length / 2 - 5, -width / 2 - 5, length + 10, width + 10, radius + 5);
      context.strokeStyle = vehicle.alarm ? colours.alarm : colours.select;
      context.lineWidth = 2.5;
      context.stroke();
      if (vehicle.alarm && vehicle.id === frame.selected) {
        context.beginPath();
        context.roundRect(-length / 2 - 9, -width / 2 - 9, length + 18, width + 18, radius + 9);
        context.strokeStyle = colours.select;
        context.stroke();
      }
      context.restore();
    }

    context.rotate(-vehicle.heading);
    context.beginPath();
    context.roundRect(-length / 2, -width / 2, length, width, [radius, radius * 1.5, radius * 1.5, radius]);
    if (lost) {
      context.fillStyle = colours.ground;
      context.fill();
      context.setLineDash([4, 3]);
      context.lineWidth = 2;
      context.strokeStyle = tint;
      context.stroke();
      context.setLineDash([]);
    } else {
      context.shadowColor = 'rgb(0 0 0 / 0.35)';
      context.shadowBlur = 5 * this.ratio;
      context.shadowOffsetY = 1.5 * this.ratio;
      context.fillStyle = tint;
      context.fill();
      context.shadowColor = 'transparent';
      context.lineWidth = 1.25;
      context.strokeStyle = colours.ground;
      context.stroke();
    }
    // The nose: an arrow head in the front quarter says where it points.
    const nose = length / 2;
    context.beginPath();
    context.moveTo(nose - length * 0.1, 0);
    context.lineTo(nose - length * 0.25, -width * 0.27);
    context.lineTo(nose - length * 0.25, width * 0.27);
    context.closePath();
    context.fillStyle = lost ? tint : colours.on_state;
    context.fill();

    // The number stays upright, behind the nose.
    const pixels = Math.min(width * 0.66, 22);
    if (pixels >= 8) {
      const back = -length * 0.13;
      context.translate(back, 0);
      context.rotate(vehicle.heading);
      context.font = `700 ${pixels}px ${font}`;
      context.textAlign = 'center';
      context.textBaseline = 'middle';
      context.fillStyle = lost ? tint : colours.on_state;
      context.fillText(vehicle.mark, 0, pixels * 0.05, length * 0.62);
    }
    context.restore();
    if (pixels < 8) this.draw_mark_beside(at.px, at.py, width, vehicle.mark, colours);
  }

  private draw_mark_beside(px: number, py: number, width: number, mark: string, colours: Colours): void {
    const { context } = this;
    context.font = `600 11px ${font}`;
    context.textAlign = 'left';
    context.textBaseline = 'middle';
    context.fillStyle = colours.ink;
    context.fillText(mark, px + width / 2 + 8, py - width / 2 - 6);
  }

  /** To scale, but never too small to be seen. */
  private body(view: View): { length: number; width: number } {
    const shape = this.zone?.vehicle ?? { length_m: 0.2, width_m: 0.12 };
    const grow = Math.max(1, 7 / (shape.width_m * view.scale));
    return { length: shape.length_m * view.scale * grow, width: shape.width_m * view.scale * grow };
  }
}

function colour(colours: Colours, name: keyof Colours | undefined): string {
  const value = colours[name ?? 'label'];
  return typeof value === 'string' ? value : colours.label;
}

function path_of(primitive: Primitive): Path2D {
  if (primitive.shape === 'disc') return disc(primitive, primitive.size_m);
  const path = new Path2D();
  primitive.points.forEach(([x, y], i) => (i === 0 ? path.moveTo(x, y) : path.lineTo(x, y)));
  if (primitive.shape === 'polygon') path.closePath();
  return path;
}

function disc(primitive: Primitive, radius: number): Path2D {
  const path = new Path2D();
  for (const [x, y] of primitive.points) {
    path.moveTo(x + radius, y);
    path.arc(x, y, radius, 0, 2 * Math.PI);
  }
  return path;
}

function middle_of(primitive: Primitive): { x: number; y: number } {
  const n = primitive.points.length;
  return primitive.points.reduce((sum, [x, y]) => ({ x: sum.x + x / n, y: sum.y + y / n }), { x: 0, y: 0 });
}

function radius_of(primitive: Primitive): number {
  if (primitive.shape === 'disc') return primitive.size_m;
  const middle = middle_of(primitive);
  return Math.max(...primitive.points.map(([x, y]) => Math.hypot(x - middle.x, y - middle.y)));
}
