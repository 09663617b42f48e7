// Readers of the live stream, like pages; and a client that never reads.
import { createRequire } from 'node:module';
import { connect } from 'node:net';
import { fileURLToPath } from 'node:url';

const { WebSocket } = createRequire(fileURLToPath(new URL('../../e2e/package.json', import.meta.url)))('ws');

export const now_ms = () => performance.timeOrigin + performance.now();

/** A page that reads everything and records when positions came, and how old they were. */
export class Reader {
  constructor(url) {
    this.intervals = [];
    this.latencies = [];
    this.frames = 0;
    this.bytes = 0;
    this.last = NaN;
    this.socket = new WebSocket(`${url.replace('http', 'ws')}/api/v1/live`, { perMessageDeflate: false });
    this.socket.on('message', (data, binary) => this.take(data, binary));
    this.opened = new Promise((resolve, reject) => {
      this.socket.on('open', resolve);
      this.socket.on('error', reject);
    });
  }

  take(data, binary) {
    this.bytes += data.length;
    if (!binary) return;
    const now = now_ms();
    ++this.frames;
    if (this.noting) {
      if (!Number.isNaN(this.last)) this.intervals.push(now - this.last);
      this.latencies.push(now - data.readDoubleLE(16));
    }
    this.last = now;
  }

  note(on) {
    this.noting = on;
    this.last = NaN;
    if (on) this.intervals.length = this.latencies.length = 0;
  }

  close() {
    this.socket.removeAllListeners('error');
    this.socket.on('error', () => {});
    this.socket.terminate();
  }
}

/**
 * A client that requests the stream and never reads a byte. The server drops it in the end; the client reconnects at
 * once.
 */
export class NeverReads {
  constructor(port) {
    this.port = port;
    this.connections = 0;
    this.open();
  }

  open() {
    if (this.ended) return;
    ++this.connections;
    this.socket = connect({ port: this.port, host: '127.0.0.1' });
    this.socket.pause();
    this.socket.on('connect', () => {
      this.socket.write(
        'GET /api/v1/live HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n' +
          'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n',
      );
    });
    this.socket.on('error', () => {});
    this.socket.on('close', () => setTimeout(() => this.open(), 100));
  }

  close() {
    this.ended = true;
    this.socket.destroy();
  }
}
