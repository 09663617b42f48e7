// From the contract's snapshot to what the page shows: pure functions, no clock, no framework.
import { default_limits, type Aiv, type Bijection, type Command, type ContractLimits, type Snapshot } from './contract';
import { causes_of } from './alarms';
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
  const commands = newest_commands(snapshot);
  const to_all = commands.get('*') ?? null;
  return snapshot.aivs
    .map((aiv) => ({
      id: aiv.id,
      mark: format.mark(aiv.id, aiv.number),
      name: format.serial(aiv.id),
      state: state_key(aiv.status, aiv.lost, aiv.connection),
      note: note_of(aiv),
      alarms: alarms_of(aiv),
      aiv,
      command: newer(commands.get(aiv.id) ?? null, to_all),
    }))
    .sort(by_number);
}

/** Ours first, the virtual ones behind the physical ones of the same number, then by name. */
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
  if (aiv.paused) return 'by command';
  if (aiv.feels) return `feels ${aiv.feels}`;
  if (aiv.waitsFor && state_key(aiv.status, false, 'ONLINE') === 'stopped') return `waits: ${short(aiv.waitsFor)}`;
  if (aiv.fieldViolation) return 'obstacle ahead';
  if (aiv.parked) return 'parked';
  return mission_note(aiv);
}

/** Where somebody sent it; who circulates, as all do, gets no word. */
export function mission_note({ mission }: Aiv): string {
  if (!mission || mission.kind !== 'go') return '';
  if (mission.state === 'no way') return `no way to ${mission.to}`;
  return mission.state === 'arrived' ? `at ${mission.to}` : `to ${mission.to}`;
}

/** Names without their makers: in a row there is no room for them. */
export function short(text: string): string {
  return text.replace(/[^\s,/]+\//g, '');
}

/** What is abnormal about a vehicle, in words, worst first. */
export function alarms_of(aiv: Aiv): string[] {
  return causes_of(aiv).map((cause) => cause.text);
}

/** The newest command of each vehicle that is recent or still under way; one pass, whatever the number of vehicles. */
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

export interface Figure {
  key: 'matched' | 'divergence' | 'age' | 'commands' | 'events' | 'felt' | 'brakes' | 'shown' | 'actual';
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
  const { divergence_m, actual_m, age_ms, commands, events } = bijection;
  const expected = Math.max(bijection.physical, bijection.virtual);
  // Only where a camera watches.
  const actual: Figure[] = actual_m?.count ? [{
    key: 'actual',
    label: 'Twin to camera p99',
    value: format.length(actual_m.p99),
    detail: `mean ${format.length(actual_m.mean)}, max ${format.length(actual_m.max)}`,
    limit: `≤ ${format.length(limits.actual_p99_m)}`,
    verdict: judge(1, actual_m.p99 <= limits.actual_p99_m),
  }] : [];
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
    ...actual,
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
    ...effects_of(bijection, limits),
  ];
}

/** What is added virtually and felt physically, and the other way; nothing for a server that does not tell. */
function effects_of(bijection: Bijection, limits: ContractLimits): Figure[] {
  const effects: Partial<Bijection['effects']> = bijection.effects ?? {};
  const words = [
    ['felt', 'Virtual felt p99', effects.felt_ms, 'change to decision'],
    ['brakes', 'Virtual braked for p99', effects.brakes_ms, 'change to braking'],
    ['shown', 'Obstacle shown p99', effects.shown_ms, 'seen to shown'],
  ] as const;
  return words.flatMap(([key, label, figure, what]) => {
    if (!figure || figure.count === undefined) return [];
    const measured = figure.count > 0;
    const verdict = !measured ? 'open' : figure.p99 <= limits.effect_p99_ms ? 'kept' : 'broken';
    return [{ key, label, value: measured ? format.duration(figure.p99) : format.none, detail: measured ? `${figure.count} × ${what}` : what, limit: `≤ ${format.duration(limits.effect_p99_ms)}`, verdict } as const];
  });
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
