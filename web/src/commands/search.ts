// The list of commands: every command by name, also for each AIV ("stop AIV2"), found by a few letters.
import { key_of, type Action } from '../shell/keys';
import { operator_commands, presence_commands, type Presence } from './operator_commands';
import type { CommandName } from '../live/contract';
import { frame_names, frame_titles } from '../shell/url';

export type Doing =
  | { kind: 'act'; action: Action }
  | { kind: 'command'; command: CommandName; vehicles: '*' | readonly string[] }
  | { kind: 'go'; vehicle: string; to: string }
  | { kind: 'circulate'; vehicle: string; loop: string | null }
  | { kind: 'close'; section: string }
  | { kind: 'select'; id: string }
  | { kind: 'follow'; id: string }
  | { kind: 'remove'; id: string }
  | { kind: 'page'; name: string };

export interface Entry {
  key: string;
  text: string;
  hint: string;
  doing: Doing;
}

const actions: readonly [Action, string][] = [
  ['stop all', 'Stop all AIVs'],
  ['stop selected', 'Stop the chosen AIVs'],
  ['play', 'Pause or run virtual time'],
  ['step', 'Step 0.1 s of virtual time'],
  ['long step', 'Step 1 s of virtual time'],
  ['fit', 'Show the whole circuit'],
  ['zoom in', 'Zoom in'],
  ['zoom out', 'Zoom out'],
  ['layers', 'Layers of the circuit'],
  ['follow', 'Follow the selected AIV'],
  ['next', 'Select the next AIV'],
  ['previous', 'Select the previous AIV'],
  ['search', 'Search AIVs'],
  ...frame_names.map((name, i): [Action, string] => [`frame ${i + 1}` as Action, `Fill the page with ${frame_titles[name]}`]),
  ['theme', 'Change the colours: light, dark, as the system'],
  ['help', 'Keys and help'],
];

/** Entries of the page itself; Palette.svelte carries them out by name. */
export const page_entries: readonly [name: string, text: string][] = [
  ['all four', 'Show all four frames'],
  ['bijection', 'Open Bijection'],
  ['alarms', 'Open Alarms'],
  ['boards', 'Open Boards'],
  ['log', 'Open the log of commands'],
  ['acknowledge', 'Acknowledge all alarms'],
  ['choose all', 'Choose all AIVs'],
  ['choose none', 'Choose no AIV'],
  ['add aiv', 'Add a virtual AIV on the circuit'],
  ['add aiv anywhere', 'Add a virtual AIV where there is room'],
  ['add person', 'Add a person'],
  ['draw walk', 'Add a walking person'],
  ['add obstacle', 'Add an obstacle'],
  ['add plant obstacle', 'Add a physical obstacle to the emulated world'],
  ['remove all', 'Remove everything virtual'],
  ['edit tags', 'Edit tags of the circuit'],
  ['close sections', 'Close or open sections of the circuit'],
  ['measure', 'Measure on the circuit'],
  ['switch zone', 'Switch to another traffic zone'],
  ['undo', 'Undo the last edit of the zone'],
  ['redo', 'Redo the edit of the zone'],
  ['save zone', 'Save the zone'],
  ['order', 'List AIVs by priority, or by number'],
  ['columns', 'Show all columns of the table'],
  ['layout', 'Frames as at first'],
  ['letters', 'Switch single-letter keys on or off'],
];

const entry = (text: string, hint: string, doing: Doing): Entry => ({ key: text, text, hint, doing });

/** Names of the zone that commands can refer to. */
export interface ZoneItems {
  stations: readonly string[];
  loops: readonly string[];
  sections: readonly string[];
  closed: readonly string[];
  /** vehicles that the missions of a large zone are listed for; empty: none are listed */
  targets: readonly string[];
}
const no_zone_items: ZoneItems = { stations: [], loops: [], sections: [], closed: [], targets: [] };
/** Above this number of entries of one kind, which would slow the list down, only those of chosen vehicles are listed. */
const entries_max = 2_000;

function missions_of(vehicles: readonly { id: string; name: string }[], { stations, loops, sections, closed, targets }: ZoneItems): Entry[] {
  const list: Entry[] = [{ ...entry('Let all AIVs circulate', '', { kind: 'circulate', vehicle: '*', loop: null }), key: 'circulate *' }];
  for (const loop of loops) list.push(entry(`Let all AIVs circulate on ${loop}`, '', { kind: 'circulate', vehicle: '*', loop }));
  const few = vehicles.length * (stations.length + loops.length) <= entries_max;
  for (const { id, name } of few ? vehicles : vehicles.filter((one) => targets.includes(one.id))) {
    for (const to of stations) list.push({ ...entry(`Send ${name} to ${to}`, '', { kind: 'go', vehicle: id, to }), key: `go ${id} ${to}` });
    for (const loop of [null, ...loops]) list.push({ ...entry(`Let ${name} circulate${loop === null ? '' : ` on ${loop}`}`, '', { kind: 'circulate', vehicle: id, loop }), key: `circulate ${id} ${loop}` });
  }
  for (const section of sections.length <= entries_max ? sections : closed) {
    list.push({ ...entry(`${closed.includes(section) ? 'Open' : 'Close'} section ${section}`, '', { kind: 'close', section }), key: `close ${section}` });
  }
  return list;
}

export function entries_of(vehicles: readonly (Presence & { id: string; name: string })[], virtualObjects: readonly { id: string }[], zone_items: ZoneItems = no_zone_items): Entry[] {
  const list: Entry[] = actions.map(([action, text]) => entry(text, key_of(action) ?? '', { kind: 'act', action }));
  for (const { command, word } of operator_commands) if (command !== 'stop') list.push(entry(`${word} all AIVs`, '', { kind: 'command', command, vehicles: '*' }));
  for (const [name, text] of page_entries) list.push(entry(text, '', { kind: 'page', name }));
  for (const vehicle of vehicles) {
    const { id, name, augmented } = vehicle;
    for (const { command, word } of [...operator_commands, ...presence_commands(vehicle)]) list.push({ ...entry(`${word} ${name}`, '', { kind: 'command', command, vehicles: [id] }), key: `${command} ${id}` });
    list.push({ ...entry(`Cancel the order of ${name}`, '', { kind: 'command', command: 'cancel', vehicles: [id] }), key: `cancel ${id}` });
    list.push({ ...entry(`Select ${name}`, '', { kind: 'select', id }), key: `select ${id}` });
    list.push({ ...entry(`Follow ${name}`, '', { kind: 'follow', id }), key: `follow ${id}` });
    if (augmented) list.push({ ...entry(`Remove ${name}`, '', { kind: 'remove', id }), key: `remove ${id}` });
  }
  list.push(...missions_of(vehicles, zone_items));
  for (const { id } of virtualObjects) list.push(entry(`Remove ${id}`, '', { kind: 'remove', id }));
  return list;
}

/**
 * The score of a text for the typed letters, which must occur in this order; adjacent letters, starts of words and early
 * matches score higher. Null if the text does not match.
 */
export function score_of(text: string, typed: string): number | null {
  const wanted = typed.toLowerCase().replace(/\s+/g, '');
  if (wanted === '') return 0;
  const have = text.toLowerCase();
  let best: number | null = null;
  // Tries each occurrence of the first letter, because the first occurrence need not score best.
  for (let start = have.indexOf(wanted[0]!); start >= 0; start = have.indexOf(wanted[0]!, start + 1)) {
    const score = from(have, wanted, start);
    if (score !== null && (best === null || score > best)) best = score;
  }
  return best;
}

function from(have: string, wanted: string, start: number): number | null {
  let score = 0;
  let at = start - 1;
  let together = false;
  for (const letter of wanted) {
    let next = at + 1;
    // A typed space may match nothing; the next letter then still counts as adjacent.
    if (together && have[next] === ' ' && letter !== ' ') next++;
    const follows = have[next] === letter;
    if (!follows) next = have.indexOf(letter, at + 1);
    if (next < 0) return null;
    const begins = next === 0 || have[next - 1] === ' ';
    // The first letter has no predecessor; only the start of a word raises its score.
    if (!together) score += begins ? 14 : 1;
    else score += follows ? 8 : begins ? 6 : 1 - Math.min(5, next - at);
    at = next;
    together = true;
  }
  return score - start * 0.2 - have.length * 0.02;
}

export function search(entries: readonly Entry[], typed: string, most = 12): Entry[] {
  if (typed.trim() === '') return entries.slice(0, most);
  return entries
    .map((one, i) => ({ one, i, score: score_of(one.text, typed) }))
    .filter((found): found is { one: Entry; i: number; score: number } => found.score !== null)
    .sort((a, b) => b.score - a.score || a.i - b.i)
    .slice(0, most)
    .map(({ one }) => one);
}
