// Builds the quads for WebGL, in device pixels, in one buffer that is refilled for each frame. Each corner has eight words, as
// the shaders read them: position, local, extra (two numbers each), style and colour (four bytes each).
import { kind_aiv, kind_person, flag_augmented, flags_kind_mask, flags_status_shift } from '../live/frames';
import type { Positions } from '../live/positions';
import { body_outline, packed, spot_px, type BodiesShown, type BodySize, type Colours, type Line } from './renderer';
import type { Size, View } from './view';

export const words_per_vertex = 8;
export const vertices_per_quad = 4;
export const words_per_quad = words_per_vertex * vertices_per_quad;
const quads_at_first = 2_048;
/** period of the dashes [px]; a solid line has a period that is never reached */
const periods: Readonly<Record<Line, number>> = { solid: 1e6, dashed: 9, dotted: 4.5 };
const status_lost = 5;

export class Quads {
  protected floats = new Float32Array(0);
  protected words = new Uint32Array(0);
  protected capacity = 0;
  protected quads = 0;
  /** range of the vehicles; quads before it are drawn below them, quads after it above */
  protected bodies_from = 0;
  protected bodies_to = 0;
  /** number of vehicles drawn as single triangles: all or none */
  protected spots = 0;
  protected size: Size = { width: 0, height: 0 };
  protected ratio = 1;
  protected body: BodySize = { half_length: 10, half_width: 6, shape_behind: 0, shape_radius: 0 };
  protected dim = false;
  protected colours: Colours | null = null;
  private view: View = { x: 0, y: 0, scale: 1 };
  private states: number[] = [];
  private line = new Float32Array(64);

  constructor() {
    this.make_room(quads_at_first);
  }

  set_colours(colours: Colours): void {
    this.colours = colours;
    this.states = colours.states.map(packed);
  }

  begin(view: View, body: BodySize, dim: boolean): void {
    this.view = view;
    this.body = body;
    this.dim = dim;
    this.quads = this.bodies_from = this.bodies_to = this.spots = 0;
  }

  band(points: ArrayLike<number>, count: number, width_m: number, pixels_min: number, colour: string, alpha: number): void {
    const half = 0.5 * Math.max(width_m * this.view.scale, pixels_min) * this.ratio;
    this.stroke(this.to_pixels(points, count), half, 'solid', style_word(0, 0, alpha), packed(colour));
  }

  /** A fan of narrow kites; at the width of a beam its straight end is not noticeable. */
  sector(x: number, y: number, direction: number, half_angle: number, radius_m: number, colour: string, alpha: number): void {
    const r = radius_m * this.view.scale * this.ratio;
    const px = this.px(x);
    const py = this.py(y);
    const kites = Math.max(1, Math.ceil(half_angle / 0.12));
    const step = (2 * half_angle) / kites;
    const style = style_word(0, 0, 0.7 * alpha);
    const tint = packed(colour);
    for (let k = 0; k < kites; k++) {
      const from = direction - half_angle + k * step;
      const at = (angle: number): [number, number] => [px + r * Math.cos(angle), py - r * Math.sin(angle)];
      this.corners([px, py], at(from), at(from + 0.5 * step), at(from + step), style, tint);
    }
  }

  disc(x: number, y: number, radius_m: number, pixels_min: number, colour: string, alpha: number): void {
    this.round(this.px(x), this.py(y), Math.max(radius_m * this.view.scale, pixels_min) * this.ratio, packed(colour), alpha);
  }

  outline(x: number, y: number, heading: number, grow: number, width: number, line: Line, colour: string): void {
    const c = Math.cos(heading);
    const s = -Math.sin(heading);
    const px = this.px(x);
    const py = this.py(y);
    const points = body_outline(this.body, grow);
    if (this.line.length < points.length) this.line = new Float32Array(2 * points.length);
    for (let i = 0; i < points.length; i += 2) {
      const ahead = points[i]! * this.ratio;
      const aside = points[i + 1]! * this.ratio;
      this.line[i] = px + c * ahead - s * aside;
      this.line[i + 1] = py + s * ahead + c * aside;
    }
    this.stroke(points.length / 2, 0.5 * width * this.ratio, line, style_word(0, 0, 1), packed(colour));
  }

  bodies(positions: Positions, show: BodiesShown, radius_of: (slot: number) => number): void {
    if (!this.colours) return;
    this.make_room(this.quads + positions.count);
    this.bodies_from = this.quads;
    if (this.body.half_width < spot_px) this.put_spots(positions);
    else this.put_bodies(positions);
    this.bodies_to = this.quads;
    for (let i = 0; i < positions.count; i++) this.put_object(positions, i, show, radius_of);
  }

  /** Draws objects other than vehicles, and the cross of a lost vehicle. */
  private put_object(positions: Positions, slot: number, show: BodiesShown, radius_of: (slot: number) => number): void {
    const { colours, ratio, body } = this;
    const flags = positions.flags[slot]!;
    const kind = flags & flags_kind_mask;
    if (!colours || (kind === kind_aiv && flags >> flags_status_shift !== status_lost)) return;
    const px = this.px(positions.x[slot]!);
    const py = this.py(positions.y[slot]!);
    const c = Math.cos(positions.heading[slot]!);
    const s = -Math.sin(positions.heading[slot]!);
    if (kind === kind_aiv) {
      if (body.shape_radius === 0) return;
      const reach = 0.7 * body.shape_radius * ratio;
      const mx = px - c * body.shape_behind * ratio;
      const my = py - s * body.shape_behind * ratio;
      this.dash(mx - reach, my - reach, mx + reach, my + reach, 0.24 * body.shape_radius * ratio, this.states[status_lost]!, 1);
      this.dash(mx - reach, my + reach, mx + reach, my - reach, 0.24 * body.shape_radius * ratio, this.states[status_lost]!, 1);
      return;
    }
    const person = kind === kind_person;
    if (person ? !show.persons : !show.obstacles) return;
    const r = Math.max(radius_of(slot) * this.view.scale, person ? 6 : 5) * ratio;
    const tint = packed(person ? colours.person : colours.obstacle);
    this.round(px, py, r, (flags & flag_augmented) !== 0 ? packed(colours.virtual) : tint, 1);
    this.round(px, py, r - Math.max(1.5 * ratio, 0.16 * r), tint, 1);
    const light = packed(colours.ground);
    // A person's head shows the heading; an obstacle has a bar.
    if (person) this.round(px + 0.3 * r * c, py + 0.3 * r * s, 0.34 * r, light, 1);
    else for (const off of [-0.28 * r, 0.28 * r]) this.dash(px + off - 0.4 * r, py + off + 0.4 * r, px + off + 0.4 * r, py + off - 0.4 * r, 0.09 * r, light, 0.75);
  }

  private put_spots({ x, y, heading, flags, count }: Positions): void {
    const { ratio, view, states, floats, words } = this;
    const scale = view.scale * ratio;
    const centre_x = 0.5 * this.size.width * ratio - view.x * scale;
    const centre_y = 0.5 * this.size.height * ratio + view.y * scale;
    const ahead = this.body.half_length * ratio;
    const aside = 1.3 * this.body.half_width * ratio;
    // Distance of the front from the rear edge, and of each rear corner from the opposite edge.
    const long = 2 * ahead;
    const wide = (4 * ahead * aside) / Math.hypot(2 * ahead, aside);
    const right = this.size.width * ratio + ahead;
    const bottom = this.size.height * ratio + ahead;
    let at = this.quads * words_per_quad;
    let spots = 0;
    for (let i = 0; i < count; i++) {
      const px = centre_x + x[i]! * scale;
      const py = centre_y - y[i]! * scale;
      const flag = flags[i]!;
      if (px < -ahead || py < -ahead || px > right || py > bottom || (flag & flags_kind_mask) !== kind_aiv) continue;
      const state = flag >> flags_status_shift;
      const tint = states[state]!;
      const style = state | ((flag & flag_augmented) << 8) | 0xff000000;
      const c = Math.cos(heading[i]!);
      const s = -Math.sin(heading[i]!);
      const ax = c * ahead;
      const ay = s * ahead;
      const bx = -s * aside;
      const by = c * aside;
      floats[at] = px + ax;
      floats[at + 1] = py + ay;
      floats[at + 2] = long;
      floats[at + 3] = 0;
      floats[at + 4] = 0;
      words[at + 6] = style;
      words[at + 7] = tint;
      floats[at + 8] = px - ax - bx;
      floats[at + 9] = py - ay - by;
      floats[at + 10] = 0;
      floats[at + 11] = wide;
      floats[at + 12] = 0;
      words[at + 14] = style;
      words[at + 15] = tint;
      floats[at + 16] = px - ax + bx;
      floats[at + 17] = py - ay + by;
      floats[at + 18] = 0;
      floats[at + 19] = 0;
      floats[at + 20] = wide;
      words[at + 22] = style;
      words[at + 23] = tint;
      at += 3 * words_per_vertex;
      spots++;
    }
    this.spots = spots;
    this.quads += Math.ceil((3 * spots) / vertices_per_quad);
  }

  private put_bodies({ x, y, heading, flags, count }: Positions): void {
    const { ratio, view, states } = this;
    const scale = view.scale * ratio;
    const centre_x = 0.5 * this.size.width * ratio - view.x * scale;
    const centre_y = 0.5 * this.size.height * ratio + view.y * scale;
    const half_x = this.body.half_length * ratio + 1;
    const half_y = this.body.half_width * ratio + 1;
    const behind = this.body.shape_behind * ratio;
    const reach = Math.max(half_x, half_y) + 2;
    const right = this.size.width * ratio + reach;
    const bottom = this.size.height * ratio + reach;
    const { floats, words } = this;
    let at = this.quads * words_per_quad;
    for (let i = 0; i < count; i++) {
      const px = centre_x + x[i]! * scale;
      const py = centre_y - y[i]! * scale;
      if (px < -reach || py < -reach || px > right || py > bottom) continue;
      const flag = flags[i]!;
      const kind = flag & flags_kind_mask;
      if (kind !== kind_aiv) continue;
      const state = flag >> flags_status_shift;
      const tint = states[state]!;
      const style = state | ((flag & 0x0c) << 8) | 0xff000000;
      const c = Math.cos(heading[i]!);
      const s = -Math.sin(heading[i]!);
      // Screen axes of the body: (c, s) forward, (−s, c) to its right. The centre of the shape is behind that of the body.
      const ax = c * half_x;
      const ay = s * half_x;
      const bx = -s * half_y;
      const by = c * half_y;
      const gx = c * behind;
      const gy = s * behind;
      floats[at] = px - ax - bx;
      floats[at + 1] = py - ay - by;
      floats[at + 2] = -half_x;
      floats[at + 3] = -half_y;
      floats[at + 4] = gx - ax - bx;
      floats[at + 5] = gy - ay - by;
      words[at + 6] = style;
      words[at + 7] = tint;
      floats[at + 8] = px + ax - bx;
      floats[at + 9] = py + ay - by;
      floats[at + 10] = half_x;
      floats[at + 11] = -half_y;
      floats[at + 12] = gx + ax - bx;
      floats[at + 13] = gy + ay - by;
      words[at + 14] = style;
      words[at + 15] = tint;
      floats[at + 16] = px + ax + bx;
      floats[at + 17] = py + ay + by;
      floats[at + 18] = half_x;
      floats[at + 19] = half_y;
      floats[at + 20] = gx + ax + bx;
      floats[at + 21] = gy + ay + by;
      words[at + 22] = style;
      words[at + 23] = tint;
      floats[at + 24] = px - ax + bx;
      floats[at + 25] = py - ay + by;
      floats[at + 26] = -half_x;
      floats[at + 27] = half_y;
      floats[at + 28] = gx - ax + bx;
      floats[at + 29] = gy - ay + by;
      words[at + 30] = style;
      words[at + 31] = tint;
      at += words_per_quad;
    }
    this.quads = at / words_per_quad;
  }

  private px(x: number): number {
    return (0.5 * this.size.width + (x - this.view.x) * this.view.scale) * this.ratio;
  }
  private py(y: number): number {
    return (0.5 * this.size.height - (y - this.view.y) * this.view.scale) * this.ratio;
  }

  private round(px: number, py: number, r: number, tint: number, alpha: number): void {
    const half = r + 1;
    const at = this.quads * words_per_quad;
    this.corners([px - half, py - half], [px + half, py - half], [px + half, py + half], [px - half, py + half], style_word(255, 0, alpha), tint);
    for (let corner = 0; corner < vertices_per_quad; corner++) {
      const word = at + corner * words_per_vertex;
      this.floats[word + 2] = corner === 1 || corner === 2 ? half : -half;
      this.floats[word + 3] = corner >= 2 ? half : -half;
      this.floats[word + 4] = r;
    }
  }

  private dash(ax: number, ay: number, bx: number, by: number, half: number, tint: number, alpha: number): void {
    this.line[0] = ax;
    this.line[1] = ay;
    this.line[2] = bx;
    this.line[3] = by;
    this.stroke(2, half, 'solid', style_word(0, 0, alpha), tint);
  }

  /** The first `count` points of `line` as a band. Adjacent pieces meet on the bisector of each bend, without gap or overlap. */
  private stroke(count: number, half: number, kind: Line, style: number, tint: number): void {
    if (count < 2) return;
    const { line } = this;
    const across = half + 1;
    const period = periods[kind] * this.ratio;
    let nx = 0;
    let ny = 0;
    let ux = 0;
    let uy = 0;
    let along = 0;
    for (let i = 0; i < count; i++) {
      const before_x = nx;
      const before_y = ny;
      let length = 0;
      if (i + 1 < count) {
        const dx = line[2 * i + 2]! - line[2 * i]!;
        const dy = line[2 * i + 3]! - line[2 * i + 1]!;
        length = Math.max(1e-3, Math.hypot(dx, dy));
        nx = -dy / length;
        ny = dx / length;
      }
      let mx = nx;
      let my = ny;
      if (i > 0) {
        const grow = 1 / Math.max(0.5, 1 + before_x * nx + before_y * ny);
        mx = (before_x + nx) * grow;
        my = (before_y + ny) * grow;
        const ax = line[2 * i - 2]!;
        const ay = line[2 * i - 1]!;
        const bx = line[2 * i]!;
        const by = line[2 * i + 1]!;
        const piece = Math.hypot(bx - ax, by - ay);
        const at = this.quads * words_per_quad;
        this.corners(
          [ax - ux * across, ay - uy * across], [bx - mx * across, by - my * across], [bx + mx * across, by + my * across], [ax + ux * across, ay + uy * across], style, tint,
        );
        for (let corner = 0; corner < vertices_per_quad; corner++) {
          const word = at + corner * words_per_vertex;
          this.floats[word + 2] = corner === 1 || corner === 2 ? along + piece : along;
          this.floats[word + 3] = corner >= 2 ? across : -across;
          this.floats[word + 4] = half;
          this.floats[word + 5] = period;
        }
        along += piece;
      }
      ux = mx;
      uy = my;
    }
  }

  /** Converts a line to device pixels and drops coinciding points; returns the number of points left. */
  private to_pixels(points: ArrayLike<number>, count: number): number {
    if (this.line.length < 2 * count) this.line = new Float32Array(4 * count);
    const { line } = this;
    let left = 0;
    for (let i = 0; i < count; i++) {
      const px = this.px(points[2 * i]!);
      const py = this.py(points[2 * i + 1]!);
      if (left > 0 && Math.abs(px - line[2 * left - 2]!) + Math.abs(py - line[2 * left - 1]!) < 0.05) continue;
      line[2 * left] = px;
      line[2 * left + 1] = py;
      left++;
    }
    return left;
  }

  /** Appends a filled quad of one colour, corner by corner; its edge distances may be set afterwards. */
  private corners(a: readonly number[], b: readonly number[], c: readonly number[], d: readonly number[], style: number, tint: number): void {
    if (this.quads >= this.capacity) this.make_room(this.quads + 1);
    const { floats, words } = this;
    let at = this.quads * words_per_quad;
    for (const corner of [a, b, c, d]) {
      floats[at] = corner[0]!;
      floats[at + 1] = corner[1]!;
      floats[at + 2] = 0;
      floats[at + 3] = 0;
      floats[at + 4] = 1;
      floats[at + 5] = periods.solid;
      words[at + 6] = style;
      words[at + 7] = tint;
      at += words_per_vertex;
    }
    this.quads++;
  }

  /** Reserves capacity, which never shrinks, so that frames stop allocating after the largest one. */
  protected make_room(quads: number): void {
    if (quads <= this.capacity) return;
    this.capacity = Math.ceil(quads * 1.5);
    const grown = new Float32Array(this.capacity * words_per_quad);
    grown.set(this.floats.subarray(0, this.quads * words_per_quad));
    this.floats = grown;
    this.words = new Uint32Array(grown.buffer);
  }
}

function style_word(first: number, flags: number, alpha: number): number {
  return (first | (flags << 8) | (Math.round(Math.min(1, Math.max(0, alpha)) * 255) << 24)) >>> 0;
}
