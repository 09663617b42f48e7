// The scales of a chart: round steps of values and of times, and the path of a line.

const steps_of_time_s = [1, 2, 5, 10, 30, 60, 120, 300];

/** 1, 2 or 5 times a power of ten: the smallest such step that divides `span` into at most `parts_max` parts. */
export function step_of(span: number, parts_max: number): number {
  const power = 10 ** Math.floor(Math.log10(span / parts_max));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => span / step <= parts_max)!;
}

/** The step between two written times [s]. */
export const time_step_of = (span_s: number, parts_max: number): number => steps_of_time_s.find((step) => span_s / step <= parts_max) ?? span_s;

/** The multiples of a step from `low` to `high`. */
export function ticks_of(low: number, high: number, step: number): number[] {
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.max(0, Math.floor(high / step + 1e-9) - first + 1) }, (_, i) => (first + i) * step);
}

/** An SVG path through all points, or a dot at each of them. */
export const path_of = (points: readonly (readonly [x: number, y: number])[], dots: boolean): string =>
  points.map(([x, y], i) => `${i === 0 || dots ? 'M' : 'L'}${x.toFixed(1)} ${y.toFixed(1)}${dots ? 'h0' : ''}`).join('');
