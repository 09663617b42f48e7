// The table of the states of AIVs: its columns, their order, the choice of visible columns and the CSV export.
import { default_limits, type ContractLimits } from '../live/contract';
import * as format from '../live/format';
import { mission_note, type Row } from '../live/rows';
import { state_styles } from '../live/status';
import type { Series } from '../live/history';

export interface Column {
  key: string;
  title: string;
  /** the full text of a short heading */
  what: string;
  width_px: number;
  number?: true;
  /** the displayed text, also exported */
  text(row: Row): string;
  /** the sort key; null comes last in both directions */
  order(row: Row): string | number | null;
  /** the exported value, if it is more exact than the text */
  exact?(row: Row): string | number | null;
  /** history drawn next to the text, over the last minute */
  series?: Series;
}

const yes = (value: boolean, word: string) => (value ? word : '');
const lost = (row: Row) => row.state === 'lost';

/** What the vehicle waits for: a virtual object, a crossing or vehicle ahead, an obstacle. */
export function holds_of(row: Row): string {
  if (row.aiv.brakingFor) return `brakingFor ${row.aiv.brakingFor}`;
  if (row.aiv.waitsFor) return `waits for ${row.aiv.waitsFor.replace(/[^\s,/]+\//g, '')}`;
  return row.aiv.fieldViolation ? 'obstacle ahead' : '';
}

export function mission_of({ aiv }: Row): string {
  if (aiv.offRoute) return 'offRoute';
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

/** Length of the reserved path ahead of the vehicle [m]. */
export function reserved_length(row: Row): number {
  const points = row.aiv.reserved ?? [];
  let length = 0;
  for (let i = 1; i < points.length; i++) length += Math.hypot(points[i]![0] - points[i - 1]![0], points[i]![1] - points[i - 1]![1]);
  return length;
}

const connection_words = { ONLINE: 'online', OFFLINE: 'offline', CONNECTIONBROKEN: 'broken' } as const;
const state_order = ['lost', 'stopped', 'slow', 'normal', 'medium', 'fast'];

export const columns: readonly Column[] = [
  { key: 'number', title: 'No.', what: 'Number', width_px: 58, number: true, text: (row) => row.label, order: (row) => row.aiv.number + (row.aiv.augmented ? 1e6 : 0) },
  { key: 'name', title: 'Name', what: 'Name', width_px: 84, text: (row) => row.name, order: (row) => row.name, exact: (row) => row.id },
  { key: 'state', title: 'State', what: 'State', width_px: 120, text: (row) => state_styles[row.state].word, order: (row) => state_order.indexOf(row.state) },
  { key: 'speed', title: 'Speed', what: 'Speed, with its last minute', width_px: 108, number: true, series: 'speed', text: (row) => format.speed(row.aiv.speed), order: (row) => row.aiv.speed, exact: (row) => row.aiv.speed },
  { key: 'section', title: 'Section', what: 'Section, and distance on it', width_px: 132, text: (row) => (row.aiv.section === null ? 'off the circuit' : `${row.aiv.section} ${format.metres(row.aiv.s)}`), order: (row) => (row.aiv.section === null ? null : `${row.aiv.section} ${String(Math.round(1000 * (row.aiv.s ?? 0))).padStart(9, '0')}`) },
  { key: 'tag', title: 'Last tag', what: 'Last tag, and distance since', width_px: 112, text: (row) => (row.aiv.lastTag === null ? format.none : `${row.aiv.lastTag}${row.aiv.sinceTag_m === null ? '' : ` + ${format.metres(row.aiv.sinceTag_m)}`}`), order: (row) => row.aiv.lastTag },
  { key: 'battery', title: 'Battery', what: 'Battery', width_px: 84, number: true, text: (row) => format.percent(row.aiv.battery), order: (row) => row.aiv.battery, exact: (row) => row.aiv.battery },
  { key: 'divergence', title: 'Divergence', what: 'Distance of the twin from the report, with its last minute', width_px: 116, number: true, series: 'divergence', text: (row) => (lost(row) ? format.none : format.length(row.aiv.divergence_m)), order: (row) => (lost(row) ? null : row.aiv.divergence_m), exact: (row) => row.aiv.divergence_m },
  { key: 'age', title: 'Age', what: 'Age of the last report, with its last minute', width_px: 108, number: true, series: 'age', text: (row) => (lost(row) ? format.lasting(row.aiv.age_ms) : format.duration(row.aiv.age_ms)), order: (row) => row.aiv.age_ms, exact: (row) => row.aiv.age_ms },
  { key: 'holds', title: 'Waits, brakingFor', what: 'Cause of a stop: a crossing, a vehicle, a virtual body', width_px: 150, text: holds_of, order: (row) => holds_of(row) || null },
  { key: 'mission', title: 'Mission', what: 'Its destination, or that it circulates', width_px: 140, text: mission_of, order: (row) => mission_of(row) || null },
  { key: 'connection', title: 'Link', what: 'Connection', width_px: 68, text: (row) => connection_words[row.aiv.connection], order: (row) => row.aiv.connection },
  { key: 'contract', title: 'Contract', what: 'Contract of the bijection, with violations of the last seconds', width_px: 92, text: contract_of, order: contract_of },
  { key: 'order', title: 'Order', what: 'Order and update', width_px: 150, text: (row) => (row.aiv.orderId === '' ? 'none' : `${row.aiv.orderId} · ${row.aiv.orderUpdateId}`), order: (row) => row.aiv.orderId || null },
  { key: 'reserved', title: 'Reserved', what: 'Length of the path reserved ahead of it', width_px: 96, number: true, text: (row) => (reserved_length(row) === 0 ? format.none : format.metres(reserved_length(row))), order: reserved_length, exact: reserved_length },
  { key: 'priority', title: 'Priority', what: 'Priority at crossings', width_px: 86, number: true, text: (row) => String(row.aiv.priority), order: (row) => row.aiv.priority },
  { key: 'position', title: 'Position', what: 'Position of the twin, x and y [m]', width_px: 116, number: true, text: (row) => `${row.aiv.x.toFixed(3)}, ${row.aiv.y.toFixed(3)}`, order: (row) => row.aiv.x },
];

/** @param sort  key of a column, with a minus sign in front for descending order; an unknown key keeps the order by number */
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

/** The new rows in the order of `before`, whatever their values; rows without a predecessor come last. */
export function sorted_like(before: readonly Row[], rows: readonly Row[]): Row[] {
  const index = new Map(before.map(({ id }, i) => [id, i]));
  return [...rows].sort((a, b) => (index.get(a.id) ?? before.length) - (index.get(b.id) ?? before.length));
}

/** The sort after a press on a heading: ascending, then descending. */
export function sort_after(sort: string, key: string): string {
  return sort === key ? `-${key}` : key;
}

/** All columns but those that the user has hidden; a narrow frame scrolls. */
export const columns_of = (shown: Readonly<Record<string, boolean>>): readonly Column[] => columns.filter(({ key }) => shown[key] ?? true);

/** CSV (RFC 4180) of all columns with exact values, for spreadsheets and scripts. */
export function csv_of(rows: readonly Row[]): string {
  const quoted = (value: string | number | null) => {
    const text = value === null ? '' : String(value).replaceAll('\u202f', ' ');
    // A spreadsheet would evaluate a cell that starts like a formula, and third-party vehicles choose their names.
    const safe = typeof value === 'string' && /^[=+@\t\r-]/.test(text) ? `'${text}` : text;
    return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
  };
  const units: Record<string, string> = { speed: 'speed_mps', divergence: 'divergence_m', age: 'age_ms', battery: 'battery_percent', reserved: 'reserved_m', name: 'id' };
  const head = columns.map((column) => units[column.key] ?? column.key);
  return [head, ...rows.map((row) => columns.map((column) => quoted(column.exact ? column.exact(row) : column.text(row))))].map((cells) => cells.join(',')).join('\r\n') + '\r\n';
}

/** Whether the value of a cell is abnormal; only such cells are coloured. */
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
