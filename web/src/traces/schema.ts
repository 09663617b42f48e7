// A validator for the part of JSON Schema (2020-12) that the official VDA 5050 schemas use, and slightly more. Each error has
// a path and a sentence. An unsupported keyword is reported when a schema is loaded, and not ignored without a report later.
import { is_object, type Json, type JsonObject } from './json';

export interface Fault {
  /** "nodeStates[2].nodeId"; empty: the message itself */
  path: string;
  sentence: string;
}

const checked = new Set([
  'type', 'required', 'properties', 'additionalProperties', 'items', 'enum', 'const', 'minimum', 'maximum', 'exclusiveMinimum', 'exclusiveMaximum',
  'minLength', 'maxLength', 'pattern', 'format', 'minItems', 'maxItems', 'uniqueItems', '$ref', 'allOf', 'anyOf', 'oneOf',
]);
const annotations = new Set(['$schema', '$id', '$comment', 'title', 'description', 'examples', 'default', 'definitions', '$defs', 'subtopic', 'unit', 'deprecated', 'readOnly']);

/** Keywords of a schema, at any depth, that this validator does not support. */
export function unknown_keywords(schema: Json): string[] {
  const found = new Set<string>();
  const walk = (node: Json): void => {
    if (!is_object(node)) return;
    for (const [key, value] of Object.entries(node)) {
      if (key === 'properties' || key === 'definitions' || key === '$defs') Object.values(value as JsonObject).forEach(walk);
      else if (key === 'items' || key === 'additionalProperties') walk(value);
      else if (key === 'allOf' || key === 'anyOf' || key === 'oneOf') (value as readonly Json[]).forEach(walk);
      else if (!checked.has(key) && !annotations.has(key)) found.add(key);
    }
  };
  walk(schema);
  return [...found].sort();
}

export function validate(schema: JsonObject, value: Json): Fault[] {
  const faults: Fault[] = [];
  new Validation(schema, faults).check(schema, value, '');
  return faults;
}

export function join(path: string, step: string | number): string {
  if (typeof step === 'number') return `${path}[${step}]`;
  return path === '' ? step : `${path}.${step}`;
}

function type_of(value: Json): string {
  if (value === null) return 'null';
  if (Array.isArray(value)) return 'array';
  return typeof value;
}

const with_article: Readonly<Record<string, string>> = {
  string: 'a string', number: 'a number', integer: 'a whole number', boolean: 'true or false', array: 'a list', object: 'an object', null: 'null',
};

function fits(value: Json, type: string): boolean {
  if (type === 'integer') return typeof value === 'number' && Number.isInteger(value);
  return type_of(value) === type;
}

export function shown(value: Json): string {
  const text = JSON.stringify(value);
  return text.length > 40 ? `${text.slice(0, 38)}…` : text;
}

class Validation {
  constructor(
    private readonly root: JsonObject,
    private readonly faults: Fault[],
  ) {}

  check(schema: Json, value: Json, path: string): void {
    if (schema === false) return this.fault(path, 'is not permitted here.');
    if (!is_object(schema)) return;
    if (typeof schema['$ref'] === 'string') this.check(this.resolve(schema['$ref']), value, path);
    const types = schema['type'] === undefined ? [] : [schema['type']].flat().map(String);
    if (types.length > 0 && !types.some((type) => fits(value, type))) {
      // Length and range are not checked for a value of the wrong type.
      return this.fault(path, `must be ${types.map((type) => with_article[type] ?? type).join(' or ')}, and is ${shown(value)}.`);
    }
    this.choices(schema, value, path);
    if (typeof value === 'number') this.number(schema, value, path);
    else if (typeof value === 'string') this.text(schema, value, path);
    else if (Array.isArray(value)) this.list(schema, value, path);
    else if (is_object(value)) this.object(schema, value, path);
  }

  private fault(path: string, sentence: string): void {
    this.faults.push({ path, sentence });
  }

  private resolve(ref: string): Json {
    let node: Json | undefined = this.root;
    for (const step of ref.replace(/^#\/?/, '').split('/').filter((part) => part !== '')) {
      node = is_object(node) ? node[step.replaceAll('~1', '/').replaceAll('~0', '~')] : undefined;
    }
    if (!ref.startsWith('#') || node === undefined) throw new Error(`the schema refers to ${ref}, which it does not contain`);
    return node;
  }

  private choices(schema: JsonObject, value: Json, path: string): void {
    const same = (other: Json) => JSON.stringify(other) === JSON.stringify(value);
    const among = schema['enum'] as readonly Json[] | undefined;
    if (among && !among.some(same)) this.fault(path, `must be one of ${among.map((one) => shown(one)).join(', ')}, and is ${shown(value)}.`);
    if (schema['const'] !== undefined && !same(schema['const'])) this.fault(path, `must be ${shown(schema['const'])}, and is ${shown(value)}.`);
    for (const part of (schema['allOf'] as readonly Json[] | undefined) ?? []) this.check(part, value, path);
    const count = (parts: readonly Json[]) => parts.filter((part) => this.passes(part, value)).length;
    const any = schema['anyOf'] as readonly Json[] | undefined;
    if (any && count(any) === 0) this.fault(path, 'matches none of the forms that the schema allows.');
    const one = schema['oneOf'] as readonly Json[] | undefined;
    if (one && count(one) !== 1) this.fault(path, `must match exactly one of the forms that the schema allows, and matches ${count(one)}.`);
  }

  private passes(schema: Json, value: Json): boolean {
    const faults: Fault[] = [];
    new Validation(this.root, faults).check(schema, value, '');
    return faults.length === 0;
  }

  private number(schema: JsonObject, value: number, path: string): void {
    const bound = (key: string, holds: (limit: number) => boolean, search_text: string) => {
      const limit = schema[key];
      if (typeof limit === 'number' && !holds(limit)) this.fault(path, `must be ${search_text} ${limit}, and is ${value}.`);
    };
    bound('minimum', (limit) => value >= limit, 'at least');
    bound('maximum', (limit) => value <= limit, 'at most');
    bound('exclusiveMinimum', (limit) => value > limit, 'more than');
    bound('exclusiveMaximum', (limit) => value < limit, 'less than');
  }

  private text(schema: JsonObject, value: string, path: string): void {
    const length = [...value].length;
    const { minLength, maxLength, pattern, format } = schema;
    if (typeof minLength === 'number' && length < minLength) this.fault(path, `must have at least ${minLength} characters, and has ${length}.`);
    if (typeof maxLength === 'number' && length > maxLength) this.fault(path, `must have at most ${maxLength} characters, and has ${length}.`);
    if (typeof pattern === 'string' && !new RegExp(pattern, 'u').test(value)) this.fault(path, `must match ${pattern}, and is ${shown(value)}.`);
    if (format === 'date-time' && !is_date_time(value)) this.fault(path, `must be a time like 1991-03-11T11:40:03.12Z, and is ${shown(value)}.`);
  }

  private list(schema: JsonObject, value: readonly Json[], path: string): void {
    const { minItems, maxItems, items } = schema;
    if (typeof minItems === 'number' && value.length < minItems) this.fault(path, `must have at least ${minItems} entries, and has ${value.length}.`);
    if (typeof maxItems === 'number' && value.length > maxItems) this.fault(path, `must have at most ${maxItems} entries, and has ${value.length}.`);
    if (schema['uniqueItems'] === true && new Set(value.map((one) => JSON.stringify(one))).size < value.length) this.fault(path, 'must not have the same entry twice.');
    if (items !== undefined) value.forEach((one, i) => this.check(items, one, join(path, i)));
  }

  private object(schema: JsonObject, value: JsonObject, path: string): void {
    for (const name of (schema['required'] as readonly string[] | undefined) ?? []) {
      if (!Object.hasOwn(value, name)) this.fault(path, `“${name}” is missing; it is required here.`);
    }
    const properties = (schema['properties'] ?? {}) as JsonObject;
    for (const [name, one] of Object.entries(value)) {
      if (Object.hasOwn(properties, name)) this.check(properties[name]!, one, join(path, name));
      else if (schema['additionalProperties'] === false) this.fault(join(path, name), 'is not defined by the schema.');
      else if (schema['additionalProperties'] !== undefined) this.check(schema['additionalProperties'], one, join(path, name));
    }
  }
}

/** Whether a text is an RFC 3339 date and time with a valid day of the month. */
export function is_date_time(text: string): boolean {
  const match = /^(\d{4})-(\d\d)-(\d\d)[Tt](\d\d):(\d\d):(\d\d)(?:\.\d+)?(?:[Zz]|[+-](\d\d):(\d\d))$/.exec(text);
  if (!match) return false;
  const [year, month, day, hour, minute, second, zone_hour, zone_minute] = match.slice(1).map((part) => Number(part ?? 0)) as [number, number, number, number, number, number, number, number];
  const days = new Date(Date.UTC(year, month, 0)).getUTCDate();
  return month >= 1 && month <= 12 && day >= 1 && day <= days && hour <= 23 && minute <= 59 && second <= 60 && zone_hour <= 23 && zone_minute <= 59;
}
