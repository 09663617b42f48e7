// From the contract's snapshot to what the page shows: pure functions, no clock, no framework.
import { default_limits, type Aiv, type Bijection, type Command, type ContractLimits, type Snapshot } from './contract';
import * as format from './format';
import { state_key, type StateKey } from './status';

export interface Row {
  id: string;
  mark: string;
  name: string;
  state: StateKey;
  /** the state as a word, with what explains it */
  note: string;
  alarms: string[];
  aiv: Aiv;
  /** the newest command given to it, when it is recent or still under way */
  command: Command | null;
}

const command_shown_ms = 8_000;

export function rows_of(snapshot: Snapshot): Row[] {
  return snapshot.aivs
    .map((aiv) => ({
      id: aiv.id,
      mark: format.mark(aiv.id, aiv.number),
      name: format.serial(aiv.id),
      state: state_key(aiv.status, aiv.lost, aiv.connection),
      note: note_of(aiv),
      alarms: alarms_of(aiv),
      aiv,
      command: newest_command(snapshot, aiv.id),
    }))
    .sort((a, b) => a.aiv.number - b.aiv.number || a.id.localeCompare(b.id));
}

function note_of(aiv: Aiv): string {
  if (aiv.connection === 'CONNECTIONBROKEN') return 'connection broken';
  if (aiv.connection === 'OFFLINE') return 'signed off';
  if (aiv.lost) return 'no report';
  if (aiv.paused) return 'by command';
  if (aiv.waitsFor && state_key(aiv.status, false, 'ONLINE') === 'stopped') return `waits: ${short(aiv.waitsFor)}`;
  if (aiv.fieldViolation) return 'obstacle ahead';
  return '';
}

/** Names without their makers: in a row there is no room for them. */
function short(text: string): string {
  return text.replace(/[^\s,/]+\//g, '');
}

/** What is abnormal about a vehicle, worst first; empty for one that is well. A vehicle that waits its turn is well. */
export function alarms_of(aiv: Aiv): string[] {
  const alarms: string[] = [];
  if (aiv.connection === 'CONNECTIONBROKEN') alarms.push('Connection broken');
  else if (aiv.lost && aiv.connection === 'ONLINE') alarms.push(`No report for ${format.duration(aiv.age_ms)}`);
  if (!aiv.contract.matched) alarms.push('No twin for it');
  if (!aiv.lost && aiv.connection === 'ONLINE') {
    // The contract is about the last seconds; the figures beside may be good again.
    if (!aiv.contract.divergence) alarms.push('Divergence out of contract lately');
    if (!aiv.contract.age) alarms.push('Age of reports out of contract lately');
  }
  return [...alarms, ...aiv.errors];
}

function newest_command(snapshot: Snapshot, id: string): Command | null {
  let newest: Command | null = null;
  for (const command of snapshot.commands) {
    if (command.vehicle !== id && command.vehicle !== '*') continue;
    if (newest === null || command.time_ms >= newest.time_ms) newest = command;
  }
  if (newest === null) return null;
  const open = newest.state === 'issued' || newest.state === 'accepted';
  return open || snapshot.time_ms - newest.time_ms < command_shown_ms ? newest : null;
}

export interface Figure {
  key: 'matched' | 'divergence' | 'age' | 'commands' | 'events';
  label: string;
  value: string;
  detail: string;
  limit: string;
  /** nothing measured yet is neither kept nor broken */
  verdict: 'kept' | 'broken' | 'open';
}

export function figures_of(bijection: Bijection): Figure[] {
  const limits: ContractLimits = { ...default_limits, ...bijection.contract };
  const judge = (count: number, kept: boolean): Figure['verdict'] => (count === 0 ? 'open' : kept ? 'kept' : 'broken');
  const { divergence_m, age_ms, commands, events } = bijection;
  const expected = Math.max(bijection.physical, bijection.virtual);
  return [
    {
      key: 'matched',
      label: 'Matched',
      value: `${bijection.matched} / ${expected}`,
      detail: `${format.share(bijection.matched_share)} of the time`,
      limit: 'each has one twin',
      verdict: judge(expected, bijection.matched === expected && bijection.orphans.length === 0),
    },
    {
      key: 'divergence',
      label: 'Divergence p99',
      value: divergence_m.count === 0 ? format.none : format.length(divergence_m.p99),
      detail: `mean ${format.length(divergence_m.mean)}, max ${format.length(divergence_m.max)}`,
      limit: `≤ ${format.length(limits.divergence_p99_m)}`,
      verdict: judge(divergence_m.count, divergence_m.p99 <= limits.divergence_p99_m),
    },
    {
      key: 'age',
      label: 'Age p99',
      value: age_ms.count === 0 ? format.none : format.duration(age_ms.p99),
      detail: `mean ${format.duration(age_ms.mean)}, max ${format.duration(age_ms.max)}`,
      limit: `≤ ${format.duration(limits.age_p99_ms)}`,
      verdict: judge(age_ms.count, age_ms.p99 <= limits.age_p99_ms),
    },
    {
      key: 'commands',
      label: 'Commands p99',
      value: commands.latency_ms.count > 0 ? format.duration(commands.latency_ms.p99) : format.none,
      detail: `${commands.materialised} of ${commands.issued} materialised${commands.failed > 0 ? `, ${commands.failed} failed` : ''}`,
      limit: `≤ ${format.duration(limits.command_p99_ms)}`,
      verdict: judge(
        commands.latency_ms.count + commands.failed,
        commands.failed === 0 && commands.latency_ms.p99 <= limits.command_p99_ms,
      ),
    },
    {
      key: 'events',
      label: 'Events p99',
      value: events.latency_ms.count > 0 ? format.duration(events.latency_ms.p99) : format.none,
      detail: `${events.count} reflected`,
      limit: `≤ ${format.duration(limits.event_p99_ms)}`,
      verdict: judge(events.latency_ms.count, events.latency_ms.p99 <= limits.event_p99_ms),
    },
  ];
}

/** Is the page's picture the present? */
export type Link =
  | { phase: 'connecting'; since_ms: number }
  | { phase: 'live'; since_ms: number }
  | { phase: 'silent'; since_ms: number }
  | { phase: 'down'; since_ms: number };

export type LinkEvent = { kind: 'opened' | 'frame' | 'closed' | 'tick'; at_ms: number; last_frame_ms: number };

/** A socket may stay open while its server hangs: a second without a frame is news too. */
export const silence_ms = 1_000;

export function link_after(link: Link, event: LinkEvent): Link {
  switch (event.kind) {
    case 'opened':
      return link.phase === 'live' ? link : { phase: 'connecting', since_ms: link.phase === 'down' ? link.since_ms : event.at_ms };
    case 'frame':
      return link.phase === 'live' ? link : { phase: 'live', since_ms: event.at_ms };
    case 'closed':
      return link.phase === 'down' ? link : { phase: 'down', since_ms: link.phase === 'silent' ? link.since_ms : event.at_ms };
    case 'tick':
      if (link.phase === 'live' && event.at_ms - event.last_frame_ms > silence_ms) return { phase: 'silent', since_ms: event.last_frame_ms };
      return link;
  }
}
