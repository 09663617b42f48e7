// The rows of the vehicles: pure functions of the server's snapshot, without clock or framework.
import type { Aiv, Command, Snapshot } from './contract';
import { causes_of } from './alarms';
import * as format from './format';
import { state_styles, state_key, type StateKey } from './status';

export interface Row {
  id: string;
  label: string;
  name: string;
  state: StateKey;
  /** explains the state, e.g. the reason of a stop */
  note: string;
  alarms: string[];
  aiv: Aiv;
  /** the newest command to this vehicle, if recent or still in progress */
  command: Command | null;
}

const command_shown_ms = 8_000;

export function rows_of(snapshot: Snapshot): Row[] {
  const commands = newest_commands(snapshot);
  const to_all = commands.get('*') ?? null;
  return snapshot.aivs
    .map((aiv) => ({
      id: aiv.id,
      label: format.label(aiv.id, aiv.number),
      name: format.serial(aiv.id),
      state: state_key(aiv.status, aiv.lost, aiv.connection),
      note: note_of(aiv),
      alarms: alarms_of(aiv),
      aiv,
      command: newer(commands.get(aiv.id) ?? null, to_all),
    }))
    .sort(by_number);
}

/** Physical vehicles before virtual ones, then by number, then by id. */
export function by_number(a: Row, b: Row): number {
  return Number(a.aiv.augmented) - Number(b.aiv.augmented) || a.aiv.number - b.aiv.number || (a.id < b.id ? -1 : a.id > b.id ? 1 : 0);
}

function newer(a: Command | null, b: Command | null): Command | null {
  return a && b ? (b.time_ms >= a.time_ms ? b : a) : (a ?? b);
}

function note_of(aiv: Aiv): string {
  if (aiv.connection === 'CONNECTIONBROKEN') return 'connection broken';
  if (aiv.connection === 'OFFLINE') return 'signed off';
  if (aiv.lost) return 'no report';
  if (aiv.excluded) return 'excluded';
  if (aiv.paused) return 'by command';
  if (aiv.brakingFor) return `brakingFor ${aiv.brakingFor}`;
  if (aiv.waitsFor && state_key(aiv.status, false, 'ONLINE') === 'stopped') return `waits: ${short(aiv.waitsFor)}`;
  if (aiv.fieldViolation) return 'obstacle ahead';
  if (aiv.offRoute) return 'offRoute';
  return mission_note(aiv);
}

/** The text of a mission to a station; empty for a circulating vehicle, which is the default. */
export function mission_note({ mission }: Aiv): string {
  if (!mission || mission.kind !== 'go') return '';
  if (mission.state === 'no route') return `no route to ${mission.to}`;
  return mission.state === 'arrived' ? `at ${mission.to}` : `to ${mission.to}`;
}

/** Removes the manufacturers from the ids in a text, because a row has no room for them. */
export function short(text: string): string {
  return text.replace(/[^\s,/]+\//g, '');
}

/** The texts of a vehicle's abnormal conditions, worst first. */
export function alarms_of(aiv: Aiv): string[] {
  return causes_of(aiv).map((cause) => cause.text);
}

/** The newest command of each vehicle that is recent or still in progress, found in one pass. */
function newest_commands(snapshot: Snapshot): Map<string, Command> {
  const newest = new Map<string, Command>();
  for (const command of snapshot.commands) {
    const open = command.state === 'issued' || command.state === 'accepted';
    if (!open && snapshot.time_ms - command.time_ms >= command_shown_ms) continue;
    const known = newest.get(command.vehicle);
    if (!known || command.time_ms >= known.time_ms) newest.set(command.vehicle, command);
  }
  return newest;
}

/** Whether a row contains all words of a filter, in its names, its state, its section, its note or its kind. */
export function matches(row: Row, filter: string): boolean {
  const text = `${row.id} ${row.label} ${state_styles[row.state].word} ${row.aiv.section ?? 'off the circuit'} ${row.note} ${row.aiv.augmented ? 'virtual' : ''} ${row.alarms.length > 0 ? 'alarm' : ''}`.toLowerCase();
  return filter.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}
