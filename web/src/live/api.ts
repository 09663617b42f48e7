// The HTTP calls of docs/protocols/hmi-api.md. Each returns the server's response or an error message for the operator;
// no call throws.
import type { CommandName, Point, Repeat, Run, Traces, WholeTrace, ZoneEdit } from './contract';
import type { StopResponse } from './stops';

export type ApiResponse<T> = { ok: true; value: T } | { ok: false; status: number; sentence: string };

const timeout_ms = 3_000;
/** The server reads and checks a large zone before it responds. */
const timeout_with_zones_ms = 120_000;

export async function call<T>(method: string, path: string, body?: unknown, wait_ms = timeout_ms): Promise<ApiResponse<T>> {
  try {
    const response = await fetch(`api/v1/${path}`, {
      method,
      ...(body === undefined ? {} : { headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) }),
      signal: AbortSignal.timeout(wait_ms),
    });
    const text = await response.text();
    const value = parse(text);
    if (response.ok) return { ok: true, value: value as T };
    const reason = (value as { error?: { message?: unknown } } | undefined)?.error?.message;
    return { ok: false, status: response.status, sentence: typeof reason === 'string' ? reason : `The server refused it (${response.status}).` };
  } catch {
    return { ok: false, status: 0, sentence: 'The server does not respond. It may be restarting; try again in a moment.' };
  }
}

function parse(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

const id_of = (id: string) => encodeURIComponent(id);

export const api = {
  command: (command: CommandName, vehicles: '*' | readonly string[]) =>
    call<{ id: string } | StopResponse>('POST', 'commands', vehicles === '*' ? { command, vehicle: '*' } : vehicles.length === 1 ? { command, vehicle: vehicles[0] } : { command, vehicles }),
  stop: (id: string) => call<StopResponse>('GET', `commands/${id_of(id)}`),
  go: (vehicle: string, to: string) => call<{ id: string }>('POST', 'commands', { command: 'go', vehicle, to }),
  circulate: (vehicle: string, loop: string | null) => call<{ id: string }>('POST', 'commands', { command: 'circulate', vehicle, ...(loop === null ? {} : { loop }) }),
  close_section: (section: string, closed: boolean) => call<{ id: string }>('POST', 'commands', { command: closed ? 'close' : 'open', section }),
  add_aiv: (position?: { x: number; y: number }) => call<{ id: string }>('POST', 'virtual-objects', { kind: 'aiv', ...position }),
  add_person: (position: { x: number; y: number; radius?: number }) => call<{ id: string }>('POST', 'virtual-objects', { kind: 'person', ...position }),
  add_walk: (path: readonly Point[], speed: number, repeat: Repeat) => call<{ id: string }>('POST', 'virtual-objects', { kind: 'person', path, speed, repeat }),
  add_obstacle: (position: { x: number; y: number; radius?: number }) => call<{ id: string }>('POST', 'virtual-objects', { kind: 'obstacle', ...position }),
  move_virtual_object: (id: string, position: { x: number; y: number }) => call<{ id: string }>('PATCH', `virtual-objects/${id_of(id)}`, position),
  remove_virtual_object: (id: string) => call<{ removed: number }>('DELETE', `virtual-objects/${id_of(id)}`),
  remove_all_virtual_objects: () => call<{ removed: number }>('DELETE', 'virtual-objects'),
  priorities: (priorities: Readonly<Record<string, number>>) => call<object>('PUT', 'priorities', priorities),
  edit_zone: (edit: ZoneEdit) => call<{ revision: number }>('POST', 'zone/edit', edit),
  undo_zone: () => call<{ revision: number }>('POST', 'zone/undo'),
  redo_zone: () => call<{ revision: number }>('POST', 'zone/redo'),
  save_zone: () => call<{ file: string }>('POST', 'zone/save'),
  switch_zone: (zone: { name: string } | { file: string; text: string; sidecar?: string }) => call<{ revision: number; name: string }>('POST', 'zone/switch', zone, timeout_with_zones_ms),
  suggest_beacons: () => call<{ origin: Point; now_m: number | null; longest_free_m: number | null }>('GET', 'zone/beacons/suggestion', undefined, timeout_with_zones_ms),
  zones: () => call<{ zones: { name: string; title: string; current: boolean }[] }>('GET', 'zones'),
  add_plant_obstacle: (position: { x: number; y: number; radius?: number }) => call<{ id: string }>('POST', 'plant/obstacles', position),
  remove_plant_obstacle: (id: string) => call<{ removed: number }>('DELETE', `plant/obstacles/${id_of(id)}`),
  run: () => call<Run>('GET', 'run'),
  clock: (clock: { running?: boolean; speed?: number }) => call<object>('PUT', 'clock', clock),
  step: (ms: number) => call<object>('POST', 'clock/step', { ms }),
  traces: (after: number, limit: number) => call<Traces>('GET', `traces?after=${after}&limit=${limit}`),
  trace: (n: number) => call<WholeTrace>('GET', `traces/${n}`),
};
