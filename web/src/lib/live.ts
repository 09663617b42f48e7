// The live stream: one WebSocket that comes back by itself.
import { parse_live, type LiveMessage } from './contract';

export interface LiveListener {
  opened(): void;
  message(message: LiveMessage): void;
  closed(): void;
}

const retry_ms_min = 250;
const retry_ms_max = 2_000;
/** A connection attempt that hangs (a host that swallows packets) is given up and tried again. */
const open_ms_max = 4_000;

export class Live {
  private socket: WebSocket | null = null;
  private retry_ms = retry_ms_min;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private ended = false;

  constructor(
    private readonly url: string,
    private readonly listener: LiveListener,
  ) {
    this.connect();
  }

  close(): void {
    this.ended = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  private connect(): void {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    this.timer = setTimeout(() => socket.close(), open_ms_max);
    socket.onopen = () => {
      clearTimeout(this.timer);
      this.listener.opened();
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      const message = typeof event.data === 'string' ? parse_live(event.data) : null;
      if (!message) return;
      this.retry_ms = retry_ms_min;
      this.listener.message(message);
    };
    socket.onclose = () => {
      clearTimeout(this.timer);
      if (this.ended) return;
      this.listener.closed();
      this.timer = setTimeout(() => this.connect(), this.retry_ms);
      this.retry_ms = Math.min(2 * this.retry_ms, retry_ms_max);
    };
  }
}

export function live_url(location: { protocol: string; host: string }): string {
  return `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/api/v1/live`;
}
