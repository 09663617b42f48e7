// The server's HTTP and WebSocket contract, docs/protocols/hmi-api.md. Metres, radians, m/s, milliseconds, percent.

export type Point = readonly [x: number, y: number];

export interface Primitive {
  shape: 'polyline' | 'polygon' | 'disc' | 'text';
  layer: string;
  /** distinguishes primitives of one layer: the curvature of a road, the purpose of a station */
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
  /** absent if the server does not support stations */
  stations?: readonly Station[];
  loops?: readonly string[];
  /** remarks of the importer: repaired, dropped or notable content of the file */
  diagnostics?: readonly { kind: 'mended' | 'lost' | 'notice'; location: string; text: string }[];
}

export interface Station {
  name: string;
  kind: string;
  x: number;
  y: number;
  section: string;
  s: number;
}

/** The state of the zone in force: edits, closed sections, the last switch. */
export interface ZoneState {
  name: string | null;
  revision: number;
  /** closed sections, which no vehicle enters */
  closed: readonly string[];
  /** the last zone that was refused */
  refused: { origin: string; why: string; at: number | string } | null;
  switched: { at: number | string; from: string | null; first_moving_ms: number | null; snapped: number; offRoute: readonly string[] } | null;
}

export interface Mission {
  kind: 'circulate' | 'go';
  loop?: string | null;
  to?: string;
  state: 'driving' | 'arrived' | 'no route';
  why?: string | null;
}

export interface Pose {
  x: number;
  y: number;
  heading: number;
}

export interface Aiv extends Pose {
  id: string;
  /** identifies the vehicle in the binary position frames */
  handle: number;
  number: number;
  /** true for a virtual vehicle without a physical counterpart */
  augmented: boolean;
  connection: 'ONLINE' | 'OFFLINE' | 'CONNECTIONBROKEN';
  /** true after one second without a report */
  lost: boolean;
  /** one of A7's five words */
  status: string;
  speed: number;
  /** null if the twin is on no section: a third-party vehicle off the path, or no zone yet */
  section: string | null;
  s: number | null;
  /** 0…999, higher goes first at a crossing */
  priority: number;
  /** the vehicle's own speeds for the speed commands [m/s]; absent if the server does not support them */
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
  /** the virtual object that the vehicle brakes for */
  brakingFor: string | null;
  errors: readonly string[];
  /** messages that exceeded the vehicle's rate and were not evaluated */
  dropped?: number;
  /** the path reserved by the vehicle's base; no other vehicle may enter it */
  reserved: readonly Point[];
  /** absent if the vehicle does not report its boards */
  boards?: readonly BoardHealth[];
  /** what BRAC, DEMS and PMOT, the parts of PILS, measure */
  pils?: { supply: number; dems: readonly number[]; leftSpeed: number; rightSpeed: number; leftCurrent: number; rightCurrent: number };
  /** the text on the display AFFI */
  affi?: string;
  /** messages that passed through the server's proxy of the vehicle */
  proxy?: { sent: number; delivered: number };
  /** messages that passed through the proxies that the vehicle hosts, its server's first */
  proxies?: readonly { agent: string; sent: number; delivered: number }[];
  power?: { voltage_v: number; current_a: number; temperature_c: number };
  /** the last scan of the obstacle sensor: beam i points to first + i·width [rad]; null: no obstacle in range */
  ranges?: { first: number; width: number; m: readonly (number | null)[] };
  contract: { matched: boolean; divergence: boolean; age: boolean; actual?: boolean };
  mission?: Mission | null;
  /** the map that the vehicle reports */
  map?: string | null;
  /** why the vehicle cannot drive in this zone; null if it can */
  offRoute?: string | null;
  /** an operator has excluded it: it gets no orders */
  excluded?: boolean;
  /** why it is not on the physical side: its twin is an orphan; null if it is there */
  absent?: string | null;
}

export interface BoardHealth {
  board: string;
  /** absent: the vehicle is equipped without this board */
  health: 'ok' | 'lost' | 'faulty' | 'absent';
  firmware: string;
  uptime_ms: number;
  frames: number;
  framesBad: number;
  framesMissed: number;
  selfTest: number;
  /** findings of the self-test that was requested last, by part; absent before one */
  parts?: Readonly<Record<string, string>>;
  /** what the self-test code means; absent without a fault */
  fault?: string;
}

export type Repeat = 'once' | 'back and forth' | 'loop';

/** A virtual object other than a vehicle: a person or an obstacle. */
export interface VirtualObject {
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
  perceivedBy: readonly string[];
  since_ms: number;
}

/** The twin of a physical obstacle that vehicles detected. */
export interface DetectedObstacle {
  id: string;
  handle: number;
  x: number;
  y: number;
  radius: number;
  detectedBy: readonly string[];
  first_ms: number;
  last_ms: number;
}

export interface Crossing {
  name: string;
  heldBy: string | null;
  waiting: readonly string[];
}

/** A cycle of vehicles that wait for each other, and its resolution. */
export interface Deadlock {
  /** number, from 1; 0 while the cycle is not yet confirmed, as most dissolve by themselves */
  number: number;
  since_ms: number;
  state: 'forming' | 'confirmed' | 'yielding' | 'unresolved' | 'resolved';
  members: readonly string[];
  /** the waiting vehicles, and the reason of each wait */
  reason: string;
  /** the resolution; empty before it */
  how: string;
  ended_ms: number | null;
}

export interface Deadlocks {
  /** number of cycles that formed, however briefly */
  cycles: number;
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
  matched_ratio: number;
  /** `reason` and `since_ms` of a twin whose vehicle is absent */
  orphans: readonly { side: 'physical' | 'virtual'; id: string; reason?: string; since_ms?: number }[];
  /** discrepancies found by the camera above the zone; absent if the server has no camera */
  findings?: readonly { kind: 'no twin' | 'not detected' | 'no detection' | 'displaced' | 'two programs' | 'displaced tag'; id: string; text: string; since_ms: number }[];
  divergence_m: Statistics;
  divergence_rad: Statistics;
  /** what `actual_…` is measured against; absent in older servers */
  references?: { divergence: string; actual: 'camera' | 'instrument' | null };
  /** distance of the twins from the true positions of their vehicles */
  actual_m?: Statistics;
  actual_rad?: Statistics;
  age_ms: Statistics;
  commands: { issued: number; accepted: number; materialised: number; failed: number; latency_ms: Statistics };
  augmented: number;
  effects: { perceived_ms: Statistics; brakes_ms: Statistics; shown_ms: Statistics };
  events: { count: number; latency_ms: Statistics; by_kind: Readonly<Record<string, number>> };
  /** ratio of the time in which the whole contract was fulfilled, 0…1 */
  held_ratio: number;
  /** whether each contract holds now: false for some seconds after a violation */
  held: Readonly<Record<'divergence' | 'age' | 'actual' | 'commands' | 'events' | 'effects', boolean>>;
  /** the limits in force; absent: the page assumes the defaults */
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

export type CommandName = 'stop' | 'slow' | 'medium' | 'fast' | 'restart' | 'cancel' | 'exclude' | 'include' | 'retire' | 'self-test';
export type CommandState = 'issued' | 'accepted' | 'materialised' | 'failed';

export interface Command {
  id: string;
  vehicle: string;
  /** a CommandName, or a command of a newer server */
  command: string;
  state: CommandState;
  time_ms: number;
  accepted_ms: number | null;
  materialised_ms: number | null;
  reason: string;
}

/** The battery test reported to the server; the test itself runs in a program of its own. */
export interface Battery {
  changes: readonly BatteryChange[];
  test: BatteryTest | null;
}
/** A battery that the test requests for a vehicle. */
export interface BatteryChange {
  vehicle: string;
  battery: string;
  run: number;
  /** why the installed battery was refused; empty: a regular exchange */
  reason: string;
  since_ms: number;
}
export interface BatteryTest {
  /** on the clock of the test program */
  began_ms: number;
  received_ms: number;
  run: number;
  runs: number;
  /** charge at which a run ends [%] */
  floor: number;
  /** progress from full charge to the floor, over the vehicles of this run, 0…1 */
  progress: number;
  expectedEnd_ms: number | null;
  done: boolean;
  vehicles: readonly BatterySlot[];
}
export interface BatterySlot {
  id: string;
  battery: string;
  phase: 'changing' | 'ready' | 'running' | 'paused' | 'ended';
  stop: 'floor' | 'cut-off' | 'fault' | 'operator' | 'lost' | null;
  autonomy_s: number;
  charge: number | null;
}
/** Time [ms], charge [%], voltage [V], temperature [°C]. */
export type BatteryPoint = readonly [at_ms: number, charge: number, voltage_v: number, temperature_c: number];

/** The report of the camera above the zone. */
export interface Gvs {
  state: 'watching' | 'unresponsive' | 'broken' | 'ended';
  /** the source of its images, as a text */
  source: string;
  /** why no images arrive; empty: they arrive */
  trouble: string;
  /** time of the last image */
  last_ms: number | null;
  period_s: number | null;
  detections: readonly GvsDetection[];
}
export interface GvsDetection extends Pose {
  id: string;
  tag: number;
  /** whether the vehicle has a twin */
  twin: boolean;
  uncertainty_m: number;
  /** time of the measurement */
  at_ms: number;
  /** distance from the twin at that time */
  gap_m: number | null;
  gap_rad: number | null;
}

/** A program that `cosiva up` has started. */
export interface Part {
  name: string;
  state: 'running' | 'restarting' | 'failing' | 'ended';
  restarts: number;
  /** how it ended the last time; null if it never did */
  last_error: string | null;
}

/** Vehicles that the server knows. */
export interface Registry {
  vehicles: number;
  max: number;
  /** messages of vehicles beyond the limit */
  refused: number;
  /** such a message arrived in the last minute */
  full: boolean;
}

/** A roadside unit at a crossing, and what it has received about its crossing. */
export interface CrossingUnit {
  crossing: string;
  x: number;
  y: number;
  state: 'online' | 'unresponsive';
  /** of its last message */
  age_ms: number;
  /** in the crossing, or about to enter it */
  holders: readonly { id: string; age_ms: number }[];
  waiting: readonly { id: string; age_ms: number }[];
  /** what an operator should check; null: nothing */
  trouble: string | null;
}

export interface Snapshot {
  time: string;
  /** server time, Unix milliseconds */
  time_ms: number;
  zoneRevision: number;
  zoneEdits: { undo: number; redo: number; unsaved: boolean };
  zone?: ZoneState | null;
  aivs: readonly Aiv[];
  virtualObjects: readonly VirtualObject[];
  obstacles: readonly DetectedObstacle[];
  crossings: readonly Crossing[];
  /** absent from servers that observe no crossing units */
  units?: readonly CrossingUnit[];
  /** absent if the server does not detect deadlocks */
  deadlocks?: Deadlocks;
  bijection: Bijection;
  commands: readonly Command[];
  /** null or absent if no battery test has reported */
  battery?: Battery | null;
  /** null or absent if no camera has reported */
  gvs?: Gvs | null;
  /** absent from servers that do not state it */
  registry?: Registry;
  /** absent where no `cosiva up` has started the server */
  parts?: readonly Part[];
}

export interface Run {
  name: string;
  scenario: string | null;
  version: string;
  clock: { kind: 'wall' | 'virtual'; running: boolean; speed: number; time_ms: number };
}

/** Ground truth of the emulated plant; shown together with the twins and used for no decision. */
export interface GroundTruth {
  vehicles: readonly ({ number: number } & Pose)[];
  obstacles: readonly { id: string; x: number; y: number; radius: number }[];
}

export interface Trace {
  n: number;
  time_ms: number;
  from: string;
  to: string;
  /** the proxy through which the message passed: “proxy of” sender or receiver */
  via?: string;
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
  addTags?: readonly TagPosition[];
  moveTags?: readonly TagPosition[];
  removeTags?: readonly number[];
  /** rotation: left positive [rad] */
  beacons?: { pitch?: number; origin?: Point; rotation?: number };
  priorities?: Readonly<Record<string, number>>;
}
export type TagPosition = { number: number; x: number; y: number } | { number: number; section: string; s: number };

export type LiveMessage =
  | { type: 'zone'; zone: Zone | null }
  | { type: 'run'; run: Run }
  | { type: 'snapshot'; snapshot: Snapshot }
  | { type: 'ground_truth'; vehicles: GroundTruth['vehicles']; obstacles: GroundTruth['obstacles'] };

/** Parses one text frame of the live stream; null for a type that only a newer server knows. */
export function parse_live(text: string): LiveMessage | null {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return null;
  }
  if (typeof value !== 'object' || value === null || !('type' in value)) return null;
  const known = value.type === 'zone' || value.type === 'run' || value.type === 'snapshot' || value.type === 'ground_truth';
  return known ? (value as LiveMessage) : null;
}
