// Resolves the handles of the binary frames to objects, and a point of the map to the object there.
import type { Aiv, Point, DetectedObstacle, Snapshot, VirtualObject, GroundTruth, Zone } from '../live/contract';
import * as format from '../live/format';
import { inside } from './geometry';
import type { Positions } from '../live/positions';

export interface AivEntry {
  kind: 'aiv';
  id: string;
  label: string;
  name: string;
  aiv: Aiv;
  /** the reserved path, x, y, x, y … [m] */
  reserved: Float32Array;
}
export interface VirtualObjectEntry {
  kind: 'person' | 'obstacle';
  id: string;
  virtualObject: VirtualObject;
  path: Float32Array | null;
}
export interface DetectedEntry {
  kind: 'detected';
  id: string;
  obstacle: DetectedObstacle;
}
export type Entry = AivEntry | VirtualObjectEntry | DetectedEntry;

const none = new Float32Array(0);

export class MapIndex {
  readonly by_handle = new Map<number, Entry>();
  readonly by_id = new Map<string, Entry>();
  private snapshot: Snapshot | null = null;

  /** Updates the index from a snapshot, once per snapshot. */
  accept(snapshot: Snapshot | null): void {
    if (snapshot === this.snapshot || snapshot === null) return;
    this.snapshot = snapshot;
    const gone = new Set(this.by_id.keys());
    const keep = (handle: number, entry: Entry) => {
      gone.delete(entry.id);
      this.by_id.set(entry.id, entry);
      this.by_handle.set(handle, entry);
    };
    // Entries are reused between snapshots, because a large fleet would otherwise cause much garbage collection.
    this.by_handle.clear();
    for (const aiv of snapshot.aivs) {
      const old = this.by_id.get(aiv.id);
      if (old?.kind === 'aiv') {
        old.aiv = aiv;
        old.reserved = flat_into(aiv.reserved, old.reserved);
        keep(aiv.handle, old);
      } else keep(aiv.handle, { kind: 'aiv', id: aiv.id, label: label_of(aiv), name: format.serial(aiv.id), aiv, reserved: flat_into(aiv.reserved, none) });
    }
    for (const virtualObject of snapshot.virtualObjects ?? []) {
      const path = virtualObject.path && virtualObject.path.length > 1 ? flat_into(virtualObject.repeat === 'loop' ? [...virtualObject.path, virtualObject.path[0]!] : virtualObject.path, none) : null;
      keep(virtualObject.handle, { kind: virtualObject.kind, id: virtualObject.id, virtualObject, path });
    }
    for (const obstacle of snapshot.obstacles ?? []) keep(obstacle.handle, { kind: 'detected', id: obstacle.id, obstacle });
    for (const id of gone) this.by_id.delete(id);
  }

  radius(handle: number): number {
    const entry = this.by_handle.get(handle);
    if (!entry || entry.kind === 'aiv') return 0.06;
    return entry.kind === 'detected' ? entry.obstacle.radius : entry.virtualObject.radius;
  }

  handle(id: string | null): number {
    const entry = id === null ? undefined : this.by_id.get(id);
    if (!entry) return -1;
    return entry.kind === 'aiv' ? entry.aiv.handle : entry.kind === 'detected' ? entry.obstacle.handle : entry.virtualObject.handle;
  }
}

/** Virtual AIVs are numbered separately; the V distinguishes them from physical ones. */
export function label_of(aiv: Aiv): string {
  return aiv.augmented ? format.serial(aiv.id).slice(0, 4) : format.label(aiv.id, aiv.number);
}

function flat_into(points: readonly Point[] | undefined, room: Float32Array): Float32Array {
  const count = points?.length ?? 0;
  const flat = room.length === 2 * count ? room : new Float32Array(2 * count);
  for (let i = 0; i < count; i++) {
    flat[2 * i] = points![i]![0];
    flat[2 * i + 1] = points![i]![1];
  }
  return flat;
}

export type HitKind = Entry['kind'] | 'plant' | 'tag' | 'station' | 'crossing';
export interface Hit {
  kind: HitKind;
  id: string;
  x: number;
  y: number;
  /** whether a drag can move the object */
  movable: boolean;
}

export interface Field {
  positions: Positions;
  index: MapIndex;
  ground_truth: GroundTruth | null;
  zone: Zone | null;
  hidden: ReadonlySet<string>;
}

/** The object at a point, preferring small objects over large ones. @param slack  tolerance around the point [m] */
export function hit_at(field: Field, x: number, y: number, slack: number, prefer_tags = false): Hit | null {
  const tag = tag_at(field, x, y, slack);
  if (prefer_tags && tag) return tag;
  return body_at(field, x, y, slack) ?? plant_at(field, x, y, slack) ?? station_at(field, x, y, slack) ?? tag ?? crossing_at(field, x, y);
}

function body_at({ positions, index, zone, hidden }: Field, x: number, y: number, slack: number): Hit | null {
  const body = 0.6 * (zone?.vehicle.length_m ?? 0.2);
  let best: Hit | null = null;
  let nearest = Infinity;
  for (let i = 0; i < positions.count; i++) {
    const away = Math.hypot(positions.x[i]! - x, positions.y[i]! - y);
    if (away > body + slack || away >= nearest) continue;
    const entry = index.by_handle.get(positions.handle[i]!);
    if (!entry || (entry.kind === 'person' && hidden.has('persons')) || (entry.kind !== 'aiv' && entry.kind !== 'person' && hidden.has('obstacles'))) continue;
    if (entry.kind !== 'aiv' && away > index.radius(positions.handle[i]!) + slack) continue;
    nearest = away;
    const movable = entry.kind === 'aiv' ? entry.aiv.augmented : entry.kind !== 'detected';
    best = { kind: entry.kind, id: entry.id, x: positions.x[i]!, y: positions.y[i]!, movable };
  }
  return best;
}

function plant_at({ ground_truth, hidden }: Field, x: number, y: number, slack: number): Hit | null {
  if (hidden.has('obstacles')) return null;
  const found = ground_truth?.obstacles.find((one) => Math.hypot(one.x - x, one.y - y) <= one.radius + slack);
  return found ? { kind: 'plant', id: found.id, x: found.x, y: found.y, movable: false } : null;
}

function tag_at({ zone, hidden }: Field, x: number, y: number, slack: number): Hit | null {
  if (hidden.has('tag')) return null;
  let best: Hit | null = null;
  let nearest = 0.025 + slack;
  for (const tag of zone?.tags ?? []) {
    const away = Math.hypot(tag.x - x, tag.y - y);
    if (away > nearest) continue;
    nearest = away;
    best = { kind: 'tag', id: String(tag.number), x: tag.x, y: tag.y, movable: false };
  }
  return best;
}

function station_at({ zone, hidden }: Field, x: number, y: number, slack: number): Hit | null {
  if (hidden.has('station')) return null;
  let best: Hit | null = null;
  let nearest = 0.45 * (zone?.vehicle.width_m ?? 0.12) + slack / 2;
  for (const station of zone?.stations ?? []) {
    const away = Math.hypot(station.x - x, station.y - y);
    if (away > nearest) continue;
    nearest = away;
    best = { kind: 'station', id: station.name, x: station.x, y: station.y, movable: false };
  }
  return best;
}

function crossing_at({ zone, hidden }: Field, x: number, y: number): Hit | null {
  if (hidden.has('crossing')) return null;
  for (const primitive of zone?.primitives ?? []) {
    if (primitive.layer !== 'crossing' || primitive.shape === 'text' || !primitive.label) continue;
    const [px, py] = primitive.points[0]!;
    const within = primitive.shape === 'disc' ? Math.hypot(px - x, py - y) <= primitive.size_m : inside(primitive.points, x, y);
    if (within) return { kind: 'crossing', id: primitive.label, x, y, movable: false };
  }
  return null;
}
