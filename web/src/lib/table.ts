// The table of the states of AIVs: its columns, and pure functions that search, sort, choose and export it.
import { default_limits, type ContractLimits } from './contract';
import * as format from './format';
import { mission_note, type Row } from './reduce';
import { looks } from './status';
import type { Series } from './table_history';

export interface Column {
  key: string;
  title: string;
  /** what the heading stands for, when it is short */
  what: string;
  width_px: number;
  number?: true;
  /** what the row shows, and what is exported */
  text(row: Row): string;
  /** what it is sorted by; null goes last either way */
  order(row: Row): string | number | null;
  /** the exported value, where it is more exact than the text */
  exact?(row: Row): string | number | null;
  /** its last minute is drawn beside it */
  series?: Series;
  /** 1 is shown always; the highest numbers go first where there is little room */
  rank: number;
}

const yes = (value: boolean, word: string) => (value ? word : '');
const lost = (row: Row) => row.state === 'lost';

/** What holds it: a virtual body, a crossing or a vehicle ahead, an obstacle. */
export function holds_of(row: Row): string {
  if (row.aiv.feels) return `feels ${row.aiv.feels}`;
  if (row.aiv.waitsFor) return `waits for ${row.aiv.waitsFor.replace(/[^\s,/]+\//g, '')}`;
  return row.aiv.fieldViolation ? 'obstacle ahead' : '';
}

export function mission_of({ aiv }: Row): string {
  if (aiv.parked) return 'parked';
  const note = mission_note(aiv);
  if (note !== '' || !aiv.mission) return note;
  return aiv.mission.loop ? `circulates on ${aiv.mission.loop}` : 'circulates';
}

export function contract_of(row: Row): string {
  const { matched, divergence, age } = row.aiv.contract;
  if (row.aiv.augmented) return 'virtual';
  const broken = [yes(!matched, 'matched'), yes(!divergence, 'divergence'), yes(!age, 'age')].filter((word) => word !== '');
  return broken.length === 0 ? 'kept' : `not ${broken.join(', ')}`;
}

/** How far its way is kept free before it, along what it reserved [m]. */
export function reserved_length(row: Row): number {
  const points = row.aiv.reserved ?? [];
  let length = 0;
  for (let i = 1; i < points.length; i++) length += Math.hypot(points[i]![0] - points[i - 1]![0], points[i]![1] - points[i - 1]![1]);
  return length;
}

const connection_words = { ONLINE: 'online', OFFLINE: 'offline', CONNECTIONBROKEN: 'broken' } as const;
const state_order = ['lost', 'stopped', 'slow', 'normal', 'medium', 'fast'];

export const columns: readonly Column[] = [
  { key: 'number', title: 'No.', what: 'Number', width_px: 40, number: true, rank: 1, text: (row) => row.mark, order: (row) => row.aiv.number + (row.aiv.augmented ? 1e6 : 0) },
  { key: 'name', title: 'Name', what: 'Name', width_px: 84, rank: 1, text: (row) => row.name, order: (row) => row.name, exact: (row) => row.id },
  { key: 'state', title: 'State', what: 'State', width_px: 120, rank: 1, text: (row) => looks[row.state].word, order: (row) => state_order.indexOf(row.state) },
  { key: 'speed', title: 'Speed', what: 'Speed, with its last minute', width_px: 108, number: true, rank: 2, series: 'speed', text: (row) => format.speed(row.aiv.speed), order: (row) => row.aiv.speed, exact: (row) => row.aiv.speed },
  { key: 'section', title: 'Section', what: 'Section, and distance on it', width_px: 112, rank: 2, text: (row) => (row.aiv.section === null ? 'off the circuit' : `${row.aiv.section} ${format.metres(row.aiv.s)}`), order: (row) => (row.aiv.section === null ? null : `${row.aiv.section} ${String(Math.round(1000 * (row.aiv.s ?? 0))).padStart(9, '0')}`) },
  { key: 'tag', title: 'Last tag', what: 'Last tag, and distance since', width_px: 92, rank: 4, text: (row) => (row.aiv.lastTag === null ? format.none : `${row.aiv.lastTag}${row.aiv.sinceTag_m === null ? '' : ` + ${format.metres(row.aiv.sinceTag_m)}`}`), order: (row) => row.aiv.lastTag },
  { key: 'battery', title: 'Battery', what: 'Battery', width_px: 62, number: true, rank: 3, text: (row) => format.percent(row.aiv.battery), order: (row) => row.aiv.battery, exact: (row) => row.aiv.battery },
  { key: 'divergence', title: 'Divergence', what: 'Distance of the twin from the report, with its last minute', width_px: 116, number: true, rank: 2, series: 'divergence', text: (row) => (lost(row) ? format.none : format.length(row.aiv.divergence_m)), order: (row) => (lost(row) ? null : row.aiv.divergence_m), exact: (row) => row.aiv.divergence_m },
  { key: 'age', title: 'Age', what: 'Age of the last report, with its last minute', width_px: 104, number: true, rank: 3, series: 'age', text: (row) => (lost(row) ? format.lasting(row.aiv.age_ms) : format.duration(row.aiv.age_ms)), order: (row) => row.aiv.age_ms, exact: (row) => row.aiv.age_ms },
  { key: 'holds', title: 'Waits, feels', what: 'What holds it: a crossing, a vehicle, a virtual body', width_px: 120, rank: 4, text: holds_of, order: (row) => holds_of(row) || null },
  { key: 'mission', title: 'Mission', what: 'Where it was sent, or that it circulates', width_px: 110, rank: 5, text: mission_of, order: (row) => mission_of(row) || null },
  { key: 'connection', title: 'Link', what: 'Connection', width_px: 64, rank: 5, text: (row) => connection_words[row.aiv.connection], order: (row) => row.aiv.connection },
  { key: 'contract', title: 'Contract', what: 'Contract of the bijection over the last ten seconds', width_px: 84, rank: 4, text: contract_of, order: contract_of },
  { key: 'order', title: 'Order', what: 'Order and update', width_px: 110, rank: 6, text: (row) => (row.aiv.orderId === '' ? 'none' : `${row.aiv.orderId} · ${row.aiv.orderUpdateId}`), order: (row) => row.aiv.orderId || null },
  { key: 'reserved', title: 'Reserved', what: 'Length of the way that is kept free before it', width_px: 72, number: true, rank: 6, text: (row) => (reserved_length(row) === 0 ? format.none : format.metres(reserved_length(row))), order: reserved_length, exact: reserved_length },
  { key: 'priority', title: 'Priority', what: 'Priority at crossings', width_px: 64, number: true, rank: 7, text: (row) => String(row.aiv.priority), order: (row) => row.aiv.priority },
  { key: 'position', title: 'Position', what: 'Position of the twin, x and y [m]', width_px: 116, number: true, rank: 8, text: (row) => `${row.aiv.x.toFixed(3)}, ${row.aiv.y.toFixed(3)}`, order: (row) => row.aiv.x },
];

/** What is searched: whatever names a vehicle or says where and how it is. All words must be found. */
export function matches(row: Row, filter: string): boolean {
  const text = `${row.id} ${row.mark} ${looks[row.state].word} ${row.aiv.section ?? 'off the circuit'} ${row.note} ${row.aiv.augmented ? 'virtual' : ''} ${row.alarms.length > 0 ? 'alarm' : ''}`.toLowerCase();
  return filter.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

/** @param sort  a column's key, with a minus before it for descending; an unknown one leaves the order by number */
export function sorted(rows: readonly Row[], sort: string): Row[] {
  const down = sort.startsWith('-') ? -1 : 1;
  const column = columns.find((one) => one.key === sort.replace(/^-/, ''));
  const list = rows.map((row, i) => ({ row, i, by: column?.order(row) ?? null }));
  list.sort((a, b) => {
    if (a.by === b.by) return a.i - b.i;
    if (a.by === null) return 1;
    if (b.by === null) return -1;
    return down * (a.by < b.by ? -1 : 1);
  });
  return list.map(({ row }) => row);
}

/** In the order in which they stood before, whatever has changed in them; those that have come since at the end. */
export function sorted_like(before: readonly Row[], rows: readonly Row[]): Row[] {
  const place = new Map(before.map(({ id }, i) => [id, i]));
  return [...rows].sort((a, b) => (place.get(a.id) ?? before.length) - (place.get(b.id) ?? before.length));
}

/** The heading was pressed: first one way, then the other. */
export function sort_after(sort: string, key: string): string {
  return sort === key ? `-${key}` : key;
}

/** As many columns as there is room for, the least important left out; those that somebody chose stay or go as chosen. */
export function columns_in(room_px: number, chosen: Readonly<Record<string, boolean>>): readonly Column[] {
  const wanted = new Set(columns.filter((column) => chosen[column.key] ?? true));
  let width = 0;
  for (const column of wanted) width += column.width_px;
  const leaving = [...wanted].filter((column) => column.rank > 1 && chosen[column.key] === undefined).sort((a, b) => b.rank - a.rank);
  for (const column of leaving) {
    if (width <= room_px) break;
    wanted.delete(column);
    width -= column.width_px;
  }
  return columns.filter((column) => wanted.has(column));
}

/** RFC 4180, all columns, exact values: for a spreadsheet or a script. */
export function csv_of(rows: readonly Row[]): string {
  const quoted = (value: string | number | null) => {
    const text = value === null ? '' : String(value).replaceAll('\u202f', ' ');
    // A cell that starts like a formula would be run by a spreadsheet: names come from vehicles of any make.
    const safe = typeof value === 'string' && /^[=+@\t\r-]/.test(text) ? `'${text}` : text;
    return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
  };
  const units: Record<string, string> = { speed: 'speed_mps', divergence: 'divergence_m', age: 'age_ms', battery: 'battery_percent', reserved: 'reserved_m', name: 'id' };
  const head = columns.map((column) => units[column.key] ?? column.key);
  return [head, ...rows.map((row) => columns.map((column) => quoted(column.exact ? column.exact(row) : column.text(row))))].map((cells) => cells.join(',')).join('\r\n') + '\r\n';
}

/** Is the cell's value abnormal? Only then it has a colour. */
export function abnormal(column: Column, row: Row, limits: ContractLimits = default_limits): boolean {
  switch (column.key) {
    case 'divergence':
      return !lost(row) && row.aiv.divergence_m > limits.divergence_p99_m;
    case 'age':
      return lost(row) || row.aiv.age_ms > limits.age_p99_ms;
    case 'battery':
      return row.aiv.battery !== null && row.aiv.battery < 20;
    case 'connection':
      return row.aiv.connection === 'CONNECTIONBROKEN';
    case 'contract':
      return !row.aiv.augmented && contract_of(row) !== 'kept';
    case 'section':
      return row.aiv.section === null;
    default:
      return false;
  }
}
