// Receives the live stream off the main thread: reconnects the WebSocket, decodes frames, and keeps only the newest message
// of each type. The main thread acknowledges a message before it gets the next one, so that no queue builds up.
import { parse_live, type Aiv, type LiveMessage, type Snapshot } from './contract';
import { FrameDecoder, type PositionFrame } from './frames';

/** Events for the main thread. */
export type StreamEvent =
  | { kind: 'opened' }
  | { kind: 'closed' }
  | { kind: 'message'; message: LiveMessage }
  /** a part of a large snapshot, so that no painted frame is delayed by the whole */
  | { kind: 'part'; aivs: readonly Aiv[]; last: Snapshot | null }
  | { kind: 'positions'; frame: PositionFrame };

/** The acknowledgement of the main thread, once per event except opened and closed. */
export type StreamReply = { kind: 'taken'; what: 'text' } | { kind: 'taken'; what: 'positions'; room: ArrayBuffer };

export interface SocketLike {
  binaryType: BinaryType;
  onopen: ((event: Event) => unknown) | null;
  onmessage: ((event: MessageEvent) => unknown) | null;
  onclose: ((event: CloseEvent) => unknown) | null;
  close(): void;
}

const retry_ms_min = 250;
const retry_ms_max = 2_000;
/** A connection attempt without a response is abandoned after this time and repeated [ms]. */
const open_ms_max = 4_000;
/** The server sends four times a second; a connection without a frame for this time is closed and reopened [ms]. */
const silence_ms_max = 6_000;
export const part_size = 250;

const types = ['zone', 'run', 'snapshot', 'ground_truth'] as const;
type Type = (typeof types)[number];

export class Stream {
  private socket: SocketLike | null = null;
  private retry_ms = retry_ms_min;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private silence: ReturnType<typeof setTimeout> | undefined;
  private ended = false;
  private readonly decoder = new FrameDecoder();
  private readonly texts = new Map<Type, string>();
  private parts: { snapshot: Snapshot; from: number } | null = null;
  private text_out = false;
  private positions_out = false;
  private readonly rooms: ArrayBuffer[] = [];

  constructor(
    private readonly url: string,
    private readonly emit: (event: StreamEvent) => void,
    private readonly open_socket: (url: string) => SocketLike = (address) => new WebSocket(address),
  ) {
    this.connect();
  }

  close(): void {
    this.ended = true;
    clearTimeout(this.timer);
    clearTimeout(this.silence);
    this.socket?.close();
  }

  taken(reply: StreamReply): void {
    if (reply.what === 'positions') {
      this.positions_out = false;
      if (this.rooms.length < 2) this.rooms.push(reply.room);
      this.give_positions();
    } else {
      this.text_out = false;
      this.give_text();
    }
  }

  private connect(): void {
    const socket = this.open_socket(this.url);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.timer = setTimeout(() => this.drop(socket), open_ms_max);
    socket.onopen = () => {
      clearTimeout(this.timer);
      this.received(socket);
      this.decoder.reset();
      this.emit({ kind: 'opened' });
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      this.received(socket);
      this.retry_ms = retry_ms_min;
      if (event.data instanceof ArrayBuffer) {
        if (this.decoder.take(event.data)) this.give_positions();
      } else if (typeof event.data === 'string') {
        const type = type_of(event.data);
        if (type === null) return;
        this.texts.set(type, event.data);
        this.give_text();
      }
    };
    socket.onclose = () => this.lost(socket);
  }

  private lost(socket: SocketLike): void {
    if (this.ended || this.socket !== socket) return;
    this.socket = null;
    clearTimeout(this.timer);
    clearTimeout(this.silence);
    this.texts.clear();
    this.parts = null;
    this.emit({ kind: 'closed' });
    this.timer = setTimeout(() => this.connect(), this.retry_ms);
    this.retry_ms = Math.min(2 * this.retry_ms, retry_ms_max);
  }

  /** Drops the socket without waiting for its close event, which a dead connection delays for long. */
  private drop(socket: SocketLike): void {
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this.lost(socket);
  }

  private received(socket: SocketLike): void {
    clearTimeout(this.silence);
    this.silence = setTimeout(() => this.drop(socket), silence_ms_max);
  }

  private give_positions(): void {
    if (this.positions_out || !this.decoder.ready) return;
    const frame = this.decoder.write(this.rooms.pop());
    if (!frame) return;
    this.positions_out = true;
    this.emit({ kind: 'positions', frame });
  }

  private give_text(): void {
    if (this.text_out) return;
    const event = this.next_part() ?? this.next_message();
    if (!event) return;
    this.text_out = true;
    this.emit(event);
  }

  private next_message(): StreamEvent | null {
    for (const type of types) {
      const text = this.texts.get(type);
      if (text === undefined) continue;
      this.texts.delete(type);
      const message = parse_live(text);
      if (!message) continue;
      if (message.type !== 'snapshot' || message.snapshot.aivs.length <= part_size) return { kind: 'message', message };
      this.parts = { snapshot: message.snapshot, from: 0 };
      return this.next_part();
    }
    return null;
  }

  private next_part(): StreamEvent | null {
    if (!this.parts) return null;
    const { snapshot, from } = this.parts;
    const aivs = snapshot.aivs.slice(from, from + part_size);
    this.parts.from += part_size;
    const done = this.parts.from >= snapshot.aivs.length;
    if (done) this.parts = null;
    return { kind: 'part', aivs, last: done ? { ...snapshot, aivs: [] } : null };
  }
}

/** The type of a text frame, found without parsing all of it. */
export function type_of(text: string): Type | null {
  const name = /^\s*\{\s*"type"\s*:\s*"([a-z]+)"/.exec(text)?.[1] ?? parse_live(text)?.type;
  return types.find((type) => type === name) ?? null;
}
