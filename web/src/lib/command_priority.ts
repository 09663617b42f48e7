// Who goes first at a crossing, as the order of a list: the topmost has the highest number.
import type { Row } from './reduce';

export const priority_max = 999;

/** Highest first; of equals, as they are listed. */
export function by_priority(rows: readonly Row[]): Row[] {
  return rows.map((row, i) => ({ row, i })).sort((a, b) => b.row.aiv.priority - a.row.aiv.priority || a.i - b.i).map(({ row }) => row);
}

/** The list with one row taken to another place. */
export function moved<T>(list: readonly T[], from: number, to: number): T[] {
  const next = [...list];
  const [taken] = next.splice(from, 1);
  if (taken !== undefined) next.splice(Math.max(0, Math.min(to, next.length)), 0, taken);
  return next;
}

/** Distinct numbers, the topmost the highest; beyond a thousand vehicles the last share the zero. Only what differs. */
export function priorities_for(order: readonly Row[]): Record<string, number> {
  const top = Math.min(order.length, priority_max);
  const wanted: Record<string, number> = {};
  order.forEach((row, i) => {
    const number = Math.max(0, top - i);
    if (number !== row.aiv.priority) wanted[row.id] = number;
  });
  return wanted;
}

/** What somebody typed; null for what is no priority. */
export function priority_of(text: string): number | null {
  return /^\d{1,3}$/.test(text.trim()) ? Number(text) : null;
}
