// Priorities at crossings as the order of a list; the topmost vehicle has the highest number.
import type { Row } from '../live/rows';

export const priority_max = 999;

/** Highest priority first; equal priorities keep the order of the list. */
export function by_priority(rows: readonly Row[]): Row[] {
  return rows.map((row, i) => ({ row, i })).sort((a, b) => b.row.aiv.priority - a.row.aiv.priority || a.i - b.i).map(({ row }) => row);
}

/** A copy of the list with one row moved. */
export function moved<T>(list: readonly T[], from: number, to: number): T[] {
  const next = [...list];
  const [taken] = next.splice(from, 1);
  if (taken !== undefined) next.splice(Math.max(0, Math.min(to, next.length)), 0, taken);
  return next;
}

/** The changed priorities for this order: distinct numbers from the top down; beyond a thousand vehicles the last ones get 0. */
export function priorities_for(order: readonly Row[]): Record<string, number> {
  const top = Math.min(order.length, priority_max);
  const wanted: Record<string, number> = {};
  order.forEach((row, i) => {
    const number = Math.max(0, top - i);
    if (number !== row.aiv.priority) wanted[row.id] = number;
  });
  return wanted;
}

/** Parses a typed priority; null if the text is no whole number from 0 to 999. */
export function priority_of(text: string): number | null {
  return /^\d{1,3}$/.test(text.trim()) ? Number(text) : null;
}
