// lacet4 as defined by the article's item A11: the pose of a track position. Written from the numbers, not from
// CoSiVA's code.
const a = 0.75;
const d = 0.15;
const r = a - d;
const straight_m = 2 * a;
const loop_m = 1.5 * Math.PI * r;
const order = ['east', 'loop_se', 'north', 'loop_ne', 'west', 'loop_nw', 'south', 'loop_sw'];
const starts = {
  east: [-a, -d, 0], loop_se: [a, -d, 0], north: [d, -a, Math.PI / 2], loop_ne: [d, a, Math.PI / 2],
  west: [a, d, Math.PI], loop_nw: [-a, d, Math.PI], south: [-d, a, -Math.PI / 2], loop_sw: [-d, -a, -Math.PI / 2],
};
export const length_of = (section) => (section.startsWith('loop') ? loop_m : straight_m);

/** The pose `s` along a section; beyond its end on the ones that follow. */
export function place(section, s) {
  if (s > length_of(section)) return place(order[(order.indexOf(section) + 1) % order.length], s - length_of(section));
  const [x, y, heading] = starts[section];
  if (!section.startsWith('loop')) return { section, s, x: x + s * Math.cos(heading), y: y + s * Math.sin(heading), heading };
  // Right-hand: the centre lies r to the right of the start.
  const turned = heading - s / r;
  const centre = [x + r * Math.sin(heading), y - r * Math.cos(heading)];
  return { section, s, x: centre[0] - r * Math.sin(turned), y: centre[1] + r * Math.cos(turned), heading: turned };
}
/** Distance from one track position on to another, in driving direction. */
export function way_between(from, to) {
  let sum = to.s - from.s;
  for (let i = order.indexOf(from.section); order[i % order.length] !== to.section; i++) sum += length_of(order[i % order.length]);
  return sum < 0 ? sum + order.reduce((total, name) => total + length_of(name), 0) : sum;
}
