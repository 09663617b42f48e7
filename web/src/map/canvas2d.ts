// The Canvas2D renderer, used without WebGL2 or after its context was lost. It draws the same image path by path and manages
// about two thousand vehicles.
import { kind_aiv, kind_person, flag_augmented, flag_blocked, flags_kind_mask, flags_status_shift } from '../live/frames';
import type { Positions } from '../live/positions';
import { context_2d, resize_canvas } from './canvas';
import { body_outline, state_order, type BodiesShown, type BodySize, type Colours, type Line, type Renderer } from './renderer';
import { state_styles } from '../live/status';
import type { Size, View } from './view';

const dashes: Readonly<Record<Line, number[]>> = { solid: [], dashed: [6, 3], dotted: [1.8, 2.7] };

export class Canvas2dRenderer implements Renderer {
  readonly kind = 'canvas2d';
  private readonly context: CanvasRenderingContext2D;
  private size: Size = { width: 0, height: 0 };
  private ratio = 1;
  private view: View = { x: 0, y: 0, scale: 1 };
  private body: BodySize = { half_length: 10, half_width: 6, shape_behind: 0, shape_radius: 0 };
  private dim = 1;
  private colours: Colours | null = null;
  private shapes: Path2D[] = [];
  private outline_path = new Path2D();
  private nose_path = new Path2D();
  private path_key = '';

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = context_2d(canvas);
  }

  resize(size: Size, pixel_ratio: number): void {
    this.size = size;
    this.ratio = pixel_ratio;
    resize_canvas(this.canvas, size, pixel_ratio);
  }

  set_colours(colours: Colours): void {
    this.colours = colours;
  }

  begin(view: View, body: BodySize, dim: boolean): void {
    this.view = view;
    this.body = body;
    this.dim = dim ? 0.45 : 1;
    const { context } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.pose(0, 0, 1, 0);
    context.globalAlpha = this.dim;
    const key = `${body.half_length} ${body.half_width} ${body.shape_radius}`;
    if (key !== this.path_key) {
      this.path_key = key;
      this.make_paths();
    }
  }

  band(points: ArrayLike<number>, count: number, width_m: number, pixels_min: number, colour: string, alpha: number): void {
    const { context } = this;
    this.pose(0, 0, 1, 0);
    context.beginPath();
    for (let i = 0; i < count; i++) {
      const px = this.px(points[2 * i]!);
      const py = this.py(points[2 * i + 1]!);
      if (i === 0) context.moveTo(px, py);
      else context.lineTo(px, py);
    }
    context.globalAlpha = alpha * this.dim;
    context.lineCap = 'butt';
    context.lineJoin = 'round';
    context.lineWidth = Math.max(width_m * this.view.scale, pixels_min);
    context.strokeStyle = colour;
    context.stroke();
  }

  sector(x: number, y: number, direction: number, half_angle: number, radius_m: number, colour: string, alpha: number): void {
    const { context } = this;
    this.pose(0, 0, 1, 0);
    const px = this.px(x);
    const py = this.py(y);
    context.beginPath();
    context.moveTo(px, py);
    context.arc(px, py, radius_m * this.view.scale, -direction - half_angle, -direction + half_angle);
    context.closePath();
    context.globalAlpha = 0.7 * alpha * this.dim;
    context.fillStyle = colour;
    context.fill();
  }

  disc(x: number, y: number, radius_m: number, pixels_min: number, colour: string, alpha: number): void {
    const { context } = this;
    this.pose(0, 0, 1, 0);
    context.beginPath();
    context.arc(this.px(x), this.py(y), Math.max(radius_m * this.view.scale, pixels_min), 0, 2 * Math.PI);
    context.globalAlpha = alpha * this.dim;
    context.fillStyle = colour;
    context.fill();
  }

  outline(x: number, y: number, heading: number, grow: number, width: number, line: Line, colour: string): void {
    const { context } = this;
    this.pose(this.px(x), this.py(y), Math.cos(heading), -Math.sin(heading));
    const points = body_outline(this.body, grow);
    context.beginPath();
    for (let i = 0; i < points.length; i += 2) context.lineTo(points[i]!, points[i + 1]!);
    context.closePath();
    context.globalAlpha = this.dim;
    context.setLineDash(dashes[line]);
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.stroke();
    context.setLineDash([]);
  }

  bodies(positions: Positions, show: BodiesShown, radius_of: (slot: number) => number): void {
    const { context, colours } = this;
    if (!colours) return;
    context.globalAlpha = this.dim;
    for (let i = 0; i < positions.count; i++) {
      const px = this.px(positions.x[i]!);
      const py = this.py(positions.y[i]!);
      const flags = positions.flags[i]!;
      const kind = flags & flags_kind_mask;
      const reach = kind === kind_aiv ? this.body.half_length : Math.max(6, radius_of(i) * this.view.scale);
      if (px < -reach || py < -reach || px > this.size.width + reach || py > this.size.height + reach) continue;
      const heading = positions.heading[i]!;
      if (kind === kind_aiv) this.vehicle(px, py, heading, flags, colours);
      else if (kind === kind_person ? show.persons : show.obstacles) this.round(px, py, heading, flags, radius_of(i), colours);
    }
  }

  end(): void {
    this.context.globalAlpha = 1;
  }
  close(): void {
    this.context.setTransform(1, 0, 0, 1, 0, 0);
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
  }

  private vehicle(px: number, py: number, heading: number, flags: number, colours: Colours): void {
    const { context, body } = this;
    const state = flags >> flags_status_shift;
    const lost = state === 5;
    const augmented = (flags & flag_augmented) !== 0;
    const tint = colours.states[state]!;
    const c = Math.cos(heading);
    const s = -Math.sin(heading);
    this.pose(px, py, c, s);
    context.fillStyle = lost ? colours.ground : augmented ? colours.virtual : tint;
    context.fill(this.outline_path);
    context.lineWidth = augmented ? Math.max(2.4, 0.15 * body.half_width) : lost ? 1.6 : 1;
    context.strokeStyle = augmented || lost ? tint : colours.ground;
    context.stroke(this.outline_path);
    context.fillStyle = (flags & flag_blocked) !== 0 ? colours.alarm : lost ? tint : colours.on_state;
    context.fill(this.nose_path);
    if (body.shape_radius > 0) {
      this.pose(px - c * body.shape_behind, py - s * body.shape_behind, 1, 0);
      context.fillStyle = lost ? tint : colours.on_state;
      const shape = this.shapes[state]!;
      if (lost) {
        context.strokeStyle = tint;
        context.lineWidth = 2;
        context.stroke(shape);
      } else context.fill(shape);
    }
  }

  private round(px: number, py: number, heading: number, flags: number, radius_m: number, colours: Colours): void {
    const { context } = this;
    const person = (flags & flags_kind_mask) === kind_person;
    const r = Math.max(radius_m * this.view.scale, person ? 6 : 5);
    this.pose(px, py, Math.cos(heading), -Math.sin(heading));
    const edge = Math.max(1.5, 0.16 * r);
    context.beginPath();
    context.arc(0, 0, r - 0.5 * edge, 0, 2 * Math.PI);
    context.fillStyle = person ? colours.person : colours.obstacle;
    context.fill();
    context.lineWidth = edge;
    context.strokeStyle = (flags & flag_augmented) !== 0 ? colours.virtual : context.fillStyle;
    context.stroke();
    context.beginPath();
    context.fillStyle = colours.ground;
    if (person) context.arc(0.3 * r, 0, 0.34 * r, 0, 2 * Math.PI);
    else context.rect(-0.5 * r, -0.1 * r, r, 0.2 * r);
    context.fill();
  }

  private make_paths(): void {
    const { half_length: l, shape_radius } = this.body;
    const outline = new Path2D();
    const points = body_outline(this.body, 0);
    for (let i = 0; i < points.length; i += 2) outline.lineTo(points[i]!, points[i + 1]!);
    outline.closePath();
    this.outline_path = outline;
    const nose = new Path2D();
    nose.moveTo(0.9 * l, 0);
    nose.lineTo(0.56 * l, -0.38 * l);
    nose.lineTo(0.56 * l, 0.38 * l);
    nose.closePath();
    this.nose_path = nose;
    // The state shapes of the tables, given in a box of 16 × 16.
    const scale = shape_radius / 7;
    this.shapes = state_order.map((key) => {
      const path = new Path2D();
      path.addPath(new Path2D(state_styles[key].path), new DOMMatrix([scale, 0, 0, scale, -8 * scale, -8 * scale]));
      return path;
    });
  }

  /** Moves the origin to (px, py) and turns the first axis to (c, s), in screen axes. */
  private pose(px: number, py: number, c: number, s: number): void {
    const { ratio } = this;
    this.context.setTransform(c * ratio, s * ratio, -s * ratio, c * ratio, px * ratio, py * ratio);
  }
  private px(x: number): number {
    return 0.5 * this.size.width + (x - this.view.x) * this.view.scale;
  }
  private py(y: number): number {
    return 0.5 * this.size.height - (y - this.view.y) * this.view.scale;
  }
}
