// The operator's commands in the order of their buttons. Each has the shape of the state that it leads to.
import type { Aiv, CommandName } from '../live/contract';

export interface OperatorCommand {
  command: CommandName;
  word: string;
  what: string;
  /** SVG path in a 16 × 16 box */
  path: string;
}

export const operator_commands: readonly OperatorCommand[] = [
  { command: 'slow', word: 'Slow', what: 'Slow speed', path: 'M2.5 4.5h11L8 13.5z' },
  { command: 'medium', word: 'Medium', what: 'Medium speed', path: 'M8 2.5L13.5 8L8 13.5L2.5 8z' },
  { command: 'fast', word: 'Fast', what: 'Fast speed', path: 'M8 2.5l5.5 9h-11z' },
  { command: 'restart', word: 'Restart', what: 'Continue, without a speed limit', path: 'M4.5 3l8.5 5l-8.5 5z' },
  { command: 'stop', word: 'Stop', what: 'Stop', path: 'M3.5 3.5h9v9h-9z' },
];

export type Presence = Pick<Aiv, 'augmented' | 'excluded' | 'absent'>;

/** The commands that decide whether a vehicle takes part. Only a twin whose vehicle is absent can be retired. */
export function presence_commands({ augmented, excluded, absent }: Presence): { command: CommandName; word: string }[] {
  if (augmented) return [];
  const toggle = excluded ? { command: 'include' as const, word: 'Include' } : { command: 'exclude' as const, word: 'Exclude' };
  return absent ? [toggle, { command: 'retire', word: 'Retire' }] : [toggle];
}
