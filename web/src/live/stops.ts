// Stops that vehicles have not confirmed.
import type { Command } from './contract';

/** A Stop that is not confirmed after this time is shown. */
export const confirm_ms_max = 500;

/** The vehicles whose latest Stop is neither confirmed nor lifted, each once, in the order of the commands. */
export function unconfirmed_stops(commands: readonly Command[], now_ms: number): string[] {
  const open = commands.filter(({ command, state, time_ms }) => command === 'stop' && (state === 'issued' || state === 'accepted') && now_ms - time_ms > confirm_ms_max);
  return [...new Set(open.map(({ vehicle }) => vehicle))];
}
