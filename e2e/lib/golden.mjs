// Goldens: files with the platform's recorded output, served documents and published messages.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { source_dir } from './platform.mjs';

const root = path.join(source_dir, 'e2e/golden');
const recording = Boolean(process.env.COSIVA_RECORD);
const how = 'If the change is meant: scripts/golden records the goldens anew; name the reason in the commit.';
const lines_max = 24;

/** The goldens below one folder (or one file) of e2e/golden. */
export class Goldens {
  constructor(place = '') {
    this.place = place;
    this.seen = new Set();
    this.faults = [];
  }

  /** Compares one text with its golden, or records it. Every difference is collected; finish() reports them all. */
  compare(name, text) {
    const file = path.join(this.place, name);
    const whole = text.endsWith('\n') ? text : `${text}\n`;
    const golden = path.join(root, file);
    this.seen.add(file);
    if (recording) {
      mkdirSync(path.dirname(golden), { recursive: true });
      writeFileSync(golden, whole);
    } else if (!existsSync(golden)) {
      this.faults.push(`e2e/golden/${file}: there is no such golden; this would be it:\n${indent(whole.split('\n').slice(0, 6))}`);
    } else {
      const difference = first_difference(readFileSync(golden, 'utf8'), whole);
      if (difference) this.faults.push(`e2e/golden/${file} differs (- golden, + now):\n${difference}`);
    }
  }

  /** A golden of a whole folder with which nothing was compared is stale: its subject no longer exists. */
  finish() {
    if (this.place !== '') {
      const folder = path.join(root, this.place);
      for (const name of existsSync(folder) ? readdirSync(folder) : []) {
        const file = path.join(this.place, name);
        if (this.seen.has(file)) continue;
        if (recording) rmSync(path.join(root, file));
        else this.faults.push(`e2e/golden/${file}: what it is a golden of is no longer there`);
      }
    }
    assert.ok(this.seen.size > 0, 'nothing was compared');
    if (this.faults.length > 0) assert.fail(`${this.faults.join('\n\n')}\n\n${how}`);
  }
}

const indent = (lines) => lines.map((line) => `    ${line.length > 300 ? `${line.slice(0, 300)}…` : line}`).join('\n');

/**
 * Lines that differ, with their numbers; empty where none does. The search resynchronises after inserted or removed
 * lines.
 */
export function first_difference(golden, now) {
  if (golden === now) return '';
  const before = golden.split('\n');
  const after = now.split('\n');
  const out = [];
  let b = 0;
  let a = 0;
  while ((b < before.length || a < after.length) && out.length < lines_max) {
    if (b < before.length && a < after.length && before[b] === after[a]) {
      b++;
      a++;
      continue;
    }
    const [removed, added] = next_common(before, b, after, a);
    for (let i = b; i < b + removed; i++) out.push(`${i + 1} - ${around(before[i], after[a + i - b])}`);
    for (let i = a; i < a + added; i++) out.push(`${i + 1} + ${around(after[i], before[b + i - a])}`);
    b += removed;
    a += added;
  }
  if (out.length >= lines_max) out.splice(lines_max, Infinity, '… and more');
  return indent(out);
}

/** The number of differing lines of each text before both are equal again. */
function next_common(before, b, after, a) {
  for (let sum = 1; sum < 200; sum++) {
    for (let removed = 0; removed <= sum; removed++) {
      const added = sum - removed;
      if (b + removed < before.length && a + added < after.length && before[b + removed] === after[a + added]) return [removed, added];
    }
  }
  return [before.length - b, after.length - a];
}

/** A long line is shown from shortly before the position where it differs from the other. */
function around(line, other) {
  if (line.length < 200 || other === undefined) return line;
  let at = 0;
  while (at < line.length && line[at] === other[at]) at++;
  return at > 60 ? `…${line.slice(at - 40)}` : line;
}

/** JSON text with a line for each member and unchanged tokens: numbers keep their digits. */
export function spread_json(raw) {
  const out = [];
  let depth = 0;
  const line = () => out.push(`\n${'  '.repeat(depth)}`);
  for (const [token] of raw.matchAll(/"(?:[^"\\]|\\.)*"|\[[-+.\deE,]*\]|[{}[\],:]|[^\s"{}[\],:]+/gs)) {
    if (token === '{' || token === '[') {
      out.push(token);
      depth++;
      line();
    } else if (token === '}' || token === ']') {
      depth--;
      line();
      out.push(token);
    } else if (token === ',') {
      out.push(token);
      line();
    } else {
      out.push(token === ':' ? ': ' : token);
    }
  }
  return out.join('');
}
