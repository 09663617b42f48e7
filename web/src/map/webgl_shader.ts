// Each moving object is a quad of two triangles. The distance of a pixel from the object's edges decides its colour, so that
// edges are smooth at every size. Shaders have no branches, because a software rasteriser would pay for them at every pixel
// (one shader for all kinds took three times as long): each kind has a program, and decisions are made per corner.

const head = `#version 300 es
precision highp float;
`;

/** Attributes of a corner, common to all programs. */
const attributes = `
layout(location = 0) in vec2 a_position;    // device pixels, y down
layout(location = 1) in vec2 a_local;    // offset from the centre, along and across the object
layout(location = 2) in vec2 a_extra;    // by program
layout(location = 3) in vec4 a_style;    // round or state, flags, unused, opacity
layout(location = 4) in vec4 a_colour;
uniform vec2 u_size;
uniform float u_dim;
vec4 position() { return vec4(2.0 * a_position.x / u_size.x - 1.0, 1.0 - 2.0 * a_position.y / u_size.y, 0.0, 1.0); }
`;
const distances = `
float cover(float d) { return clamp(0.5 - d, 0.0, 1.0); }
`;

/** Bands and discs. extra: half width, period of the dashes. */
export const line_vertex = `${head}${attributes}
out vec2 v_local;
flat out vec4 v_colour;
flat out vec3 v_line;   // half width, period, whether round
void main() {
  gl_Position = position();
  v_local = a_local;
  v_colour = vec4(a_colour.rgb, 1.0) * a_style.w * u_dim;
  v_line = vec3(a_extra, a_style.x);
}`;
export const line_fragment = `${head}${distances}
in vec2 v_local;
flat in vec4 v_colour;
flat in vec3 v_line;
out vec4 o_colour;
void main() {
  float d = mix(abs(v_local.y), length(v_local), v_line.z) - v_line.x;
  float dash = abs(fract(v_local.x / v_line.y) - 0.5) * v_line.y - 0.17 * v_line.y;
  o_colour = v_colour * cover(d) * clamp(0.5 + dash, 0.0, 1.0);
}`;

/** Thousands of small vehicles: one triangle each, pointing ahead. local and extra: distances from its edges. */
export const spot_vertex = `${head}${attributes}
uniform vec3 u_virtual;
out vec3 v_inside;
flat out vec4 v_fill;
void main() {
  gl_Position = position();
  v_inside = vec3(a_local, a_extra.x);
  v_fill = vec4(a_style.y * 255.0 > 3.5 ? u_virtual : a_colour.rgb, 1.0) * (a_style.w * u_dim);
}`;
export const spot_fragment = `${head}
in vec3 v_inside;
flat in vec4 v_fill;
out vec4 o_colour;
void main() {
  o_colour = v_fill * clamp(0.5 + min(min(v_inside.x, v_inside.y), v_inside.z), 0.0, 1.0);
}`;

/** Vehicles. extra: offset from the centre of the state shape, upright, y down. `plain` omits shapes that are too small. */
export type Detail = 'plain' | 'shaped';
const defines: Readonly<Record<Detail, string>> = { plain: '', shaped: '#define SHAPED\n' };

export const body_vertex = (detail: Detail) => `${head}${defines[detail]}${attributes}
uniform vec2 u_half;
uniform float u_ratio;
uniform vec3 u_ground;
uniform vec3 u_on_state;
uniform vec3 u_virtual;
uniform vec3 u_alarm;
out vec2 v_local;
flat out vec4 v_fill;
flat out vec4 v_edge;    // colour and width of the edge
flat out vec3 v_nose;
#ifdef SHAPED
out vec2 v_shape;
flat out vec3 v_first;   // the shape: two functions of (|x|, |y|, y) below a bound, or a disc
flat out vec3 v_second;
flat out vec2 v_bound;
#endif
void main() {
  gl_Position = position();
  v_local = a_local;
  int state = int(a_style.x * 255.0 + 0.5);
  int flags = int(a_style.y * 255.0 + 0.5);
  bool lost = state == 5;
  bool augmented = (flags & 4) != 0;
  float alpha = a_style.w * u_dim;
  v_fill = vec4(lost ? u_ground : augmented ? u_virtual : a_colour.rgb, alpha);
  v_edge = vec4(augmented || lost ? a_colour.rgb : u_ground, augmented ? max(2.4 * u_ratio, 0.15 * u_half.y) : lost ? 1.6 * u_ratio : u_ratio);
  v_nose = (flags & 8) != 0 ? u_alarm : lost ? a_colour.rgb : u_on_state;
#ifdef SHAPED
  v_shape = a_extra;
  v_first = vec3(1.0, 0.0, 0.0);
  v_second = vec3(0.0, 1.0, 0.0);
  v_bound = vec2(state == 0 ? 0.86 : 0.78, state == 0 ? 1.0 : 0.0);
  if (state == 2) { v_first = vec3(0.866, 0.0, 0.5); v_second = vec3(0.0, 0.0, -1.0); v_bound.x = 0.55; }
  if (state == 3) { v_first = vec3(0.7071, 0.7071, 0.0); v_second = v_first; v_bound.x = 0.74; }
  if (state == 4) { v_first = vec3(0.866, 0.0, -0.5); v_second = vec3(0.0, 0.0, 1.0); v_bound.x = 0.55; }
  if (lost) v_bound.x = -9.0;
#endif
}`;

export const body_fragment = (detail: Detail) => `${head}${defines[detail]}${distances}
in vec2 v_local;
flat in vec4 v_fill;
flat in vec4 v_edge;
flat in vec3 v_nose;
#ifdef SHAPED
in vec2 v_shape;
flat in vec3 v_first;
flat in vec3 v_second;
flat in vec2 v_bound;
uniform float u_shape;
#endif
uniform vec2 u_half;
uniform vec3 u_on_state;
out vec4 o_colour;
// A box with cut rear corners and a narrowed front.
float body(vec2 p) {
  vec2 q = abs(p) - u_half;
  float corner = 0.75 * (q.x + q.y) + 0.2 * u_half.y;
  float front = 0.876 * (p.x + 0.55 * abs(p.y) - u_half.x - 0.1 * u_half.y);
  return max(max(q.x, q.y), max(corner, front));
}
void main() {
  float d = body(v_local);
  float nose = max(0.743 * (v_local.x + 0.9 * abs(v_local.y) - 0.9 * u_half.x), 0.56 * u_half.x - v_local.x);
  vec3 c = mix(v_fill.rgb, v_nose, cover(nose));
#ifdef SHAPED
  vec3 p = vec3(abs(v_shape), v_shape.y);
  float shape = mix(max(dot(v_first, p), dot(v_second, p)), length(v_shape), v_bound.y) - v_bound.x * u_shape;
  c = mix(c, u_on_state, cover(shape));
#endif
  c = mix(v_edge.rgb, c, cover(d + v_edge.a));
  float a = cover(d) * v_fill.a;
  o_colour = vec4(c * a, a);
}`;
