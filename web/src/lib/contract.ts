// The server's HTTP and WebSocket contract, docs/protocols/hmi-api.md. Metres, radians, m/s, milliseconds, percent.

export type Point = readonly [x: number, y: number];

export interface Primitive {
  shape: 'polyline' | 'polygon' | 'disc' | 'text';
  layer: string;
  /** of one layer's several: how a way bends, what a station is for */
  kind?: string;
  points: readonly Point[];
  /** stroke width, disc radius or text height [m] */
  size_m: number;
  label?: string;
  heading?: number;
}

export interface Zone {
  name: string;
  bounds: readonly [x0: number, y0: number, x1: number, y1: number];
  vehicle: { length_m: number; width_m: number };
  primitives: readonly Primitive[];
  sections: readonly { name: string; length_m: number }[];
  tags: readonly { number: number; section: string; s: number; x: number; y: number }[];
  beacons: { pitch_m: number; origin: Point; columns: number; rows: number; rotation?: number } | null;
  /** left out by a server that knows none of them */
  stations?: readonly Station[];
  loops?: readonly string[];
  /** what its file said that was mended, lost, or is worth knowing */
  notes?: readonly { kind: 'mended' | 'lost' | 'notice'; place: string; text: string }[];
}

export interface Station {
  name: string;
  kind: string;
  x: number;
  y: number;
  section: string;
  s: number;
}

/** What the zone that is in force has been through. */
export interface ZoneState {
  name: string | null;
  revision: number;
  /** sections that nobody enters */
  closed: readonly string[];
  /** the last configuration that could not be used */
  refused: { origin: string; why: string; at: number | string } | null;
  switched: { at: number | string; from: string | null; first_moving_ms: number | null; anchored: number; parked: readonly string[] } | null;
}

export interface Mission {
  kind: 'circulate' | 'go';
  loop?: string | null;
  to?: string;
  state: 'driving' | 'arrived' | 'no way';
  why?: string | null;
}

export interface Pose {
  x: number;
  y: number;
  heading: number;
}

export interface Aiv extends Pose {
  id: string;
  /** of the binary frames' records */
  handle: number;
  number: number;
  /** added only virtually */
  augmented: boolean;
  connection: 'ONLINE' | 'OFFLINE' | 'CONNECTIONBROKEN';
  /** no report came for a second */
  lost: boolean;
  /** one of A7's five words */
  status: string;
  speed: number;
  /** null where the twin is on no section: a foreign vehicle beside the circuit, or no zone yet */
  section: string | null;
  s: number | null;
  /** 0…999, higher goes first at a crossing */
  priority: number;
  /** its own, by the command limit [m/s]; left out by a server that knows none */
  speedLimit?: number | null;
  reported: Pose | null;
  age_ms: number;
  divergence_m: number;
  battery: number | null;
  lastTag: number | null;
  sinceTag_m: number | null;
  lastNode: string;
  orderId: string;
  orderUpdateId: number;
  driving: boolean;
  paused: boolean;
  fieldViolation: boolean;
  waitsFor: string | null;
  /** the virtual thing it brakes for */
  feels: string | null;
  errors: readonly string[];
  /** the way that its base lets it drive, and nobody else */
  reserved: readonly Point[];
  /** left out where the vehicle does not tell */
  boards?: readonly BoardHealth[];
  power?: { voltage_v: number; current_a: number; temperature_c: number };
  /** what its obstacle detection saw last: beam i looks at first + i·width [rad]; null: nothing within reach */
  ranges?: { first: number; width: number; m: readonly (number | null)[] };
  contract: { matched: boolean; divergence: boolean; age: boolean; actual?: boolean };
  mission?: Mission | null;
  /** the map that it says it drives on */
  map?: string | null;
  /** why it cannot drive in this zone; null where it can */
  parked?: string | null;
}

export interface BoardHealth {
  board: string;
  health: 'ok' | 'lost' | 'faulty';
  firmware: string;
  uptime_ms: number;
  frames: number;
  framesBad: number;
  framesMissed: number;
  selfTest: number;
}

export type Repeat = 'once' | 'back and forth' | 'loop';

/** What was added only virtually, save AIVs. */
export interface Thing {
  id: string;
  handle: number;
  kind: 'person' | 'obstacle';
  x: number;
  y: number;
  heading: number;
  radius: number;
  speed: number;
  path?: readonly Point[];
  repeat?: Repeat;
  feltBy: readonly string[];
  since_ms: number;
}

/** The twin of a physical obstacle that vehicles saw. */
export interface SeenObstacle {
  id: string;
  handle: number;
  x: number;
  y: number;
  radius: number;
  seenBy: readonly string[];
  first_ms: number;
  last_ms: number;
}

export interface Crossing {
  name: string;
  heldBy: string | null;
  waiting: readonly string[];
}

/** Vehicles that wait for each other in a ring, and what became of it. */
export interface Deadlock {
  /** from 1; 0 while it forms, which most do not survive */
  number: number;
  since_ms: number;
  state: 'forming' | 'standing' | 'giving way' | 'unresolved' | 'resolved';
  members: readonly string[];
  /** who waits for whom, and why */
  reason: string;
  /** what was done; empty before that */
  how: string;
  ended_ms: number | null;
}

export interface Deadlocks {
  /** rings that closed, however briefly */
  rings: number;
  detected: number;
  resolved: number;
  open: number;
  unresolved: number;
  longest_s: number;
  longest_wait_s: number;
  list: readonly Deadlock[];
}

export interface Statistics {
  count: number;
  mean: number;
  p50: number;
  p99: number;
  max: number;
}

export interface Bijection {
  physical: number;
  virtual: number;
  matched: number;
  matched_share: number;
  orphans: readonly { side: 'physical' | 'virtual'; id: string }[];
  /** what the camera over the zone finds wrong; left out by a server that knows none */
  findings?: readonly { kind: 'no twin' | 'not seen' | 'no sight'; id: string; text: string; since_ms: number }[];
  divergence_m: Statistics;
  divergence_rad: Statistics;
  /** of the twins from where the camera saw their vehicles */
  actual_m?: Statistics;
  actual_rad?: Statistics;
  age_ms: Statistics;
  commands: { issued: number; accepted: number; materialised: number; failed: number; latency_ms: Statistics };
  augmented: number;
  effects: { felt_ms: Statistics; brakes_ms: Statistics; shown_ms: Statistics };
  events: { count: number; latency_ms: Statistics; by_kind: Readonly<Record<string, number>> };
  /** for what share of the time the whole contract held, 0…1 */
  held_share: number;
  /** the limits in force; the page assumes the defaults when the server does not say */
  contract?: Partial<ContractLimits>;
}

export interface ContractLimits {
  divergence_p99_m: number;
  age_p99_ms: number;
  command_p99_ms: number;
  event_p99_ms: number;
  effect_p99_ms: number;
  actual_p99_m: number;
}

export const default_limits: ContractLimits = {
  divergence_p99_m: 0.03,
  age_p99_ms: 150,
  command_p99_ms: 2000,
  event_p99_ms: 500,
  effect_p99_ms: 200,
  actual_p99_m: 0.05,
};

export type CommandVerb = 'stop' | 'slow' | 'medium' | 'fast' | 'restart' | 'cancel';
export type CommandState = 'issued' | 'accepted' | 'materialised' | 'failed';

export interface Command {
  id: string;
  vehicle: string;
  /** one of CommandVerb, or what a newer server knows */
  command: string;
  state: CommandState;
  time_ms: number;
  accepted_ms: number | null;
  materialised_ms: number | null;
  reason: string;
}

/** What is heard of battery tests, which run elsewhere. */
export interface Battery {
  changes: readonly BatteryChange[];
  test: BatteryTest | null;
}
/** A battery that a test wants in a vehicle. */
export interface BatteryChange {
  vehicle: string;
  battery: string;
  run: number;
  /** why the one that is there may not run; empty: it is time */
  reason: string;
  since_ms: number;
}
export interface BatteryTest {
  /** by the clock of the test's own program */
  began_ms: number;
  told_ms: number;
  run: number;
  runs: number;
  /** where a run ends [%] */
  floor: number;
  /** of the way from full to the floor, over this run's vehicles, 0…1 */
  share: number;
  expectedEnd_ms: number | null;
  done: boolean;
  vehicles: readonly BatterySeat[];
}
export interface BatterySeat {
  id: string;
  battery: string;
  phase: 'changing' | 'ready' | 'running' | 'paused' | 'ended';
  stop: 'floor' | 'cut-off' | 'fault' | 'operator' | 'lost' | null;
  autonomy_s: number;
  charge: number | null;
}
/** Time [ms], charge [%], voltage [V], temperature [°C]. */
export type BatteryPoint = readonly [at_ms: number, charge: number, voltage_v: number, temperature_c: number];

/** What the camera over the zone says. */
export interface Gvs {
  state: 'watching' | 'silent' | 'broken' | 'ended';
  /** where its pictures come from, in words */
  source: string;
  /** why there are none; empty: there are */
  trouble: string;
  /** when the last picture was heard of */
  last_ms: number | null;
  period_s: number | null;
  seen: readonly GvsSeen[];
}
export interface GvsSeen extends Pose {
  id: string;
  tag: number;
  /** whether it has one */
  twin: boolean;
  uncertainty_m: number;
  /** when it was there */
  at_ms: number;
  /** from its twin at that moment */
  gap_m: number | null;
  gap_rad: number | null;
}

export interface Snapshot {
  time: string;
  /** of the server's clock, Unix milliseconds */
  time_ms: number;
  zoneRevision: number;
  zoneEdits: { undo: number; redo: number; unsaved: boolean };
  zone?: ZoneState | null;
  aivs: readonly Aiv[];
  things: readonly Thing[];
  obstacles: readonly SeenObstacle[];
  crossings: readonly Crossing[];
  /** left out by a server that does not look for them */
  deadlocks?: Deadlocks;
  bijection: Bijection;
  commands: readonly Command[];
  /** null or left out where no battery test was heard of */
  battery?: Battery | null;
  /** null or left out where no camera was heard of */
  gvs?: Gvs | null;
}

export interface Run {
  name: string;
  scenario: string | null;
  version: string;
  clock: { kind: 'wall' | 'virtual'; running: boolean; speed: number; time_ms: number };
}

/** What the emulated world says is so; to look at beside the twins, and used for nothing. */
export interface Truth {
  vehicles: readonly ({ number: number } & Pose)[];
  obstacles: readonly { id: string; x: number; y: number; radius: number }[];
}

export interface Trace {
  n: number;
  time_ms: number;
  from: string;
  to: string;
  kind: string;
  content: string;
}
export interface Traces {
  next: number;
  oldest: number;
  traces: readonly Trace[];
}
export interface WholeTrace extends Trace {
  topic: string;
  raw: string | null;
}

export interface ZoneEdit {
  addTags?: readonly TagPlace[];
  moveTags?: readonly TagPlace[];
  removeTags?: readonly number[];
  /** rotation: left positive [rad] */
  beacons?: { pitch?: number; origin?: Point; rotation?: number };
  priorities?: Readonly<Record<string, number>>;
}
export type TagPlace = { number: number; x: number; y: number } | { number: number; section: string; s: number };

export type LiveMessage =
  | { type: 'zone'; zone: Zone | null }
  | { type: 'run'; run: Run }
  | { type: 'snapshot'; snapshot: Snapshot }
  | { type: 'truth'; vehicles: Truth['vehicles']; obstacles: Truth['obstacles'] };

/** Reads one frame of the live stream; nothing where it is not one we know (a newer server may say more). */
export function parse_live(text: string): LiveMessage | null {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return null;
  }
  if (typeof value !== 'object' || value === null || !('type' in value)) return null;
  const known = value.type === 'zone' || value.type === 'run' || value.type === 'snapshot' || value.type === 'truth';
  return known ? (value as LiveMessage) : null;
}
