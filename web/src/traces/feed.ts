// Fetches the server's communications by their running numbers. Each request repeats the last known number: if the response
// does not begin with the same message, the server has restarted and numbers from 1 again.
import type { ApiResponse } from '../live/api';
import type { Traces } from '../live/contract';
import type { TraceStore } from './store';

const limit = 1000;
/** Greatest number of consecutive requests before the page may paint. */
const rounds_max = 25;

export type RequestTraces = (after: number, limit: number) => Promise<ApiResponse<Traces>>;

export class TraceFeed {
  /** number of the next message */
  private next = 0;
  private last_time_ms = 0;
  private busy = false;
  /** error message, if the server does not respond */
  trouble: string | null = null;
  /** whether the server has more messages */
  behind = false;

  constructor(
    private readonly store: TraceStore,
    private readonly request: RequestTraces,
  ) {}

  /** Fetches new messages; true if rows were added. A call during a pending one does nothing. */
  async poll(): Promise<boolean> {
    if (this.busy) return false;
    this.busy = true;
    const before = this.store.end;
    try {
      for (let round = 0; round < rounds_max; round++) {
        const response = await this.request(Math.max(0, this.next - 1), limit);
        if (!response.ok) {
          this.trouble = response.sentence;
          break;
        }
        this.trouble = null;
        this.behind = this.accept(response.value);
        if (!this.behind) break;
      }
    } finally {
      this.busy = false;
    }
    return this.store.end > before;
  }

  /** Stores a response; true if more messages can be fetched at once. */
  accept(response: Traces): boolean {
    const known = this.next > 0;
    const again = response.traces[0];
    const other_server = known && (response.next < this.next || (again?.n === this.next - 1 && again.time_ms !== this.last_time_ms));
    if (other_server) {
      this.store.note('The server was restarted; its messages are numbered from 1 again.', this.last_time_ms);
      this.next = 0;
      return true;
    }
    let expected = Math.max(1, this.next);
    for (const trace of response.traces) {
      if (trace.n < expected) continue;
      if (trace.n > expected) this.gap(trace.n - expected, known, trace.time_ms);
      this.store.append(trace);
      expected = trace.n + 1;
      this.last_time_ms = trace.time_ms;
    }
    // An empty response still carries the next number of the server.
    this.next = Math.max(expected, response.next);
    return response.traces.length >= limit;
  }

  private gap(count: number, known: boolean, time_ms: number): void {
    const messages = `${count.toLocaleString('en')} ${count === 1 ? 'message' : 'messages'}`;
    const was_or_were = count === 1 ? 'was' : 'were';
    this.store.note(known ? `${messages} ${was_or_were} lost: overwritten before this page read them.` : `${messages} before these ${was_or_were} no longer stored by the server.`, time_ms);
  }
}
