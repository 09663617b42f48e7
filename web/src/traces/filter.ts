// Filters the rows of the store. The matching rows form a list of sequence numbers. New rows extend its end; a search of the
// store from the newest row backwards extends its beginning, in slices short enough for the page to paint.
import { chunk_rows, note_kind, type Chunk, type Names, type TraceStore } from './store';

export interface Filter {
  /** sender or receiver; empty: any */
  agent: string;
  /** excluded kinds */
  kinds_off: ReadonlySet<string>;
  /** search_text, each of which must occur in the content, the kind or a name */
  text: string;
  /** sender and receiver must both be among these; null: any */
  between: ReadonlySet<string> | null;
}
export const no_filter: Filter = { agent: '', kinds_off: new Set(), text: '', between: null };

export function filters(filter: Filter): boolean {
  return filter.agent !== '' || filter.kinds_off.size > 0 || filter.text.trim() !== '' || filter.between !== null;
}

/** A list of sequence numbers in the store, oldest first. */
export interface RowList {
  readonly length: number;
  /** sequence number of the i-th row */
  at(i: number): number;
  /** index of the row with this sequence number, or of the first one after it */
  index_of(seq: number): number;
}

/** All rows of the store. */
export class AllRows implements RowList {
  constructor(private readonly store: TraceStore) {}
  get length(): number {
    return this.store.length;
  }
  at(i: number): number {
    return this.store.first + i;
  }
  index_of(seq: number): number {
    return Math.max(0, Math.min(seq - this.store.first, this.store.length));
  }
}

/** An explicit list of rows, such as an exchange. Rows that the store has dropped are skipped. */
export class NamedRows implements RowList {
  constructor(
    private readonly seqs: readonly number[],
    private readonly store: TraceStore,
  ) {}
  private get gone(): number {
    const first = this.store.first;
    if (this.seqs.length === 0 || this.seqs[0]! >= first) return 0;
    const found = this.seqs.findIndex((seq) => seq >= first);
    return found < 0 ? this.seqs.length : found;
  }
  get length(): number {
    return this.seqs.length - this.gone;
  }
  at(i: number): number {
    return this.seqs[i + this.gone]!;
  }
  index_of(seq: number): number {
    const found = this.seqs.findIndex((one) => one >= seq);
    return (found < 0 ? this.seqs.length : found) - this.gone;
  }
}

/** A growing array of numbers, 8 bytes each. */
class NumberList {
  private values = new Float64Array(1024);
  length = 0;
  push(value: number): void {
    if (this.length === this.values.length) {
      const larger = new Float64Array(2 * this.values.length);
      larger.set(this.values);
      this.values = larger;
    }
    this.values[this.length++] = value;
  }
  at(i: number): number {
    return this.values[i]!;
  }
  /** Removes the first `count` numbers. */
  shift(count: number): void {
    this.values.copyWithin(0, count, this.length);
    this.length -= count;
  }
}

/** Tests the rows of one store; names that appear later are added on demand. */
export class Matcher {
  private readonly search_text: readonly string[];
  private is_agent = new Uint8Array(0);
  private is_between = new Uint8Array(0);
  private kinds_ok = new Uint8Array(0);
  /** per word and name or kind: whether it contains the word */
  private agents_match: Uint8Array[] = [];
  private kinds_match: Uint8Array[] = [];

  constructor(
    private readonly store: TraceStore,
    private readonly filter: Filter,
  ) {
    this.search_text = filter.text.toLowerCase().split(/\s+/).filter((word) => word !== '');
  }

  /** Calls `found` with the sequence number of each matching row of a chunk, in order. Notes always match, as they indicate gaps. */
  scan(chunk: Chunk, base: number, begin: number, end: number, found: (seq: number) => void): void {
    this.learn_names();
    const { agent, between } = this.filter;
    const lower = this.search_text.length > 0 ? chunk.lower() : null;
    const next_hit = this.search_text.map(() => -1);
    for (let i = begin; i < end; i++) {
      const kind = chunk.kind[i]!;
      if (kind === note_kind) {
        found(base + i);
        continue;
      }
      const from = chunk.from[i]!;
      const to = chunk.to[i]!;
      if (!this.kinds_ok[kind]) continue;
      if (agent !== '' && !this.is_agent[from] && !this.is_agent[to]) continue;
      if (between && !(this.is_between[from] && this.is_between[to])) continue;
      if (lower && !this.matches(lower, i, from, to, kind, next_hit)) continue;
      found(base + i);
    }
  }

  private matches(lower: { text: string; ends: Uint32Array | readonly number[] }, i: number, from: number, to: number, kind: number, next_hit: number[]): boolean {
    const start = i === 0 ? 0 : lower.ends[i - 1]!;
    const end = lower.ends[i]!;
    for (let w = 0; w < this.search_text.length; w++) {
      if (this.agents_match[w]![from] || this.agents_match[w]![to] || this.kinds_match[w]![kind]) continue;
      const word = this.search_text[w]!;
      // The text of the chunk is searched once per word: a hit is stored until the rows reach it.
      if (next_hit[w]! < start) {
        const hit = lower.text.indexOf(word, start);
        next_hit[w] = hit < 0 ? Infinity : hit;
      }
      // A hit across the end of the row does not count, and the row has no hit before it.
      if (next_hit[w]! + word.length > end) return false;
    }
    return true;
  }

  private learn_names(): void {
    const { agents, kinds } = this.store;
    const of = (names: Names, matches: (name: string) => boolean) => Uint8Array.from({ length: names.size }, (_, id) => Number(matches(names.name(id))));
    const { agent, between, kinds_off } = this.filter;
    if (this.is_agent.length < agents.size) {
      this.is_agent = of(agents, (name) => name === agent);
      this.is_between = of(agents, (name) => between?.has(name) ?? true);
      this.agents_match = this.search_text.map((word) => of(agents, (name) => name.toLowerCase().includes(word)));
    }
    if (this.kinds_ok.length < kinds.size) {
      this.kinds_ok = of(kinds, (name) => !kinds_off.has(name));
      this.kinds_match = this.search_text.map((word) => of(kinds, (name) => name.toLowerCase().includes(word)));
    }
  }
}

/** The list of the rows that match a filter. */
export class MatchingRows implements RowList {
  private readonly matcher: Matcher;
  /** matches of the backward search, newest first */
  private readonly older = new NumberList();
  private readonly newer = new NumberList();
  /** number of rows at the front of `newer` that the store has dropped */
  private gone = 0;
  private searched_from: number;
  private searched_to: number;
  private readonly began_at: number;

  constructor(
    private readonly store: TraceStore,
    filter: Filter,
  ) {
    this.matcher = new Matcher(store, filter);
    this.searched_from = this.searched_to = this.began_at = store.end;
  }

  get length(): number {
    return this.older.length + this.newer.length - this.gone;
  }
  at(i: number): number {
    return i < this.older.length ? this.older.at(this.older.length - 1 - i) : this.newer.at(i - this.older.length + this.gone);
  }
  index_of(seq: number): number {
    let low = 0;
    let high = this.length;
    while (low < high) {
      const half = (low + high) >>> 1;
      if (this.at(half) < seq) low = half + 1;
      else high = half;
    }
    return low;
  }
  /** The searched part of the store, 0…1. */
  get progress(): number {
    const all = this.began_at - this.store.first;
    return all <= 0 ? 1 : Math.min(1, (this.began_at - Math.max(this.searched_from, this.store.first)) / all);
  }
  get complete(): boolean {
    return this.searched_from <= this.store.first && this.searched_to === this.store.end;
  }

  /** Continues the search while `has_time` returns true, for at least one chunk. True if the list changed. */
  search(has_time: () => boolean): boolean {
    const before = this.length;
    const first_before = before > 0 ? this.at(0) : -1;
    this.forget();
    while (this.searched_to < this.store.end) {
      const begin = this.searched_to % chunk_rows;
      const base = this.searched_to - begin;
      const end = Math.min(chunk_rows, this.store.end - base);
      this.matcher.scan(this.store.chunk_at(base), base, begin, end, (seq) => this.newer.push(seq));
      this.searched_to = base + end;
      if (!has_time()) break;
    }
    const found: number[] = [];
    while (this.searched_from > this.store.first) {
      const last = this.searched_from - 1;
      const base = last - (last % chunk_rows);
      found.length = 0;
      this.matcher.scan(this.store.chunk_at(base), base, 0, last - base + 1, (seq) => found.push(seq));
      for (let i = found.length - 1; i >= 0; i--) this.older.push(found[i]!);
      this.searched_from = base;
      if (!has_time()) break;
    }
    return this.length !== before || (this.length > 0 && this.at(0) !== first_before);
  }

  /** Removes the rows that the store has dropped. */
  private forget(): void {
    const first = this.store.first;
    while (this.older.length > 0 && this.older.at(this.older.length - 1) < first) this.older.length--;
    if (this.older.length > 0) return;
    while (this.gone < this.newer.length && this.newer.at(this.gone) < first) this.gone++;
    if (this.gone > 100_000) {
      this.newer.shift(this.gone);
      this.gone = 0;
    }
  }
}
