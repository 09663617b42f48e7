// Paints the zone: shapes on named layers, without knowledge of their meaning (A19). The zone is repainted only when the view,
// the zone, the layers or the colours change.
import type { Point, Primitive, Zone } from '../live/contract';
import { context_2d, resize_canvas } from './canvas';
import { box_of, simplified } from './geometry';
import type { Colours } from './renderer';
import { to_screen, type Size, type View } from './view';

interface LayerStyle {
  fill: keyof Colours;
  alpha?: number;
  /** least width or size on the screen [px] */
  pixels_min?: number;
  text?: keyof Colours;
}

// A layer that is not listed here is drawn in ink, so that a new zone format needs no change of the page.
const styles: Readonly<Record<string, LayerStyle>> = {
  road: { fill: 'road', pixels_min: 2 },
  line: { fill: 'line', pixels_min: 1 },
  crossing: { fill: 'crossing', alpha: 0.75, text: 'label' },
  pivot: { fill: 'line', alpha: 0.9, pixels_min: 2 },
  tag: { fill: 'tag', pixels_min: 2.5 },
  beacon: { fill: 'beacon', pixels_min: 1 },
  station: { fill: 'held', alpha: 0.6, pixels_min: 3 },
  section: { fill: 'label', alpha: 0.85 },
  label: { fill: 'label' },
};
// Styles of kinds within a layer; a kind that is not listed here has the style of its layer.
const kinds: Readonly<Record<string, keyof Colours>> = { 'line arc': 'arc', 'line clothoid': 'clothoid', 'station charger': 'charger' };
const other: LayerStyle = { fill: 'label', alpha: 0.6, pixels_min: 1 };
export const map_font = 'system-ui, "Segoe UI", Roboto, "Helvetica Neue", sans-serif';

/** Shapes of one layer and size in one cell of the zone, painted together: a zone may have tens of thousands of shapes. */
interface Shape {
  layer: string;
  kind: string;
  shape: Primitive['shape'];
  size_m: number;
  primitives: readonly Primitive[];
  /** for the level of detail at which it was last painted */
  path: Path2D;
  level: number;
  low: Point;
  high: Point;
}
/** Number of grid cells per axis; cells outside the view are skipped. */
const pieces = 12;
/** Lines are painted through points that deviate less than this from them [px]. */
const detail_px = 0.25;
/** Fewer shapes than this are not grouped. */
const gathered_min = 400;

export class ZoneDrawing {
  private readonly context: CanvasRenderingContext2D;
  private size: Size = { width: 0, height: 0 };
  private ratio = 1;
  private shapes: Shape[] = [];
  private zone: Zone | null = null;
  private colours: Colours | null = null;
  private hidden: ReadonlySet<string> = new Set();
  private painted: View | null = null;
  private tracks = new Map<string, Primitive>();
  private closed: readonly string[] = [];

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = context_2d(canvas, { alpha: false });
  }

  resize(size: Size, pixel_ratio: number): void {
    this.size = size;
    this.ratio = pixel_ratio;
    resize_canvas(this.canvas, size, pixel_ratio);
    this.painted = null;
  }

  set_zone(zone: Zone | null): void {
    this.zone = zone;
    this.painted = null;
    const primitives = (zone?.primitives ?? []).filter((p) => p.points.length > 0);
    this.tracks = new Map(primitives.filter((p) => p.layer === 'road' && p.shape === 'polyline' && p.label).map((p) => [p.label!, p]));
    // Layers are painted in the order of their first shape: a road must not cover the centre line of its neighbour.
    const order = new Map([...new Set(primitives.map((p) => p.layer))].map((layer, i) => [layer, i]));
    const sorted = [...primitives].sort((a, b) => order.get(a.layer)! - order.get(b.layer)!);
    this.shapes = zone ? gather(sorted, zone.bounds) : [];
  }

  /** Paints closed sections with dashes across their roads. */
  set_closed(closed: readonly string[]): void {
    if (closed === this.closed || closed.join('\n') === this.closed.join('\n')) return;
    this.closed = closed;
    this.painted = null;
  }

  set_colours(colours: Colours): void {
    this.colours = colours;
    this.painted = null;
  }

  set_hidden(hidden: ReadonlySet<string>): void {
    if (hidden === this.hidden) return;
    this.hidden = hidden;
    this.painted = null;
  }

  /** Repaints the zone if anything has changed. */
  paint(view: View): void {
    const { colours, painted } = this;
    if (!colours || this.size.width === 0) return;
    if (painted && painted.x === view.x && painted.y === view.y && painted.scale === view.scale) return;
    this.painted = view;
    const { context } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = 1;
    context.fillStyle = colours.ground;
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    const visible = this.shapes.filter((shape) => this.visible(shape, view));
    this.paint_shapes(visible, view, colours);
    this.paint_closed(view, colours);
    this.paint_texts(visible, view, colours);
    this.paint_tag_numbers(view, colours);
    context.globalAlpha = 1;
  }

  private visible({ layer, size_m, low, high }: Shape, view: View): boolean {
    if (this.hidden.has(layer)) return false;
    const half_x = this.size.width / 2 / view.scale;
    const half_y = this.size.height / 2 / view.scale;
    const around = size_m + 40 / view.scale;
    return high[0] + around > view.x - half_x && low[0] - around < view.x + half_x && high[1] + around > view.y - half_y && low[1] - around < view.y + half_y;
  }

  private paint_shapes(visible: readonly Shape[], view: View, colours: Colours): void {
    const { context } = this;
    const scale = view.scale * this.ratio;
    // Coordinates and line widths are in map metres, y up.
    context.setTransform(scale, 0, 0, -scale, (this.size.width / 2) * this.ratio - view.x * scale, (this.size.height / 2) * this.ratio + view.y * scale);
    context.lineCap = 'round';
    context.lineJoin = 'round';
    // Kerbs are painted first, under all roads, so that no kerb crosses another road.
    context.strokeStyle = colours.road_edge;
    for (const one of visible) {
      if (one.layer !== 'road' || one.shape !== 'polyline') continue;
      context.lineWidth = Math.max(one.size_m, 2 / view.scale) + 3 / view.scale;
      context.stroke(path_at(one, scale));
    }
    for (const one of visible) {
      const { layer, kind, shape, size_m, primitives } = one;
      if (shape === 'text') continue;
      const path = path_at(one, scale);
      const style = styles[layer] ?? other;
      context.globalAlpha = style.alpha ?? 1;
      const least = (style.pixels_min ?? 0) / view.scale;
      const tint = colours[kinds[`${layer} ${kind}`] ?? style.fill] as string;
      if (shape === 'polyline') {
        context.strokeStyle = tint;
        context.lineWidth = Math.max(size_m, least);
        context.stroke(path);
      } else {
        context.fillStyle = tint;
        context.fill(shape === 'disc' && size_m < least ? path_of(primitives, least) : path);
      }
    }
  }

  private paint_closed(view: View, colours: Colours): void {
    const { context } = this;
    context.globalAlpha = 0.9;
    context.strokeStyle = colours.alarm;
    context.lineCap = 'butt';
    for (const name of this.closed) {
      const track = this.tracks.get(name);
      if (!track || this.hidden.has('road')) continue;
      context.lineWidth = Math.max(0.5 * track.size_m, 3 / view.scale);
      context.setLineDash([7 / view.scale, 5 / view.scale]);
      context.stroke(path_of([track], track.size_m));
    }
    context.setLineDash([]);
  }

  private paint_texts(visible: readonly Shape[], view: View, colours: Colours): void {
    const { context } = this;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.globalAlpha = 1;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    for (const { layer, shape, size_m, primitives } of visible) {
      const pixels = Math.min(size_m * view.scale, 15);
      if (shape !== 'text' || pixels < 7) continue;
      const style = styles[layer] ?? other;
      context.fillStyle = colours[style.text ?? style.fill] as string;
      context.font = `500 ${Math.max(pixels, 10)}px ${map_font}`;
      for (const { label, points } of primitives) {
        const at = to_screen(view, this.size, points[0]![0], points[0]![1]);
        if (label && at.px > -100 && at.py > -20 && at.px < this.size.width + 100 && at.py < this.size.height + 20) context.fillText(label, at.px, at.py);
      }
    }
  }

  /** Paints the number of each tag if there is room. */
  private paint_tag_numbers(view: View, colours: Colours): void {
    const { context } = this;
    if (!this.zone || this.hidden.has('tag') || view.scale < 220) return;
    context.font = `600 10px ${map_font}`;
    context.textAlign = 'left';
    context.textBaseline = 'middle';
    context.fillStyle = colours.label;
    for (const tag of this.zone.tags ?? []) {
      const at = to_screen(view, this.size, tag.x, tag.y);
      if (at.px < -20 || at.py < -20 || at.px > this.size.width || at.py > this.size.height + 20) continue;
      const reach = Math.max(0.02 * view.scale, 2.5);
      context.fillText(String(tag.number), at.px + reach + 2, at.py + reach + 4);
    }
  }
}

/** Groups shapes of the same style and grid cell; a small number of shapes is left ungrouped, in order. */
export function gathered(primitives: readonly Primitive[], [x0, y0, x1, y1]: Zone['bounds']): Primitive[][] {
  if (primitives.length < gathered_min) return primitives.map((one) => [one]);
  const groups = new Map<string, Primitive[]>();
  for (const one of primitives) {
    const { x, y } = centre_of(one.points);
    const column = Math.floor((pieces * (x - x0)) / Math.max(x1 - x0, 1e-9));
    const row = Math.floor((pieces * (y - y0)) / Math.max(y1 - y0, 1e-9));
    const key = `${one.layer} ${one.kind ?? ''} ${one.shape} ${one.size_m} ${column} ${row}`;
    const known = groups.get(key);
    if (known) known.push(one);
    else groups.set(key, [one]);
  }
  // The order of the layers is preserved: all groups of a layer come before those of the next.
  return [...groups.values()];
}

function gather(primitives: readonly Primitive[], bounds: Zone['bounds']): Shape[] {
  return gathered(primitives, bounds).map((group) => {
    const { layer, kind = '', shape, size_m } = group[0]!;
    const { low_x, low_y, high_x, high_y } = box_of(group.flatMap((one) => one.points));
    return { layer, kind, shape, size_m, primitives: group, path: shape === 'text' || shape === 'polyline' ? new Path2D() : path_of(group, size_m), level: NaN, low: [low_x, low_y], high: [high_x, high_y] };
  });
}

/**
 * Without a graphics card a stroke costs as much as its points, most of which are closer together than a pixel when a large
 * zone is shown whole. Each shape has one path, for scales within a factor of two.
 */
function path_at(shape: Shape, scale: number): Path2D {
  const level = level_of(scale);
  if (shape.shape !== 'polyline' || shape.level === level) return shape.path;
  const lines = shape.primitives.map((one) => ({ ...one, points: simplified(one.points, tolerance_of(level)) }));
  shape.path = path_of(lines, shape.size_m);
  shape.level = level;
  return shape.path;
}

/** The level of detail for a scale in device pixels per metre: its power of two, rounded up. */
export function level_of(scale: number): number {
  return Math.ceil(Math.log2(scale));
}
/** The deviation of lines at a level of detail [m]: at most `detail_px` at each of its scales. */
export function tolerance_of(level: number): number {
  return detail_px / 2 ** level;
}

/** @param radius  radius of discs [m] */
function path_of(primitives: readonly Primitive[], radius: number): Path2D {
  const path = new Path2D();
  for (const { shape, points } of primitives) {
    points.forEach(([x, y], i) => {
      if (shape === 'disc') {
        path.moveTo(x + radius, y);
        path.arc(x, y, radius, 0, 2 * Math.PI);
      } else if (i === 0) path.moveTo(x, y);
      else path.lineTo(x, y);
    });
    if (shape === 'polygon') path.closePath();
  }
  return path;
}

export function centre_of(points: readonly Point[]): { x: number; y: number } {
  let x = 0;
  let y = 0;
  for (const point of points) {
    x += point[0] / points.length;
    y += point[1] / points.length;
  }
  return { x, y };
}

export function radius_of(primitive: Primitive): number {
  if (primitive.shape === 'disc') return primitive.size_m;
  const centre = centre_of(primitive.points);
  return primitive.points.reduce((most, [x, y]) => Math.max(most, Math.hypot(x - centre.x, y - centre.y)), 0);
}
