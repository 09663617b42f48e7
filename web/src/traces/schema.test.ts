import { describe, expect, it } from 'vitest';
import type { Json, JsonObject } from './json';
import { is_date_time, unknown_keywords, validate } from './schema';
import { vda_faults, vda_kind_of, vda_kinds, vda_schema, type VdaKind } from './vda';

const files = import.meta.glob<string>('../../../src/wire/vda5050/schemas/*.schema', { query: '?raw', import: 'default', eager: true });
const file_of = (kind: VdaKind) => JSON.parse(Object.entries(files).find(([path]) => path.endsWith(`/${kind}.schema`))![1]) as JsonObject;

/** The smallest message that a schema accepts, made of its examples where it has some. */
function smallest(schema: JsonObject, root = schema): Json {
  const node = typeof schema['$ref'] === 'string' ? ((root['definitions'] as JsonObject)[schema['$ref'].split('/').at(-1)!] as JsonObject) : schema;
  if (node['enum']) return (node['enum'] as Json[])[0]!;
  if (node['examples']) return (node['examples'] as Json[])[0]!;
  const type = [node['type']].flat()[0];
  if (type === 'object') {
    const names = (node['required'] ?? []) as string[];
    return Object.fromEntries(names.map((name) => [name, smallest((node['properties'] as JsonObject)[name] as JsonObject, root)]));
  }
  if (type === 'array') return [smallest(node['items'] as JsonObject, root)];
  if (type === 'boolean') return true;
  if (type === 'string') return node['format'] === 'date-time' ? '1991-03-11T11:40:03.12Z' : 'word';
  return Number(node['minimum'] ?? 0);
}
const message = (kind: VdaKind) => smallest(mended_for_examples(kind)) as { [key: string]: Json };
/** Corrects the factsheet schema, which accepts no list of blocking types; see vda.ts. */
function mended_for_examples(kind: VdaKind): JsonObject {
  const text = JSON.stringify(file_of(kind));
  return JSON.parse(text.replace(/"type":"array","description":"([^"]*)","enum":(\[[^\]]*\])(,"items":\{[^}]*\})?/g, '"type":"array","items":{"type":"string","enum":$2}')) as JsonObject;
}

describe('the official schemas', () => {
  it.each(vda_kinds)('%s uses no keyword that the validator ignores', (kind) => {
    expect(unknown_keywords(file_of(kind))).toEqual([]);
  });
  it('contain no unknown keyword at any depth', () => {
    expect(unknown_keywords({ properties: { a: { items: { contains: {} } } }, oneOf: [{ multipleOf: 2 }] })).toEqual(['contains', 'multipleOf']);
  });
  it.each(vda_kinds)('%s accepts the smallest message made from its own examples', async (kind) => {
    expect(await vda_faults(kind, message(kind))).toEqual([]);
  });
  it.each(vda_kinds)('%s reports each missing required field', async (kind) => {
    for (const name of (file_of(kind)['required'] as string[] | undefined) ?? []) {
      const { [name]: _left_out, ...rest } = message(kind);
      expect(await vda_faults(kind, rest)).toEqual([{ path: '', sentence: `“${name}” is missing; it is required here.` }]);
    }
  });
  it.each(vda_kinds)('%s rejects each field with a value of the wrong type', async (kind) => {
    for (const [name, value] of Object.entries(message(kind))) {
      const wrong: Json = typeof value === 'object' ? 'word' : {};
      const faults = await vda_faults(kind, { ...message(kind), [name]: wrong });
      expect(faults.map((fault) => fault.path), name).toContain(name);
    }
  });
  it('are corrected where the document is right: PAUSED is a status, blocking types are a list', async () => {
    const state = message('state');
    const paused = { ...state, actionStates: [{ actionId: 'a', actionType: 'startPause', actionStatus: 'PAUSED' }] };
    expect(await vda_faults('state', paused)).toEqual([]);
    expect(JSON.stringify(await vda_schema('factsheet'))).toContain('"blockingTypes":{"type":"array","items":{"type":"string","enum":["NONE","SOFT","HARD"]}}');
  });
});

describe('schema errors', () => {
  it('have the path of their location, at any depth', async () => {
    const order = message('order');
    const node = (order['nodes'] as JsonObject[])[0]!;
    const bad = { ...order, nodes: [node, { ...node, nodePosition: { x: 'left', y: 0, mapId: 'm', theta: 4 } }] };
    expect(await vda_faults('order', bad)).toEqual([
      { path: 'nodes[1].nodePosition.x', sentence: 'must be a number, and is "left".' },
      { path: 'nodes[1].nodePosition.theta', sentence: 'must be at most 3.14159265359, and is 4.' },
    ]);
  });
  it('list the values of an enumeration', async () => {
    const faults = await vda_faults('connection', { ...message('connection'), connectionState: 'ONLIN' });
    expect(faults[0]).toEqual({ path: 'connectionState', sentence: 'must be one of "ONLINE", "OFFLINE", "CONNECTIONBROKEN", and is "ONLIN".' });
  });
  it.each<[string, JsonObject, Json, string]>([
    ['whole numbers', { type: 'integer' }, 1.5, 'must be a whole number, and is 1.5.'],
    ['a choice of types', { type: ['string', 'null'] }, 3, 'must be a string or null, and is 3.'],
    ['a minimum', { minimum: 0 }, -1, 'must be at least 0, and is -1.'],
    ['a minimum that is not reached', { exclusiveMinimum: 0 }, 0, 'must be more than 0, and is 0.'],
    ['a maximum that is not reached', { exclusiveMaximum: 9 }, 9, 'must be less than 9, and is 9.'],
    ['a pattern', { pattern: '^[0-9]+$' }, 'x', 'must match ^[0-9]+$, and is "x".'],
    ['a shortest text', { minLength: 2 }, 'é', 'must have at least 2 characters, and has 1.'],
    ['a longest text', { maxLength: 1 }, 'ab', 'must have at most 1 characters, and has 2.'],
    ['a shortest list', { minItems: 1 }, [], 'must have at least 1 entries, and has 0.'],
    ['a longest list', { maxItems: 1 }, [1, 2], 'must have at most 1 entries, and has 2.'],
    ['different entries', { uniqueItems: true }, [1, 1], 'must not have the same entry twice.'],
    ['a constant', { const: 'a' }, 'b', 'must be "a", and is "b".'],
    ['one of several forms', { anyOf: [{ type: 'string' }, { minimum: 5 }] }, 3, 'matches none of the forms that the schema allows.'],
    ['exactly one of several forms', { oneOf: [{ minimum: 0 }, { minimum: 1 }] }, 3, 'must match exactly one of the forms that the schema allows, and matches 2.'],
    ['a time', { format: 'date-time' }, 'yesterday', 'must be a time like 1991-03-11T11:40:03.12Z, and is "yesterday".'],
  ])('against %s', (_, schema, value, sentence) => {
    expect(validate(schema, value)).toEqual([{ path: '', sentence }]);
  });
  it('include unknown fields only where the schema forbids them', () => {
    const value = { a: 1, b: 2 };
    expect(validate({ properties: { a: {} } }, value)).toEqual([]);
    expect(validate({ properties: { a: {} }, additionalProperties: false }, value)).toEqual([{ path: 'b', sentence: 'is not defined by the schema.' }]);
    expect(validate({ properties: { a: {} }, additionalProperties: { type: 'string' } }, value)).toEqual([{ path: 'b', sentence: 'must be a string, and is 2.' }]);
  });
  it('treat a field named like a built-in property as a field', () => {
    expect(validate({ type: 'object', required: ['toString'], properties: {} }, {})).toHaveLength(1);
  });
  it('include a reference without a target', () => {
    expect(() => validate({ $ref: '#/definitions/none' }, 1)).toThrow(/does not contain/);
  });
});

describe('timestamps', () => {
  it.each(['1991-03-11T11:40:03.12Z', '2024-02-29T23:59:60Z', '2026-01-01T00:00:00+01:00'])('%s is valid', (text) => expect(is_date_time(text)).toBe(true));
  it.each(['2023-02-29T00:00:00Z', '2026-13-01T00:00:00Z', '2026-01-01 00:00:00Z', '2026-01-01T24:00:00Z', '2026-01-01T00:00:00', ''])('%s is invalid', (text) => expect(is_date_time(text)).toBe(false));
});

describe('the schema of a topic', () => {
  it.each<[string, VdaKind | null]>([
    ['uagv/v2/CoSiVA/AIV1/state', 'state'],
    ['uagv/v2/RobotCompany/001/instantActions', 'instantActions'],
    ['cosiva/v1/virtual_obstacles_ack/CoSiVA/AIV1', null],
    ['cosiva/v1/server/x/connection', null],
    ['uagv/v2/CoSiVA/AIV1/unheard', null],
    ['uagv/v2//AIV1/state', null],
    ['', null],
  ])('%s has %s', (topic, kind) => expect(vda_kind_of(topic)).toBe(kind));
});
