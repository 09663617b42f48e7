// Stops that vehicles have not confirmed, or whose record is not durable.
import type { Command } from './contract';

/** A Stop that is not confirmed after this time is shown. */
export const confirm_ms_max = 500;
/** A Stop whose record is not durable after this time is shown: a disk usually takes a few milliseconds. */
export const durable_ms_max = 250;

/** The response to a Stop, and to the query for it. */
export interface StopResponse {
  id: string;
  durable: boolean;
  /** why it is not durable: "not yet durable" */
  reason?: string;
  /** vehicles to which it is still repeated; absent in the first response */
  unconfirmed?: readonly string[];
}

/** A Stop of this page, as the server last reported it. */
export interface Stop extends StopResponse {
  sent_ms: number;
}

/** The vehicles whose latest Stop is neither confirmed nor lifted, each once, in the order of the commands. */
export function unconfirmed_stops(commands: readonly Command[], now_ms: number): string[] {
  const open = commands.filter(({ command, state, time_ms }) => command === 'stop' && (state === 'issued' || state === 'accepted') && now_ms - time_ms > confirm_ms_max);
  return [...new Set(open.map(({ vehicle }) => vehicle))];
}

/** The Stops of this page, one of them as it is now: one that is durable and confirmed is not listed any more. */
export function updated(stops: readonly Stop[], stop: Stop): readonly Stop[] {
  const others = stops.filter(({ id }) => id !== stop.id);
  const ended = stop.durable && stop.unconfirmed?.length === 0;
  return ended ? others : [...others, stop];
}

/** Why the records of Stops are not durable, each reason once. */
export function reasons_of_stops(stops: readonly Stop[], now_ms: number): string[] {
  const open = stops.filter(({ durable, sent_ms }) => !durable && now_ms - sent_ms > durable_ms_max);
  return [...new Set(open.map(({ reason }) => reason ?? 'not yet durable'))];
}

/** The vehicles that have not confirmed these Stops, each once: known also while there are no snapshots. */
export function unconfirmed_of(stops: readonly Stop[], now_ms: number): string[] {
  const open = stops.filter(({ sent_ms }) => now_ms - sent_ms > confirm_ms_max);
  return [...new Set(open.flatMap(({ unconfirmed }) => unconfirmed ?? []))];
}

/** How many vehicles a text names; the others are counted. */
const named_max = 8;

/** The vehicles of a text: "AIV1, AIV2", or "AIV1 … AIV8 and 492 more". A list of hundreds would cover the page. */
export function few_names(ids: readonly string[]): string {
  const others = ids.length - named_max;
  return ids.slice(0, named_max).join(', ') + (others > 0 ? ` and ${others} more` : '');
}
