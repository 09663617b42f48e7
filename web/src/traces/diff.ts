// The changes between two successive messages of a topic.
import { is_object, type Json, type JsonObject } from './json';
import { join } from './schema';

export interface Change {
  /** path in the newer message; for a removed value, its path in the older one */
  path: string;
  what: 'added' | 'changed' | 'removed';
  /** the older value, if there was one */
  was?: Json;
  /** path of the containing value in the newer message */
  within: string;
}

/** Keys of the entries in VDA 5050's lists: an entry that only moved in its list has not changed. */
const identities: readonly (readonly string[])[] = [['actionId'], ['nodeId', 'sequenceId'], ['edgeId', 'sequenceId'], ['id'], ['board'], ['key'], ['referenceKey', 'referenceValue'], ['infoType'], ['errorType', 'errorDescription']];

export function diff(older: Json, newer: Json): Change[] {
  const changes: Change[] = [];
  compare(older, newer, '', '', changes);
  return changes;
}

function compare(older: Json, newer: Json, path: string, old_path: string, changes: Change[]): void {
  if (is_object(older) && is_object(newer)) return compare_objects(older, newer, path, old_path, changes);
  if (Array.isArray(older) && Array.isArray(newer)) return compare_lists(older as readonly Json[], newer as readonly Json[], path, old_path, changes);
  if (older !== newer) changes.push({ path, what: 'changed', was: older, within: path });
}

function compare_objects(older: JsonObject, newer: JsonObject, path: string, old_path: string, changes: Change[]): void {
  for (const [key, value] of Object.entries(newer)) {
    if (Object.hasOwn(older, key)) compare(older[key]!, value, join(path, key), join(old_path, key), changes);
    else changes.push({ path: join(path, key), what: 'added', within: join(path, key) });
  }
  for (const [key, value] of Object.entries(older)) {
    if (!Object.hasOwn(newer, key)) changes.push({ path: join(old_path, key), what: 'removed', was: value, within: path });
  }
}

function compare_lists(older: readonly Json[], newer: readonly Json[], path: string, old_path: string, changes: Change[]): void {
  const identity = identity_of(older, newer);
  if (identity === null) {
    for (let i = 0; i < Math.max(older.length, newer.length); i++) {
      if (i >= older.length) changes.push({ path: join(path, i), what: 'added', within: join(path, i) });
      else if (i >= newer.length) changes.push({ path: join(old_path, i), what: 'removed', was: older[i]!, within: path });
      else compare(older[i]!, newer[i]!, join(path, i), join(old_path, i), changes);
    }
    return;
  }
  const before = new Map(older.map((entry, i) => [identity(entry), i]));
  newer.forEach((entry, i) => {
    const at = before.get(identity(entry));
    if (at === undefined) changes.push({ path: join(path, i), what: 'added', within: join(path, i) });
    else compare(older[at]!, entry, join(path, i), join(old_path, at), changes);
  });
  const after = new Set(newer.map(identity));
  older.forEach((entry, i) => {
    if (!after.has(identity(entry))) changes.push({ path: join(old_path, i), what: 'removed', was: entry, within: path });
  });
}

/** The key that identifies all entries of both lists; null if there is none. */
function identity_of(older: readonly Json[], newer: readonly Json[]): ((entry: Json) => string) | null {
  for (const fields of identities) {
    const has_all = (entry: Json) => is_object(entry) && fields.every((field) => typeof entry[field] === 'string' || typeof entry[field] === 'number');
    if (![...older, ...newer].every(has_all)) continue;
    const identity = (entry: Json) => JSON.stringify(fields.map((field) => (entry as JsonObject)[field]));
    const all_differ = (list: readonly Json[]) => new Set(list.map(identity)).size === list.length;
    if (all_differ(older) && all_differ(newer)) return identity;
  }
  return null;
}
