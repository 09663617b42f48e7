// The layout of the sequence diagram: agents as lifelines, messages as arrows, one row each, in the order of the traces.
import type { Trace } from '../live/contract';
import { manufacturer, serial } from '../live/format';
import { note_kind, chunk_rows, proxy_of, type TraceStore } from './store';

export const everybody = '*';
export const row_px = 28;
/** Width of the column of times; a narrow diagram shows minutes and seconds only. */
export const gutter_of = (width_px: number): number => (width_px < narrow_px ? 58 : 92);
export const narrow_px = 440;
const step_min_px = 92;
const margin_px = 14;

/** The displayed name of an agent. */
export function agent_label(name: string): string {
  if (name === everybody) return 'everybody';
  if (manufacturer(name) === '' || !/^CoSiVA(\.virtual)?$/.test(manufacturer(name))) return name;
  return serial(name);
}

export function is_aiv(name: string): boolean {
  return name.includes('/');
}
export function is_virtual(name: string): boolean {
  return manufacturer(name) === 'CoSiVA.virtual';
}

const inner = ['AIV_Server', 'Simulator', 'RTM', 'CircuitFactory', 'Circuit'];

/** The agents in the order of the article: persons and vehicles on the left, the circuit on the right. */
export function in_order(agents: Iterable<string>): string[] {
  const rank = (name: string): number => {
    const at = inner.indexOf(name);
    if (at >= 0) return 10 + at;
    if (name === everybody) return 20;
    if (is_virtual(name)) return 4;
    if (is_aiv(name)) return 3;
    return name === 'physical side' || name === 'emulated world' ? 2 : 1;
  };
  return [...new Set(agents)].sort((a, b) => rank(a) - rank(b) || a.localeCompare(b, 'en', { numeric: true }));
}

export interface Lifeline {
  name: string;
  label: string;
  x: number;
}
/** @param proxied  the agents whose proxies have lifelines, too */
export function lifelines(agents: readonly string[], width_px: number, proxied: ReadonlySet<string>): { lines: Lifeline[]; width_px: number } {
  const names: { name: string; label: string }[] = [];
  const ordered = in_order(agents);
  for (const name of ordered) names.push({ name, label: agent_label(name) });
  const server = names.findIndex(({ name }) => name === 'AIV_Server');
  const proxies = ordered.filter((name) => proxied.has(name)).map((name) => ({ name: proxy_of(name), label: proxy_of(agent_label(name)) }));
  if (server >= 0) names.splice(server, 0, ...proxies);
  const gutter = gutter_of(width_px);
  const widest = Math.max(0, ...names.map(({ label }) => label.length)) * 7 + 22;
  const room = names.length === 0 ? 0 : (width_px - gutter - margin_px) / names.length;
  const step = Math.max(widest, step_min_px, Math.min(room, 260));
  return {
    lines: names.map(({ name, label }, i) => ({ name, label, x: gutter + step * (i + 0.5) })),
    width_px: Math.max(width_px, gutter + step * names.length + margin_px),
  };
}

/** The first lifelines: server, simulator, and as many of these vehicles and the operator as fit without scrolling, at least one vehicle. */
export function first_agents(known: readonly string[], wanted: readonly string[], width_px: number): string[] {
  const room = Math.floor((width_px - gutter_of(width_px) - margin_px) / step_min_px);
  const vehicles = wanted.filter((id) => known.includes(id)).slice(0, Math.max(1, Math.min(5, room - 2)));
  return [...vehicles, ...(room > vehicles.length + 2 ? ['operator'] : []), 'AIV_Server', 'Simulator'].filter((name) => known.includes(name));
}

export interface Leg {
  x0: number;
  x1: number;
  /** true for a message over the broker, false within the server */
  radio: boolean;
}
export interface Arrow extends Trace {
  seq: number;
  /** empty if sender or receiver has no lifeline */
  legs: Leg[];
  note: boolean;
}

/** The arrow of one row. */
export function arrow_of(store: TraceStore, seq: number, lines: readonly Lifeline[]): Arrow {
  const trace = store.trace(seq);
  const x_of = (name: string) => lines.find((line) => line.name === name)?.x;
  const legs: Leg[] = [];
  const x0 = x_of(trace.from);
  const x1 = x_of(trace.to);
  if (x0 !== undefined && x1 !== undefined) {
    const through = trace.via === undefined ? undefined : x_of(trace.via);
    const radio = trace.via !== undefined || trace.to === everybody || (is_aiv(trace.from) && is_aiv(trace.to));
    const comes = trace.via === proxy_of(trace.from);
    if (through === undefined) legs.push({ x0, x1, radio });
    else legs.push({ x0, x1: through, radio: comes }, { x0: through, x1, radio: !comes });
  }
  return { ...trace, seq, legs, note: store.is_note(seq) };
}

export type FigureName = 'figure 8' | 'figure 9' | 'figure 11';
export interface Figure {
  name: FigureName;
  title: string;
  /** describes the figure of the article and its equivalent here */
  text: string;
  /** hint for the user if the store has no such exchange */
  missing: string;
}

export const figures: readonly Figure[] = [
  {
    name: 'figure 8',
    title: 'Figure 8: the circuit is created and displayed',
    text: 'The server passes the zone’s configuration to the simulator, which creates the RTM and requests the circuit factory from it, the circuit from the factory, and the drawing from the circuit.',
    missing: 'No zone has been instantiated within the stored messages. This happens once at the start, and after every edit of the zone.',
  },
  {
    name: 'figure 9',
    title: 'Figure 9: an AIV starts',
    text: 'An AIV connects; its reports pass through its proxy to the server, which makes the simulator assign a display number and a position; then it reports at regular intervals.',
    missing: 'No AIV has appeared within the stored messages. Add a virtual AIV, or switch one on.',
  },
  {
    name: 'figure 11',
    title: 'Figure 11: a position is updated',
    text: 'A report arrives, and the simulator moves the twin along the circuit’s sections. The response of a section is traced when the twin enters a new one.',
    missing: 'No AIV has reported a position yet.',
  },
];

export interface Exchange {
  agents: string[];
  seqs: number[];
  proxies: boolean;
}

/** The latest exchange of this kind in the store, optionally of one AIV. */
export function find_figure(store: TraceStore, name: FigureName, aiv: string | null = null): Exchange | null {
  if (name === 'figure 8') return zone_exchange(store);
  return name === 'figure 9' ? start_exchange(store, aiv) : position_exchange(store, aiv);
}

/** The rows between two sequence numbers that `wanted` accepts, at most `count_max`. */
function rows(store: TraceStore, begin: number, end: number, count_max: number, wanted: (from: string, to: string, kind: string, seq: number) => boolean): number[] {
  const found: number[] = [];
  for (let seq = Math.max(begin, store.first); seq < Math.min(end, store.end) && found.length < count_max; seq++) {
    const chunk = store.chunk_at(seq);
    const i = seq % chunk_rows;
    if (chunk.kind[i] === note_kind) continue;
    if (wanted(store.agents.name(chunk.from[i]!), store.agents.name(chunk.to[i]!), store.kinds.name(chunk.kind[i]!), seq)) found.push(seq);
  }
  return found;
}

function agents_of(store: TraceStore, seqs: readonly number[]): string[] {
  return in_order(seqs.flatMap((seq) => [store.from(seq), store.to(seq)]));
}

function zone_exchange(store: TraceStore): Exchange | null {
  const handed = store.find_last({ kind: 'zoneConfiguration' });
  if (handed < 0) return null;
  const received = store.find_last({ kind: 'zone', to: 'AIV_Server' }, handed);
  // The last received zone may belong to an earlier exchange, because a zone edit creates a configuration in the server.
  const begin = received > store.find_last({ kind: 'zoneConfiguration' }, handed) ? received : handed;
  const cast = new Set(['physical side', 'operator', ...inner]);
  let done = false;
  const seqs = rows(store, begin, handed + 500, 40, (from, to, kind, seq) => {
    if (done || !cast.has(from) || !cast.has(to) || (seq > begin && kind === 'zone')) return false;
    const inside = seq <= handed || (from !== 'AIV_Server' && to !== 'AIV_Server');
    if (inside && ((from === 'Circuit' && kind === 'draw') || kind === 'refused')) done = true;
    return inside && (seq >= handed || kind === 'zone');
  });
  return { agents: agents_of(store, seqs), seqs, proxies: false };
}

/** The vehicle of "CoSiVA/AIV1 gets display number 1" or "CoSiVA/AIV1 is back under display number 1"; null for an obstacle. */
function who_appears(content: string): string | null {
  return /^(\S+\/\S+) (?:gets|is back under) display number/.exec(content)?.[1] ?? null;
}

/** Messages between vehicles and about crossings, which none of the figures shows. */
const v2x_kinds = new Set(['V2X', 'convoy']);

function start_exchange(store: TraceStore, aiv: string | null): Exchange | null {
  let appears = store.find_last({ kind: 'appear' });
  const fits = (content: string) => (aiv === null ? who_appears(content) !== null : who_appears(content) === aiv);
  while (appears >= 0 && !fits(store.content(appears))) appears = store.find_last({ kind: 'appear' }, appears);
  if (appears < 0) return null;
  const who = who_appears(store.content(appears))!;
  const online = store.find_last({ kind: 'connection', from: who }, appears + 1);
  const begin = online >= 0 ? online : appears;
  const of_who = (from: string, to: string, kind: string) => (from === who || to === who) && !v2x_kinds.has(kind);
  const before = rows(store, begin, appears, 30, of_who);
  // The rows after the appearance: messages to the vehicle and its first reports.
  const after = rows(store, appears, appears + 20_000, 12, (from, to, kind, seq) => seq === appears || of_who(from, to, kind) || (kind === 'position' && store.content(seq).startsWith(`${who} `)));
  const seqs = [...before, ...after];
  return { agents: agents_of(store, seqs), seqs, proxies: true };
}

const section_kinds = new Set(['nextAIVposition', 'position']);

function latest_report(store: TraceStore, aiv: string | null, before = store.end): number {
  for (let seq = before - 1; seq >= store.first; seq--) {
    const kind = store.kind(seq);
    const from = store.from(seq);
    if ((kind === 'visualization' || kind === 'state') && (aiv === null ? is_aiv(from) : from === aiv)) return seq;
  }
  return -1;
}

/** The last response of a section for this AIV, or for any. */
function latest_response(store: TraceStore, aiv: string | null): number {
  let response = store.find_last({ kind: 'position', from: 'Circuit' });
  while (response >= 0 && aiv !== null && !store.content(response).startsWith(`${aiv} `)) response = store.find_last({ kind: 'position', from: 'Circuit' }, response);
  return response;
}

function position_exchange(store: TraceStore, aiv: string | null): Exchange | null {
  const response = latest_response(store, aiv);
  const last = latest_report(store, response < 0 ? aiv : store.content(response).split(' ', 1)[0]!);
  if (last < 0) return null;
  const who = store.from(last);
  // The report that moved the twin to a new section, its predecessor and its successor, which show the reporting interval.
  // Without a response of a section, the last three reports.
  const taken = response < 0 ? latest_report(store, who, last) : latest_report(store, who, response);
  const before = taken < 0 ? -1 : latest_report(store, who, taken);
  const begin = before >= 0 ? before : taken >= 0 ? taken : last;
  let reports = 0;
  const seqs = rows(store, begin, store.end, 40, (from, _to, kind, seq) => {
    const after = seq > Math.max(taken, response);
    if (from === who && kind !== 'virtual_obstacles_ack' && !v2x_kinds.has(kind)) return reports < 3 && (kind === 'visualization' || kind === 'state' ? ++reports > 0 : true);
    return !after && section_kinds.has(kind) && store.content(seq).startsWith(`${who} `);
  });
  return { agents: agents_of(store, seqs), seqs, proxies: true };
}
