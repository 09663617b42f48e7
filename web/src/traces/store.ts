// A million communications in compact form: numbers in typed arrays, names as small ids, contents joined per chunk. The
// sequence number `seq` identifies a row. It counts from the first row ever stored, so that dropping old rows does not change
// it.
import type { Trace } from '../live/contract';

export const chunk_rows = 4096;
export const rows_max = 1_000_000;
/** The kind of a note: a row that is no message but reports a gap or a restart of the server. */
export const note_kind = 0;

/** The server's name for the proxy of a remote agent (A26). */
export const proxy_of = (agent: string): string => `proxy of ${agent}`;

/** Maps names to 16-bit ids; 0 means no name. When the ids are used up, further names read "…". */
export class Names {
  private readonly ids = new Map<string, number>([['', 0]]);
  private readonly names: string[] = [''];
  /** number of stored rows per name */
  private readonly uses: number[] = [0];

  constructor(private readonly count_max = 65_535) {}

  id(name: string): number {
    const known = this.ids.get(name);
    if (known !== undefined) return known;
    if (this.names.length >= this.count_max) return this.ids.get('…') ?? this.add('…');
    return this.add(name);
  }
  find(name: string): number | undefined {
    return this.ids.get(name);
  }
  name(id: number): string {
    return this.names[id] ?? '';
  }
  get size(): number {
    return this.names.length;
  }
  use(id: number, by: 1 | -1): void {
    this.uses[id] = this.uses[id]! + by;
  }
  /** The names in stored rows, with the number of rows of each. */
  counted(): { name: string; rows: number }[] {
    const all: { name: string; rows: number }[] = [];
    for (let id = 1; id < this.names.length; id++) if (this.uses[id]! > 0) all.push({ name: this.names[id]!, rows: this.uses[id]! });
    return all;
  }
  private add(name: string): number {
    const id = this.names.length;
    this.ids.set(name, id);
    this.names.push(name);
    this.uses.push(0);
    return id;
  }
}

export class Chunk {
  readonly n = new Float64Array(chunk_rows);
  readonly time_ms = new Float64Array(chunk_rows);
  readonly from = new Uint16Array(chunk_rows);
  readonly to = new Uint16Array(chunk_rows);
  readonly kind = new Uint16Array(chunk_rows);
  /** which agent's proxy the message passed through: 0 none, 1 the sender's, 2 the receiver's */
  readonly via = new Uint8Array(chunk_rows);
  used = 0;
  /** contents of a chunk that is being filled; later replaced by `text` and `ends` */
  private open: string[] | null = [];
  private text = '';
  private ends: Uint32Array | null = null;

  push(content: string): void {
    this.open!.push(content);
    if (++this.used < chunk_rows) return;
    this.ends = new Uint32Array(chunk_rows);
    let end = 0;
    this.open!.forEach((one, i) => (this.ends![i] = end += one.length));
    this.text = this.open!.join('');
    this.open = null;
  }
  content(i: number): string {
    if (this.open) return this.open[i]!;
    return this.text.slice(i === 0 ? 0 : this.ends![i - 1]!, this.ends![i]!);
  }
  /** All contents in lower case, concatenated, and the end of each. */
  lower(): { text: string; ends: Uint32Array | readonly number[] } {
    if (this.ends) {
      const text = this.text.toLowerCase();
      // A few letters become longer in lower case ("İ"), which changes the ends.
      if (text.length === this.text.length) return { text, ends: this.ends };
    }
    const ends: number[] = [];
    let text = '';
    for (let i = 0; i < this.used; i++) {
      text += this.content(i).toLowerCase();
      ends.push(text.length);
    }
    return { text, ends };
  }
  /** Memory of the numbers and of joined contents [bytes]. */
  get bytes(): number {
    const columns = chunk_rows * (8 + 8 + 2 + 2 + 2 + 1);
    return columns + (this.ends ? this.ends.byteLength + this.text.length : this.open!.reduce((sum, one) => sum + one.length + 24, 0));
  }
}

export class TraceStore {
  readonly agents = new Names();
  readonly kinds = new Names();
  /** the agents whose proxies are in a trace */
  readonly proxied = new Set<string>();
  private readonly chunks: (Chunk | undefined)[] = [];
  private first_chunk = 0;
  /** one past the sequence number of the last row */
  end = 0;

  constructor(private readonly max = rows_max) {}

  /** sequence number of the oldest row */
  get first(): number {
    return this.first_chunk * chunk_rows;
  }
  get length(): number {
    return this.end - this.first;
  }

  append(trace: Trace): number {
    return this.row(trace.n, trace.time_ms, this.agents.id(trace.from), this.agents.id(trace.to), this.kinds.id(trace.kind), trace.content, trace.via === undefined ? 0 : trace.via === proxy_of(trace.from) ? 1 : 2);
  }
  /** Appends a note about the adjacent rows. */
  note(text: string, time_ms: number): number {
    return this.row(0, time_ms, 0, 0, note_kind, text);
  }

  holds(seq: number): boolean {
    return seq >= this.first && seq < this.end;
  }
  chunk_at(seq: number): Chunk {
    return this.chunks[Math.floor(seq / chunk_rows)]!;
  }
  n(seq: number): number {
    return this.chunk_at(seq).n[seq % chunk_rows]!;
  }
  time_ms(seq: number): number {
    return this.chunk_at(seq).time_ms[seq % chunk_rows]!;
  }
  from(seq: number): string {
    return this.agents.name(this.chunk_at(seq).from[seq % chunk_rows]!);
  }
  to(seq: number): string {
    return this.agents.name(this.chunk_at(seq).to[seq % chunk_rows]!);
  }
  kind(seq: number): string {
    return this.kinds.name(this.chunk_at(seq).kind[seq % chunk_rows]!);
  }
  via(seq: number): string | undefined {
    const side = this.chunk_at(seq).via[seq % chunk_rows]!;
    return side === 0 ? undefined : proxy_of(side === 1 ? this.from(seq) : this.to(seq));
  }
  content(seq: number): string {
    return this.chunk_at(seq).content(seq % chunk_rows);
  }
  is_note(seq: number): boolean {
    return this.chunk_at(seq).kind[seq % chunk_rows] === note_kind;
  }
  trace(seq: number): Trace {
    const via = this.via(seq);
    return { n: this.n(seq), time_ms: this.time_ms(seq), from: this.from(seq), to: this.to(seq), ...(via && { via }), kind: this.kind(seq), content: this.content(seq) };
  }

  /** The newest row before `before` with this kind and, if given, this sender and receiver; -1 if there is none. */
  find_last(wanted: { kind: string; from?: string; to?: string }, before = this.end): number {
    const kind = this.kinds.find(wanted.kind);
    const from = wanted.from === undefined ? -1 : this.agents.find(wanted.from);
    const to = wanted.to === undefined ? -1 : this.agents.find(wanted.to);
    if (kind === undefined || from === undefined || to === undefined) return -1;
    for (let seq = before - 1; seq >= this.first; seq--) {
      const chunk = this.chunk_at(seq);
      const i = seq % chunk_rows;
      if (chunk.kind[i] === kind && (from < 0 || chunk.from[i] === from) && (to < 0 || chunk.to[i] === to)) return seq;
    }
    return -1;
  }

  get bytes(): number {
    let sum = 0;
    for (let i = this.first_chunk; i < this.chunks.length; i++) sum += this.chunks[i]!.bytes;
    return sum;
  }

  private row(n: number, time_ms: number, from: number, to: number, kind: number, content: string, via = 0): number {
    const seq = this.end++;
    const i = seq % chunk_rows;
    if (i === 0) this.chunks.push(new Chunk());
    const chunk = this.chunk_at(seq);
    chunk.n[i] = n;
    chunk.time_ms[i] = time_ms;
    chunk.from[i] = from;
    chunk.to[i] = to;
    chunk.kind[i] = kind;
    chunk.via[i] = via;
    if (via > 0) this.proxied.add(this.agents.name(via === 1 ? from : to));
    chunk.push(content);
    this.agents.use(from, 1);
    this.agents.use(to, 1);
    this.kinds.use(kind, 1);
    if (this.length >= this.max + chunk_rows) this.forget_oldest();
    return seq;
  }

  private forget_oldest(): void {
    const chunk = this.chunks[this.first_chunk]!;
    for (let i = 0; i < chunk_rows; i++) {
      this.agents.use(chunk.from[i]!, -1);
      this.agents.use(chunk.to[i]!, -1);
      this.kinds.use(chunk.kind[i]!, -1);
    }
    this.chunks[this.first_chunk++] = undefined;
  }
}
