// The official VDA 5050 2.1.0 schemas, loaded when the first message is opened.
import type { Json, JsonObject } from './json';
import { validate, type Fault } from './schema';

export const vda_kinds = ['connection', 'factsheet', 'instantActions', 'order', 'state', 'visualization'] as const;
export type VdaKind = (typeof vda_kinds)[number];

/** The kind of a VDA 5050 topic such as interface/v2/manufacturer/serial/order; null for other topics. */
export function vda_kind_of(topic: string): VdaKind | null {
  const levels = topic.split('/');
  if (levels.length !== 5 || levels.some((level) => level === '') || !/^v\d+$/.test(levels[1]!) || levels[0] === 'cosiva') return null;
  return vda_kinds.find((kind) => kind === levels[4]) ?? null;
}

let loading: Promise<Record<VdaKind, JsonObject>> | null = null;

export async function vda_schema(kind: VdaKind): Promise<JsonObject> {
  loading ??= import('./vda_schemas').then(({ schemas }) => mended(structuredClone(schemas)));
  try {
    return (await loading)[kind];
  } catch (problem) {
    loading = null; // a failed load may be repeated
    throw problem;
  }
}

export async function vda_faults(kind: VdaKind, message: Json): Promise<Fault[]> {
  return validate(await vda_schema(kind), message);
}

/**
 * Corrects errors of the schemas where they contradict the document, which takes precedence (2.1.0, clause 6): actionStatus
 * lacks PAUSED (6.11), and the enum of blockingTypes is on the list instead of its entries.
 */
function mended(schemas: Record<VdaKind, JsonObject>): Record<VdaKind, JsonObject> {
  const status = at(schemas.state, 'properties', 'actionStates', 'items', 'properties', 'actionStatus') as { enum: string[] };
  if (!status.enum.includes('PAUSED')) status.enum.push('PAUSED');
  const blocking = at(schemas.factsheet, 'properties', 'protocolFeatures', 'properties', 'agvActions', 'items', 'properties', 'blockingTypes') as { enum?: string[]; items?: Json };
  if (blocking.enum) {
    blocking.items = { type: 'string', enum: blocking.enum };
    delete blocking.enum;
  }
  return schemas;
}

function at(node: Json, ...steps: readonly string[]): unknown {
  return steps.reduce<unknown>((one, step) => (one as Record<string, unknown>)[step], node);
}
