// Reads the server's communications as they come, by their running numbers. Each question repeats the last number that is
// known: if the answer does not begin with that very message, the server has started anew, and counts from 1 again.
import type { Answer } from '../api';
import type { Traces } from '../contract';
import type { TraceStore } from './store';

const limit = 1000;
/** So many questions in a row at most, then the page has its turn. */
const rounds_max = 25;

export type Ask = (after: number, limit: number) => Promise<Answer<Traces>>;

export class TraceFeed {
  /** the number of the message to come */
  private next = 0;
  private last_time_ms = 0;
  private busy = false;
  /** why nothing comes, as a sentence */
  trouble: string | null = null;
  /** is there more to fetch than was fetched? */
  behind = false;

  constructor(
    private readonly store: TraceStore,
    private readonly ask: Ask,
  ) {}

  /** Fetches what is new; true when rows were added. One call at a time: a second one while the first waits does nothing. */
  async poll(): Promise<boolean> {
    if (this.busy) return false;
    this.busy = true;
    const before = this.store.end;
    try {
      for (let round = 0; round < rounds_max; round++) {
        const answer = await this.ask(Math.max(0, this.next - 1), limit);
        if (!answer.ok) {
          this.trouble = answer.sentence;
          break;
        }
        this.trouble = null;
        this.behind = this.accept(answer.value);
        if (!this.behind) break;
      }
    } finally {
      this.busy = false;
    }
    return this.store.end > before;
  }

  /** Takes an answer; true when there is more to ask for at once. */
  accept(answer: Traces): boolean {
    const known = this.next > 0;
    const again = answer.traces[0];
    const other_server = known && (answer.next < this.next || (again?.n === this.next - 1 && again.time_ms !== this.last_time_ms));
    if (other_server) {
      this.store.note('The server started anew; its messages are numbered from 1 again.', this.last_time_ms);
      this.next = 0;
      return true;
    }
    let expected = Math.max(1, this.next);
    for (const trace of answer.traces) {
      if (trace.n < expected) continue;
      if (trace.n > expected) this.gap(trace.n - expected, known, trace.time_ms);
      this.store.append(trace);
      expected = trace.n + 1;
      this.last_time_ms = trace.time_ms;
    }
    // An empty answer of a server that keeps nothing yet still says where its numbers stand.
    this.next = Math.max(expected, answer.next);
    return answer.traces.length >= limit;
  }

  private gap(count: number, known: boolean, time_ms: number): void {
    const messages = `${count.toLocaleString('en')} ${count === 1 ? 'message' : 'messages'}`;
    const verb = count === 1 ? 'was' : 'were';
    this.store.note(known ? `${messages} ${verb} not kept: overwritten before this page read them.` : `${messages} before these ${verb} not kept by the server.`, time_ms);
  }
}
