// Formats a message as lines, with short objects on one line. Each line carries the path of its value, so that errors and
// changes can be marked in place.
import { is_object, type Json } from './json';
import { join } from './schema';

export interface Token {
  is: 'key' | 'string' | 'number' | 'word' | 'sign';
  text: string;
}
export interface Line {
  depth: number;
  /** path of the value that begins on this line; null for a closing bracket */
  path: string | null;
  tokens: Token[];
}

const inline_max = 66;

/** @param apart  paths that need a line of their own, because they will be marked */
export function lines_of(value: Json, apart: ReadonlySet<string> = new Set()): Line[] {
  const lines: Line[] = [];
  add(lines, value, '', 0, null, '', apart);
  return lines;
}

function add(lines: Line[], value: Json, path: string, depth: number, key: string | null, end: string, apart: ReadonlySet<string>): void {
  const before: Token[] = key === null ? [] : [{ is: 'key', text: JSON.stringify(key) }, { is: 'sign', text: ': ' }];
  const after: Token[] = end === '' ? [] : [{ is: 'sign', text: end }];
  const entries = entries_of(value);
  if (entries === null || entries.length === 0 || fits_one_line(value, path, depth, key, apart)) {
    lines.push({ depth, path, tokens: [...before, ...inline(value), ...after] });
    return;
  }
  const [open, close] = is_object(value) ? ['{', '}'] : ['[', ']'];
  lines.push({ depth, path, tokens: [...before, { is: 'sign', text: open! }] });
  entries.forEach(([step, one], i) => add(lines, one, join(path, step), depth + 1, typeof step === 'string' ? step : null, i < entries.length - 1 ? ',' : '', apart));
  lines.push({ depth, path: null, tokens: [{ is: 'sign', text: close! }, ...after] });
}

function entries_of(value: Json): [string | number, Json][] | null {
  if (Array.isArray(value)) return value.map((one, i) => [i, one]);
  return is_object(value) ? Object.entries(value) : null;
}

/** Whether a value fits on one line. The message itself never does, so that each of its fields has a line. */
function fits_one_line(value: Json, path: string, depth: number, key: string | null, apart: ReadonlySet<string>): boolean {
  if (depth === 0) return false;
  const flat = (one: Json, at: string): boolean => {
    if (apart.has(at)) return false;
    return (entries_of(one) ?? []).every(([step, part]) => flat(part, join(at, step)) && (entries_of(part)?.length ?? 0) === 0);
  };
  const whole = (entries_of(value) ?? []).every(([step, part]) => flat(part, join(path, step)) && (entries_of(part)?.length ?? 0) === 0);
  return whole && JSON.stringify(value).length + (key?.length ?? 0) + 2 * depth <= inline_max;
}

function inline(value: Json): Token[] {
  if (typeof value === 'string') return [{ is: 'string', text: JSON.stringify(value) }];
  if (typeof value === 'number') return [{ is: 'number', text: String(value) }];
  if (typeof value === 'boolean' || value === null) return [{ is: 'word', text: String(value) }];
  const [open, close] = is_object(value) ? ['{', '}'] : ['[', ']'];
  const tokens: Token[] = [{ is: 'sign', text: open! }];
  entries_of(value)!.forEach(([step, one], i) => {
    if (i > 0) tokens.push({ is: 'sign', text: ', ' });
    if (typeof step === 'string') tokens.push({ is: 'key', text: JSON.stringify(step) }, { is: 'sign', text: ': ' });
    tokens.push(...inline(one));
  });
  tokens.push({ is: 'sign', text: close! });
  return tokens;
}
