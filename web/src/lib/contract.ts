// The server's HTTP and WebSocket contract, docs/protocols/hmi-api.md. Metres, radians, m/s, milliseconds, percent.

export type Point = readonly [x: number, y: number];

export interface Primitive {
  shape: 'polyline' | 'polygon' | 'disc' | 'text';
  layer: string;
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
}

export interface Pose {
  x: number;
  y: number;
  heading: number;
}

export interface Aiv extends Pose {
  id: string;
  number: number;
  connection: 'ONLINE' | 'OFFLINE' | 'CONNECTIONBROKEN';
  /** no report came for a second */
  lost: boolean;
  /** one of A7's five words */
  status: string;
  speed: number;
  /** null where the twin is on no section: a foreign vehicle beside the circuit, or no zone yet */
  section: string | null;
  s: number | null;
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
  errors: readonly string[];
  contract: { matched: boolean; divergence: boolean; age: boolean };
}

export interface Crossing {
  name: string;
  heldBy: string | null;
  waiting: readonly string[];
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
  divergence_m: Statistics;
  divergence_rad: Statistics;
  age_ms: Statistics;
  commands: { issued: number; accepted: number; materialised: number; failed: number; latency_ms: Statistics };
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
}

export const default_limits: ContractLimits = {
  divergence_p99_m: 0.03,
  age_p99_ms: 150,
  command_p99_ms: 2000,
  event_p99_ms: 500,
};

export type CommandVerb = 'stop' | 'slow' | 'medium' | 'fast' | 'restart' | 'cancel';
export type CommandState = 'issued' | 'accepted' | 'materialised' | 'failed';

export interface Command {
  id: string;
  vehicle: string;
  command: CommandVerb;
  state: CommandState;
  time_ms: number;
  accepted_ms: number | null;
  materialised_ms: number | null;
  reason: string;
}

export interface Snapshot {
  time: string;
  /** of the server's clock, Unix milliseconds */
  time_ms: number;
  zoneRevision: number;
  aivs: readonly Aiv[];
  crossings: readonly Crossing[];
  bijection: Bijection;
  commands: readonly Command[];
}

export type LiveMessage = { type: 'zone'; zone: Zone | null } | { type: 'snapshot'; snapshot: Snapshot };

/** Reads one frame of the live stream; nothing where it is not one we know (a newer server may say more). */
export function parse_live(text: string): LiveMessage | null {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return null;
  }
  if (typeof value !== 'object' || value === null || !('type' in value)) return null;
  if (value.type === 'zone' && 'zone' in value) return value as LiveMessage;
  if (value.type === 'snapshot' && 'snapshot' in value) return value as LiveMessage;
  return null;
}
