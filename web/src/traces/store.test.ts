import { describe, expect, it } from 'vitest';
import type { ApiResponse } from '../live/api';
import type { Trace, Traces } from '../live/contract';
import { TraceFeed } from './feed';
import { chunk_rows, Names, note_kind, TraceStore } from './store';

const trace = (n: number, more: Partial<Trace> = {}): Trace => ({ n, time_ms: 1000 + 10 * n, from: 'CoSiVA/AIV1', to: 'AIV_Server', kind: 'state', content: `message ${n}`, ...more });

describe('the store', () => {
  it('returns every row unchanged, across full chunks and the open one', () => {
    const store = new TraceStore();
    const count = 2 * chunk_rows + 17;
    for (let n = 1; n <= count; n++) store.append(trace(n, { content: n % 7 === 0 ? '' : `é ${n}`, kind: n % 2 ? 'state' : 'order' }));
    for (const seq of [0, 6, 7, chunk_rows - 1, chunk_rows, 2 * chunk_rows - 1, 2 * chunk_rows, count - 1]) {
      const n = seq + 1;
      expect(store.trace(seq)).toEqual(trace(n, { content: n % 7 === 0 ? '' : `é ${n}`, kind: n % 2 ? 'state' : 'order' }));
    }
  });

  it('drops the oldest rows beyond its bound, keeps at least the promised number, and keeps indices valid', () => {
    const store = new TraceStore(2 * chunk_rows);
    // The extremes are compared once: 82 000 calls of expect() took seconds on a busy machine.
    let least_spare = Infinity;
    let longest = 0;
    for (let n = 1; n <= 10 * chunk_rows + 5; n++) {
      store.append(trace(n));
      least_spare = Math.min(least_spare, store.length - Math.min(n, 2 * chunk_rows));
      longest = Math.max(longest, store.length);
    }
    expect(least_spare).toBeGreaterThanOrEqual(0);
    expect(longest).toBeLessThan(3 * chunk_rows);
    expect(store.first % chunk_rows).toBe(0);
    expect(store.n(store.first)).toBe(store.first + 1);
    expect(store.holds(store.first - 1)).toBe(false);
    expect(store.holds(store.end - 1)).toBe(true);
    expect(store.holds(store.end)).toBe(false);
  });

  it('counts the names of the stored rows, and discards unused ones', () => {
    const store = new TraceStore(chunk_rows);
    for (let n = 1; n <= chunk_rows; n++) store.append(trace(n, { from: 'CoSiVA/AIV9' }));
    for (let n = chunk_rows + 1; n <= 2 * chunk_rows; n++) store.append(trace(n));
    expect(store.agents.counted().map(({ name }) => name).sort()).toEqual(['AIV_Server', 'CoSiVA/AIV1']);
    expect(store.kinds.counted()).toEqual([{ name: 'state', rows: chunk_rows }]);
  });

  it('finds the newest row of a kind, a sender and a receiver, before an index', () => {
    const store = new TraceStore();
    store.append(trace(1, { kind: 'order', from: 'AIV_Server', to: 'CoSiVA/AIV1' }));
    store.append(trace(2, { kind: 'order', from: 'AIV_Server', to: 'CoSiVA/AIV2' }));
    store.append(trace(3));
    expect(store.find_last({ kind: 'order' })).toBe(1);
    expect(store.find_last({ kind: 'order', to: 'CoSiVA/AIV1' })).toBe(0);
    expect(store.find_last({ kind: 'order' }, 1)).toBe(0);
    expect(store.find_last({ kind: 'order', to: 'unknown' })).toBe(-1);
    expect(store.find_last({ kind: 'draw' })).toBe(-1);
  });

  it('counts names up to a bound and the others as "…"', () => {
    const names = new Names(3);
    expect([names.id('a'), names.id('b'), names.id('c'), names.id('d'), names.id('a')]).toEqual([1, 2, 3, 3, 1]);
    expect(names.name(3)).toBe('…');
  });

  it('holds a million rows in less than 120 bytes each', () => {
    const store = new TraceStore();
    for (let n = 1; n <= 1_000_000; n++) store.append(trace(n, { content: '{"x":-0.682,"y":1.346,"theta":-0.114,"speed":0.308}', from: `CoSiVA/AIV${n % 20}` }));
    expect(store.length).toBe(1_000_000);
    expect(store.bytes / store.length).toBeLessThan(120);
    expect(store.content(123_456)).toContain('"x":-0.682');
  });
});

/** Imitates the server's trace buffer: the last traces, numbered from 1. */
class Server {
  stored: Trace[] = [];
  next = 1;
  requested: number[] = [];
  constructor(
    private readonly capacity: number,
    private readonly began_ms = 0,
  ) {}
  send(count: number): void {
    for (let i = 0; i < count; i++) this.stored.push(trace(this.next, { time_ms: this.began_ms + 10 * this.next++ }));
    this.stored.splice(0, this.stored.length - this.capacity);
  }
  readonly request = (after: number, limit: number): Promise<ApiResponse<Traces>> => {
    this.requested.push(after);
    const oldest = this.next - this.stored.length;
    const begin = Math.max(oldest, Math.min(after, this.next));
    const traces = this.stored.slice(begin - oldest, begin - oldest + limit);
    return Promise.resolve({ ok: true, value: { next: begin + traces.length, oldest, traces } });
  };
}
const notes = (store: TraceStore) => Array.from({ length: store.length }, (_, i) => i).filter((seq) => store.is_note(seq)).map((seq) => store.content(seq));
const numbers = (store: TraceStore) => Array.from({ length: store.length }, (_, i) => store.n(i)).filter((n) => n > 0);

describe('the feed', () => {
  it('reads every message once, in order, and catches up in steps of a thousand', async () => {
    const server = new Server(20_000);
    const store = new TraceStore();
    const feed = new TraceFeed(store, server.request);
    server.send(3_456);
    expect(await feed.poll()).toBe(true);
    expect(await feed.poll()).toBe(false);
    server.send(5);
    await feed.poll();
    expect(numbers(store)).toEqual(Array.from({ length: 3_461 }, (_, i) => i + 1));
    expect(notes(store)).toEqual([]);
  });

  it('reports how many messages were overwritten before they were read', async () => {
    const server = new Server(50);
    const store = new TraceStore();
    const feed = new TraceFeed(store, server.request);
    server.send(60);
    await feed.poll();
    server.send(177);
    await feed.poll();
    expect(notes(store)).toEqual(['10 messages before these were no longer stored by the server.', '127 messages were lost: overwritten before this page read them.']);
    expect(numbers(store).at(-1)).toBe(237);
  });

  it('uses the singular for one', async () => {
    const server = new Server(4);
    const store = new TraceStore();
    const feed = new TraceFeed(store, server.request);
    server.send(4);
    await feed.poll();
    server.send(5);
    await feed.poll();
    expect(notes(store)).toEqual(['1 message was lost: overwritten before this page read them.']);
  });

  it.each([
    ['has sent less than the old one', 3],
    ['has sent as much as the old one', 40],
    ['has sent more than the old one', 90],
  ])('starts a new block when another server responds that %s', async (_, sent) => {
    const store = new TraceStore();
    let server = new Server(20_000);
    const feed = new TraceFeed(store, (after, limit) => server.request(after, limit));
    server.send(40);
    await feed.poll();
    server = new Server(20_000, 1e6);
    server.send(sent);
    await feed.poll();
    await feed.poll();
    expect(notes(store)).toEqual(['The server was restarted; its messages are numbered from 1 again.']);
    expect(numbers(store)).toEqual([...Array.from({ length: 40 }, (_x, i) => i + 1), ...Array.from({ length: sent }, (_x, i) => i + 1)]);
  });

  it('reports why no messages arrive while the server is away, and resumes', async () => {
    const server = new Server(20_000);
    const store = new TraceStore();
    let away = true;
    const feed = new TraceFeed(store, (after, limit) => (away ? Promise.resolve({ ok: false, status: 0, sentence: 'The server does not respond.' }) : server.request(after, limit)));
    server.send(3);
    expect(await feed.poll()).toBe(false);
    expect(feed.trouble).toBe('The server does not respond.');
    away = false;
    await feed.poll();
    expect(feed.trouble).toBeNull();
    expect(numbers(store)).toEqual([1, 2, 3]);
  });

  it('waits for the pending response instead of requesting twice', async () => {
    const server = new Server(100);
    const store = new TraceStore();
    const feed = new TraceFeed(store, server.request);
    server.send(2);
    await Promise.all([feed.poll(), feed.poll()]);
    expect(numbers(store)).toEqual([1, 2]);
    expect(note_kind).toBe(0);
  });
});
