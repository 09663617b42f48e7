// The live stream for the main thread. A worker receives it; without worker support the main thread does.
import type { Aiv, LiveMessage } from './contract';
import { frame_over, type PositionFrame } from './frames';
import { Stream, type StreamEvent, type StreamReply } from './worker_stream';

export interface LiveListener {
  opened(): void;
  message(message: LiveMessage): void;
  /** the frame is valid during the call only, because its memory is reused */
  positions(frame: PositionFrame): void;
  closed(): void;
}

type FromWorker = Exclude<StreamEvent, { kind: 'positions' }> | { kind: 'positions'; buffer: ArrayBuffer; count: number; sequence: number; time_ms: number };

export class Live {
  private worker: Worker | null = null;
  private stream: Stream | null = null;
  private aivs: Aiv[] = [];

  constructor(
    private readonly url: string,
    private readonly listener: LiveListener,
  ) {
    this.worker = this.start_worker();
    if (!this.worker) this.start_here();
  }

  close(): void {
    this.worker?.terminate();
    this.stream?.close();
  }

  private start_worker(): Worker | null {
    let worker: Worker;
    try {
      worker = new Worker(new URL('./worker.ts', import.meta.url), { type: 'module' });
    } catch {
      return null;
    }
    worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      if (data.kind !== 'positions') return this.receive(data, (reply) => worker.postMessage(reply));
      const frame = frame_over(data.buffer, data.count, data.sequence, data.time_ms);
      this.receive({ kind: 'positions', frame }, (reply) => worker.postMessage(reply, [data.buffer]));
    };
    // A worker that cannot be loaded must not leave the page without its stream.
    worker.onerror = () => {
      if (this.worker !== worker) return;
      worker.terminate();
      this.worker = null;
      this.start_here();
    };
    worker.postMessage({ kind: 'open', url: this.url });
    return worker;
  }

  private start_here(): void {
    // The reply is deferred, so that the page can paint between two messages.
    this.stream = new Stream(this.url, (event) => this.receive(event, (reply) => setTimeout(() => this.stream?.taken(reply))));
  }

  private receive(event: StreamEvent, respond: (reply: StreamReply) => void): void {
    switch (event.kind) {
      case 'opened':
        this.aivs = [];
        return this.listener.opened();
      case 'closed':
        return this.listener.closed();
      case 'positions':
        this.listener.positions(event.frame);
        return respond({ kind: 'taken', what: 'positions', room: event.frame.buffer });
      case 'part':
        this.aivs.push(...event.aivs);
        if (event.last) {
          const { aivs } = this;
          this.aivs = [];
          this.listener.message({ type: 'snapshot', snapshot: { ...event.last, aivs } });
        }
        return respond({ kind: 'taken', what: 'text' });
      case 'message':
        this.listener.message(event.message);
        return respond({ kind: 'taken', what: 'text' });
    }
  }
}

export function live_url(location: { protocol: string; host: string }): string {
  return `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/api/v1/live`;
}
