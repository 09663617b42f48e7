// Alarms: abnormal conditions in the server's snapshots, each stored until the operator acknowledges it.
import type { Aiv, Deadlock, Snapshot } from './contract';
import * as format from './format';
import { failing_parts, failing_words, restarted_words } from './parts';

export interface AlarmCause {
  /** identifies the condition; the same while it lasts, whatever values its text shows */
  code: string;
  text: string;
}

export interface Alarm extends AlarmCause {
  key: string;
  /** id of the vehicle; null for an alarm of no vehicle */
  vehicle: string | null;
  name: string;
  /** on the server's clock */
  since_ms: number;
  /** null while the condition lasts */
  ended_ms: number | null;
  acknowledged: boolean;
}

/** A lower charge raises an alarm [%]. */
export const battery_low = 20;

/** Abnormal conditions of a vehicle, worst first. Waiting at a crossing is normal. */
export function causes_of(aiv: Aiv): AlarmCause[] {
  const causes: AlarmCause[] = [];
  const add = (code: string, text: string) => causes.push({ code, text });
  const here = !aiv.lost && aiv.connection === 'ONLINE';
  if (aiv.connection === 'CONNECTIONBROKEN') add('broken', 'Connection broken');
  else if (aiv.lost && aiv.connection === 'ONLINE') add('unresponsive', `No report for ${format.duration(aiv.age_ms)}`);
  if (here) {
    if (!aiv.contract.matched) add('matched', 'No twin');
    // Violations of the last seconds; the current values may be within the limits again.
    if (!aiv.contract.divergence) add('divergence', 'Divergence recently above the contractual limit');
    if (aiv.contract.actual === false) add('actual', 'Recently deviating from the measurement of the camera');
    if (!aiv.contract.age) add('age', 'Age of reports recently above the contractual limit');
    for (const board of aiv.boards ?? []) {
      if (board.health === 'lost') add(`board ${board.board}`, `Board ${board.board} lost`);
      if (board.health === 'faulty') add(`board ${board.board}`, `Board ${board.board} faulty${board.selfTest ? `, self-test ${board.selfTest}` : ''}`);
    }
  }
  if (aiv.offRoute) add('offRoute', `Off-route: ${aiv.offRoute}`);
  if (aiv.mission?.state === 'no route') add('no route', aiv.mission.why ?? `No route to ${aiv.mission.to ?? 'the next section'}`);
  for (const error of aiv.errors) add(`error ${error}`, error);
  if (here && aiv.battery !== null && aiv.battery < battery_low) add('battery', `Battery at ${format.percent(aiv.battery)}`);
  return causes;
}

/** Abnormal conditions of the platform itself. */
export function platform_causes({ registry, parts }: Snapshot): AlarmCause[] {
  const causes = failing_parts(parts).map((part) => ({ code: `part ${part.name} failing`, text: failing_words(part) }));
  if (registry?.full) causes.push({ code: 'registry full', text: `The server has its limit of ${registry.max} vehicles; further ones are refused` });
  return causes;
}

const ended_max = 200;
/** A deadlock that ended longer ago than this, before the page was opened, raises no alarm. */
const deadlock_news_ms = 60_000;

/** The text of a deadlock: its reason, its resolution and its duration. */
export function deadlock_words({ state, reason, how, since_ms, ended_ms }: Deadlock): string {
  const after = ended_ms === null ? '' : ` after ${format.duration(ended_ms - since_ms)}`;
  const head = state === 'unresolved' ? 'Deadlock, unresolved' : state === 'resolved' ? `Deadlock, resolved${after}` : 'Deadlock';
  const short = (text: string) => text.replace(/[^\s,/]+\//g, '');
  return `${head}: ${short(reason)}${how ? `. ${short(how)}` : ''}`;
}

export class AlarmBook {
  private readonly book = new Map<string, Alarm>();

  /** Updates the alarms from the current rows. True if the list changed, in a text or in its length. */
  accept(rows: readonly { id: string; name: string; aiv: Aiv }[], snapshot: Snapshot): boolean {
    const now = snapshot.time_ms;
    const lasting = new Set<string>();
    let changed = false;
    const see = (vehicle: string | null, name: string, cause: AlarmCause) => {
      const key = `${vehicle ?? ''}|${cause.code}`;
      lasting.add(key);
      const known = this.book.get(key);
      if (known && known.ended_ms === null) {
        if (known.text !== cause.text) {
          this.book.set(key, { ...known, text: cause.text });
          changed = true;
        }
        return;
      }
      this.book.set(key, { ...cause, key, vehicle, name, since_ms: now, ended_ms: null, acknowledged: false });
      changed = true;
    };
    for (const row of rows) for (const cause of causes_of(row.aiv)) see(row.id, row.name, cause);
    // An absent vehicle has an alarm of its own, except one that has signed off.
    const absent = new Set(rows.filter(({ aiv }) => aiv.connection === 'CONNECTIONBROKEN' || (aiv.lost && aiv.connection === 'ONLINE')).map(({ id }) => id));
    const detected = new Set((snapshot.bijection.findings ?? []).map(({ id }) => id));
    for (const orphan of snapshot.bijection.orphans) {
      if (absent.has(orphan.id) || detected.has(orphan.id)) continue;
      see(orphan.id, format.serial(orphan.id), { code: `orphan ${orphan.side}`, text: orphan.side === 'physical' ? 'It has no twin' : `A twin without a vehicle: ${orphan.reason ?? ''}` });
    }
    for (const { kind, id, text } of snapshot.bijection.findings ?? []) see(kind === 'no detection' ? null : id, format.serial(id), { code: kind, text });
    for (const deadlock of snapshot.deadlocks?.list ?? []) {
      const cause = { code: `deadlock ${deadlock.number}`, text: deadlock_words(deadlock) };
      if (deadlock.state === 'confirmed' || deadlock.state === 'yielding' || deadlock.state === 'unresolved') see(null, 'Traffic', cause);
      else if (deadlock.state === 'resolved') changed = this.end_deadlock(deadlock, cause, now) || changed;
    }
    for (const { crossing, trouble } of snapshot.units ?? []) if (trouble) see(null, `Crossing unit ${crossing}`, { code: `unit ${crossing}`, text: trouble.charAt(0).toUpperCase() + trouble.slice(1) });
    for (const cause of platform_causes(snapshot)) see(null, 'Platform', cause);
    for (const part of snapshot.parts ?? []) {
      // A restart is an event; a part that keeps failing is a condition, above.
      if (part.restarts <= (this.restarts.get(part.name) ?? 0)) continue;
      this.restarts.set(part.name, part.restarts);
      if (part.state === 'failing') continue;
      const key = `|part ${part.name} restarted`;
      this.book.set(key, { key, code: `part ${part.name} restarted`, text: restarted_words(part), vehicle: null, name: 'Platform', since_ms: now, ended_ms: now, acknowledged: false });
      changed = true;
    }
    for (const change of snapshot.battery?.changes ?? []) {
      const why = change.reason ? `: ${change.reason}` : '';
      see(change.vehicle, format.serial(change.vehicle), { code: 'battery change', text: `Battery ${change.battery} is requested${why}` });
    }
    const refused = snapshot.zone?.refused;
    if (refused) {
      // A refused zone is an event too: the previous zone stays in force, so that no condition could end.
      const key = `|zone refused ${refused.at} ${refused.origin}`;
      if (!this.failed.has(key)) {
        this.failed.add(key);
        this.book.set(key, { key, code: 'zone refused', text: `${refused.origin} was refused: ${refused.why}`, vehicle: null, name: 'Zone', since_ms: now, ended_ms: now, acknowledged: false });
        changed = true;
      }
    }
    for (const command of snapshot.commands) {
      if (command.state !== 'failed') continue;
      // A failed command is an event, not a condition: its alarm appears once and stays until acknowledged.
      const key = `${command.vehicle}|command ${command.id}`;
      if (this.failed.has(key)) continue;
      this.failed.add(key);
      const text = `${command.command} failed${command.reason ? `: ${command.reason}` : ''}`;
      this.book.set(key, { key, code: `command ${command.id}`, text, vehicle: command.vehicle, name: format.serial(command.vehicle), since_ms: command.time_ms, ended_ms: command.time_ms, acknowledged: false });
      changed = true;
    }
    for (const alarm of this.book.values()) {
      if (alarm.ended_ms === null && !lasting.has(alarm.key)) {
        if (alarm.acknowledged) this.book.delete(alarm.key);
        else this.book.set(alarm.key, { ...alarm, ended_ms: now });
        changed = true;
      }
    }
    this.prune();
    return changed;
  }

  /** Removes alarms whose condition has ended; the others stay, marked as known. */
  acknowledge(key: string | '*'): void {
    for (const alarm of [...this.book.values()]) {
      if (key !== '*' && alarm.key !== key) continue;
      if (alarm.ended_ms !== null) this.book.delete(alarm.key);
      else this.book.set(alarm.key, { ...alarm, acknowledged: true });
    }
  }

  /** Unacknowledged alarms first, among them the lasting ones, then the newest. */
  list(): Alarm[] {
    return [...this.book.values()].sort(
      (a, b) => Number(a.acknowledged) - Number(b.acknowledged) || Number(a.ended_ms !== null) - Number(b.ended_ms !== null) || b.since_ms - a.since_ms || (a.key < b.key ? -1 : 1),
    );
  }

  private readonly failed = new Set<string>();
  /** known restarts, by part */
  private readonly restarts = new Map<string, number>();

  /** Records the end of a deadlock, also of one that began and ended between two snapshots; its alarm stays until acknowledged. */
  private end_deadlock(deadlock: Deadlock, cause: AlarmCause, now: number): boolean {
    const key = `|${cause.code}`;
    const known = this.book.get(key);
    const ended_ms = deadlock.ended_ms ?? now;
    if (this.failed.has(key)) return false;
    this.failed.add(key);
    if (!known && now - ended_ms > deadlock_news_ms) return false;
    if (known?.acknowledged) this.book.delete(key);
    else this.book.set(key, { ...cause, key, vehicle: null, name: 'Traffic', since_ms: deadlock.since_ms, ended_ms, acknowledged: false });
    return true;
  }

  /** Bounds the list on a page that stays open for days: only the newest ended alarms are retained. */
  private prune(): void {
    if (this.book.size > ended_max) {
      const ended = [...this.book.values()].filter((alarm) => alarm.ended_ms !== null).sort((a, b) => a.since_ms - b.since_ms);
      for (const alarm of ended.slice(0, this.book.size - ended_max)) this.book.delete(alarm.key);
    }
    if (this.failed.size > 4 * ended_max) for (const key of [...this.failed].slice(0, 2 * ended_max)) this.failed.delete(key);
  }
}
