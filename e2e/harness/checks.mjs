// The harness's own notion of what the fleet must look like, from the order of the commands in the store and the responses
// that operators received.
import { serials_of } from './operators.mjs';

const profile_status = { slow: 'slow speed', medium: 'medium speed', fast: 'fast speed' };
const time_slack_ms = 1_500;

/** The settings of each vehicle after all commands, in their order: Map serial → {stopped, profile, limit}. */
export function settings_after(commands, aivs) {
  const settings = new Map(serials_of({ vehicle: '*' }, aivs).map((serial) => [serial, { stopped: false, profile: null, limit: null }]));
  for (const { json } of commands) {
    if (!json.vehicle && !json.vehicles) continue;
    for (const serial of serials_of(json, aivs)) {
      const one = settings.get(serial);
      if (!one) continue;
      if (json.command === 'stop') one.stopped = true;
      if (json.command === 'restart') settings.set(serial, { stopped: false, profile: null, limit: null });
      if (json.command in profile_status) Object.assign(one, { profile: json.command, limit: null });
      if (json.command === 'limit') one.limit = json.speed;
    }
  }
  return settings;
}

function is_of(stored, entry) {
  const { body, id, sent_ms, done_ms } = entry;
  return (
    stored.json.id === id &&
    Object.entries(body).every(([key, value]) => JSON.stringify(stored.json[key]) === JSON.stringify(value)) &&
    stored.accepted_ms > sent_ms - time_slack_ms &&
    stored.accepted_ms < done_ms + time_slack_ms
  );
}

/** Confirmed requests that the store does not contain: commands, and Stops that were reported as durable. */
export function missing_commands(log, commands) {
  return log.filter((entry) => entry.outcome === 'confirmed' && entry.durable !== false && !in_store(entry, commands));
}

export function in_store(entry, commands) {
  return commands.some((stored) => is_of(stored, entry));
}

/** Commands that the store executes more than once. */
export function repeated_commands(log, commands) {
  return log.filter((entry) => entry.outcome === 'confirmed' && commands.filter((stored) => stored.executed && is_of(stored, entry)).length > 1);
}

/** What differs between a vehicle's entry in the snapshot and its settings; [] if nothing. */
export function differences(aiv, wanted) {
  const found = [];
  if (wanted.stopped !== aiv.paused) found.push(`paused is ${aiv.paused}`);
  if (wanted.stopped && aiv.status !== 'stopped') found.push(`status is ${aiv.status}`);
  // A vehicle that waits is "stopped", too, and a limit lasts longer than the profile before it.
  const profile = wanted.limit === null ? wanted.profile : undefined;
  const shown = Object.values(profile_status).includes(aiv.status);
  if (!wanted.stopped && profile !== undefined && (shown || (profile && aiv.status === 'Normal')) && aiv.status !== profile_status[profile]) found.push(`status is ${aiv.status}`);
  if ((aiv.speedLimit ?? null) !== wanted.limit) found.push(`speedLimit is ${aiv.speedLimit}`);
  return found;
}

/** The same of a vehicle that may have taken a Stop which the store has lost, before that was durable. */
export function differences_or_stopped(aiv, wanted, stop_was_lost) {
  const found = differences(aiv, wanted);
  if (!stop_was_lost || found.length === 0) return found;
  return differences(aiv, { ...wanted, stopped: true }).length === 0 ? [] : found;
}

/** Whether the fleet is as it must be without faults; a text about the first deviation, or ''. */
export function fleet_problem(snapshot, bijection, aivs) {
  const physical = snapshot.aivs.filter(({ augmented }) => !augmented);
  if (physical.length !== aivs) return `${physical.length} twins instead of ${aivs}`;
  if (new Set(physical.map(({ id }) => id)).size !== aivs) return 'two twins have the same name';
  const absent = physical.find(({ connection, lost }) => connection !== 'ONLINE' || lost);
  if (absent) return `${absent.id} is ${absent.connection}${absent.lost ? ', lost' : ''}`;
  if (bijection.matched !== aivs || bijection.orphans.length > 0) return `${bijection.matched} matched, orphans ${JSON.stringify(bijection.orphans)}`;
  return '';
}

/** Follows the state of each command in the snapshots: issued, accepted, materialised or failed with a reason. */
export class CommandStates {
  constructor() {
    this.seen = new Map(); // id, vehicle and time: the entry seen last
  }

  accept(snapshot) {
    for (const command of snapshot.commands) this.seen.set(`${command.id} ${command.vehicle} ${Math.round(command.time_ms)}`, command);
  }

  /** The entries of one vehicle that belong to a request. */
  of(entry, serial) {
    return [...this.seen.values()].filter(
      ({ id, vehicle, time_ms }) => (id === entry.id || id === `${entry.id}.${serial}`) && (vehicle === '*' || vehicle.endsWith(`/${serial}`)) && time_ms > entry.sent_ms - time_slack_ms && time_ms < entry.done_ms + time_slack_ms,
    );
  }
}

/**
 * Confirmed commands about whose end nothing is known: neither materialised, nor failed with a reason, nor replaced by a later
 * one of the same vehicle, nor visible in the vehicle's settings.
 *
 * @param stop_was_lost  a Set of the serial numbers of vehicles that may have taken a Stop which was lost
 */
export function unfinished_commands(operators, states, snapshot, settings, stop_was_lost) {
  const unfinished = [];
  for (const [index, entry] of operators.log.entries()) {
    if (entry.outcome !== 'confirmed' || entry.checked || entry.lost) continue;
    for (const serial of serials_of(entry.body, operators.aivs)) {
      const seen = states.of(entry, serial);
      if (seen.some(({ state, reason }) => state === 'materialised' || (state === 'failed' && reason !== ''))) continue;
      const replaced = operators.log.slice(index + 1).some(({ body, outcome }) => outcome !== 'refused' && serials_of(body, operators.aivs).includes(serial));
      if (replaced || entry.body.command === 'circulate') continue;
      const aiv = snapshot.aivs.find(({ id }) => id === `CoSiVA/${serial}`);
      if (aiv && differences_or_stopped(aiv, settings.get(serial), stop_was_lost.has(serial)).length === 0) continue;
      unfinished.push({ command: entry.body, id: entry.id, vehicle: serial, state: seen.map(({ state, reason }) => `${state} ${reason}`.trim()) });
    }
  }
  return unfinished;
}
