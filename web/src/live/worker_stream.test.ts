import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { sample_frame } from './frames_sample';
import { part_size, Stream, type_of, type SocketLike, type StreamEvent } from './worker_stream';

class FakeSocket implements SocketLike {
  binaryType: BinaryType = 'blob';
  onopen: ((event: Event) => unknown) | null = null;
  onmessage: ((event: MessageEvent) => unknown) | null = null;
  onclose: ((event: CloseEvent) => unknown) | null = null;
  closed = false;
  open(): void {
    this.onopen?.({} as Event);
  }
  text(value: unknown): void {
    this.onmessage?.({ data: typeof value === 'string' ? value : JSON.stringify(value) } as MessageEvent);
  }
  bytes(data: ArrayBuffer): void {
    this.onmessage?.({ data } as MessageEvent);
  }
  close(): void {
    this.closed = true;
    this.onclose?.({} as CloseEvent);
  }
}

function bench() {
  const sockets: FakeSocket[] = [];
  const events: StreamEvent[] = [];
  const stream = new Stream('ws://here', (event) => events.push(event), () => {
    const socket = new FakeSocket();
    sockets.push(socket);
    return socket;
  });
  return { sockets, events, stream, kinds: () => events.map((event) => (event.kind === 'message' ? event.message.type : event.kind)) };
}
const snapshot = (time_ms: number, aivs = 1) => ({ type: 'snapshot', snapshot: { time_ms, aivs: Array.from({ length: aivs }, (_, i) => ({ id: `A${i}` })), virtualObjects: [] } });
const key = (sequence: number, x: number) => sample_frame(true, sequence, sequence, sequence, [{ handle: 1, x, y: 0 }]);

describe('the stream', () => {
  beforeEach(() => {
    vi.useFakeTimers();
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  it('delivers one text at a time, and of those received meanwhile the newest of each type', () => {
    const { sockets, events, stream, kinds } = bench();
    sockets[0]!.open();
    sockets[0]!.text({ type: 'zone', zone: null });
    for (const time_ms of [1, 2, 3]) sockets[0]!.text(snapshot(time_ms));
    sockets[0]!.text({ type: 'run', run: {} });
    expect(kinds()).toEqual(['opened', 'zone']);
    for (let i = 0; i < 4; i++) stream.taken({ kind: 'taken', what: 'text' });
    expect(kinds()).toEqual(['opened', 'zone', 'run', 'snapshot']);
    const last = events[3]!;
    expect(last.kind === 'message' && last.message.type === 'snapshot' && last.message.snapshot.time_ms).toBe(3);
  });

  it('delivers one frame at a time, then the newest, in reused memory', () => {
    const { sockets, events, stream } = bench();
    sockets[0]!.open();
    for (const x of [1, 2, 3]) sockets[0]!.bytes(key(x, x));
    const first = events[1]!;
    if (first.kind !== 'positions') throw new Error('expected positions');
    expect(first.frame.values[0]).toBe(1);
    stream.taken({ kind: 'taken', what: 'positions', room: first.frame.buffer });
    const second = events[2]!;
    if (second.kind !== 'positions') throw new Error('expected positions');
    expect(second.frame.values[0]).toBe(3);
    expect(second.frame.buffer).toBe(first.frame.buffer);
    expect(events).toHaveLength(3);
  });

  it('splits a large snapshot into parts', () => {
    const { sockets, events, stream, kinds } = bench();
    sockets[0]!.open();
    sockets[0]!.text(snapshot(7, 2 * part_size + 5));
    for (let i = 0; i < 5; i++) stream.taken({ kind: 'taken', what: 'text' });
    expect(kinds()).toEqual(['opened', 'part', 'part', 'part']);
    const parts = events.slice(1).map((event) => (event.kind === 'part' ? [event.aivs.length, event.last?.time_ms ?? null] : []));
    expect(parts).toEqual([[part_size, null], [part_size, null], [5, 7]]);
  });

  it('ignores unknown messages', () => {
    const { sockets, kinds } = bench();
    sockets[0]!.open();
    sockets[0]!.text('not JSON');
    sockets[0]!.text({ type: 'weather' });
    sockets[0]!.bytes(new ArrayBuffer(5));
    expect(kinds()).toEqual(['opened']);
    expect(type_of('{"type":"run","run":{}}')).toBe('run');
    expect(type_of('{"run":{},"type":"run"}')).toBe('run');
    expect(type_of('[]')).toBeNull();
  });

  it('reconnects with increasing delays, and requires a new key frame', () => {
    const { sockets, events, kinds } = bench();
    sockets[0]!.open();
    sockets[0]!.bytes(key(1, 1));
    sockets[0]!.close();
    expect(kinds()).toEqual(['opened', 'positions', 'closed']);
    vi.advanceTimersByTime(249);
    expect(sockets).toHaveLength(1);
    vi.advanceTimersByTime(1);
    expect(sockets).toHaveLength(2);
    sockets[1]!.close();
    vi.advanceTimersByTime(499);
    expect(sockets).toHaveLength(2);
    vi.advanceTimersByTime(1);
    sockets[2]!.open();
    sockets[2]!.bytes(sample_frame(false, 2, 1, 2, [{ handle: 1, x: 5, y: 0 }]));
    expect(events.filter((event) => event.kind === 'positions')).toHaveLength(1);
  });

  it('abandons an attempt without a response, and a connection without messages', () => {
    const { sockets } = bench();
    vi.advanceTimersByTime(4_000);
    expect(sockets[0]!.closed).toBe(true);
    vi.advanceTimersByTime(300);
    sockets[1]!.open();
    sockets[1]!.text({ type: 'run', run: {} });
    vi.advanceTimersByTime(5_900);
    expect(sockets[1]!.closed).toBe(false);
    vi.advanceTimersByTime(200);
    expect(sockets[1]!.closed).toBe(true);
  });

  it('stays closed after close', () => {
    const { sockets, stream, kinds } = bench();
    sockets[0]!.open();
    stream.close();
    vi.advanceTimersByTime(60_000);
    expect(sockets).toHaveLength(1);
    expect(kinds()).toEqual(['opened']);
  });
});
