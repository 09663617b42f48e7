// Communications as text: times, one-line summaries, and exports as NDJSON or CSV.
import type { Trace } from '../live/contract';
import { is_object, type Json } from './json';
import type { RowList } from './filter';
import type { TraceStore } from './store';

/** Local time of day, e.g. 14:03:07.250. */
export function time_of_day(time_ms: number): string {
  const date = new Date(time_ms);
  const two = (value: number) => String(value).padStart(2, '0');
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${String(date.getMilliseconds()).padStart(3, '0')}`;
}

/** Summarises flat JSON as "x 0.41, y −0.15"; other content is unchanged. */
export function summary_of(content: string): string {
  if (!content.startsWith('{')) return content;
  let value: Json;
  try {
    value = JSON.parse(content) as Json;
  } catch {
    return content; // truncated by the server
  }
  if (!is_object(value) || Object.values(value).some((one) => typeof one === 'object' && one !== null)) return content;
  return Object.entries(value)
    .map(([key, one]) => `${key} ${typeof one === 'number' && !Number.isInteger(one) ? one.toFixed(3).replace('-', '−') : String(one).replace(/^-(?=\d)/, '−')}`)
    .join(', ');
}

export function ndjson_line(trace: Trace): string {
  return `${JSON.stringify({ n: trace.n, time: iso(trace.time_ms), time_ms: trace.time_ms, from: trace.from, to: trace.to, via: trace.via, kind: trace.kind, content: trace.content })}\n`;
}

export const csv_head = 'n,time,from,to,via,kind,content\r\n';
export function csv_line(trace: Trace): string {
  return `${[trace.n, iso(trace.time_ms), trace.from, trace.to, trace.via ?? '', trace.kind, trace.content].map(cell).join(',')}\r\n`;
}
/** A CSV line (RFC 4180); text that a spreadsheet would evaluate as a formula is escaped. */
function cell(value: string | number): string {
  const text = typeof value === 'string' && /^[=+@\t\r-]/.test(value) ? `'${value}` : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
/** An invalid time must not abort an export. */
function iso(time_ms: number): string {
  const date = new Date(time_ms);
  return Number.isNaN(date.getTime()) ? String(time_ms) : date.toISOString();
}

export type FileKind = 'ndjson' | 'csv';

/** Exports rows in slices: call `go_on` until it returns true. Notes are omitted and counted. */
export class Export {
  private readonly parts: string[] = [];
  private seq: number;
  private readonly end: number;
  private readonly begin: number;
  rows = 0;
  notes = 0;

  constructor(
    private readonly store: TraceStore,
    private readonly list: RowList,
    private readonly kind: FileKind,
  ) {
    // Sequence numbers, because indices shift when old rows are dropped.
    this.begin = this.seq = list.length > 0 ? list.at(0) : 0;
    this.end = list.length > 0 ? list.at(list.length - 1) + 1 : 0;
    if (kind === 'csv') this.parts.push(csv_head);
  }

  get progress(): number {
    return this.end === this.begin ? 1 : (this.seq - this.begin) / (this.end - this.begin);
  }

  /** Continues while `has_time` returns true; true when all rows are written. */
  go_on(has_time: () => boolean): boolean {
    const line_of = this.kind === 'csv' ? csv_line : ndjson_line;
    let i = this.list.index_of(this.seq);
    let slice = '';
    let done = false;
    for (;;) {
      if (i >= this.list.length || this.list.at(i) >= this.end) {
        done = true;
        break;
      }
      const seq = this.list.at(i++);
      if (this.store.is_note(seq)) this.notes++;
      else {
        slice += line_of(this.store.trace(seq));
        this.rows++;
      }
      this.seq = seq + 1;
      if (this.rows % 256 === 0 && !has_time()) break;
    }
    if (slice !== '') this.parts.push(slice);
    if (done) this.seq = this.end;
    return done;
  }

  blob(): Blob {
    return new Blob(this.parts, { type: this.kind === 'csv' ? 'text/csv;charset=utf-8' : 'application/x-ndjson' });
  }
}
