// A TCP proxy in front of the broker that delays, stalls, cuts and half-opens connections. The client identifier in a
// connection's first packet (MQTT 3.1.1, 3.1) tells which part of the platform it belongs to.
import { connect, createServer } from 'node:net';

/** The client identifier of a CONNECT packet, or null while the bytes do not contain it. */
export function client_of(bytes) {
  let at = 1;
  while (at < bytes.length && bytes[at] & 0x80) ++at; // the remaining length: seven bits per byte
  ++at;
  if (bytes.length < at + 2) return null;
  at += 2 + bytes.readUInt16BE(at); // protocol name
  at += 4; // level, flags, keep alive
  if (bytes.length < at + 2) return null;
  const length = bytes.readUInt16BE(at);
  return bytes.length < at + 2 + length ? null : bytes.toString('utf8', at + 2, at + 2 + length);
}

class Connection {
  constructor(proxy, client) {
    this.proxy = proxy;
    this.sockets = [client, connect(proxy.target_port, '127.0.0.1')];
    this.name = '';
    this.first = Buffer.alloc(0);
    this.waiting = [[], []]; // per direction: {due_ms, chunk}, or {due_ms, end}
    for (const [direction, socket] of this.sockets.entries()) {
      socket.setNoDelay(true);
      socket.on('data', (chunk) => this.received(direction, chunk));
      socket.on('error', () => {});
      socket.on('close', () => this.closed(direction));
    }
  }

  received(direction, chunk) {
    if (direction === 0 && this.name === '') {
      this.first = Buffer.concat([this.first, chunk]);
      this.name = client_of(this.first) ?? '';
    }
    const due_ms = Date.now() + this.proxy.delay_of(this);
    this.waiting[direction].push({ due_ms, chunk });
    this.forward(direction);
  }

  closed(direction) {
    this.sockets[direction].destroy();
    if (this.half_open) return; // the other side must not notice
    this.waiting[direction].push({ due_ms: Date.now() + this.proxy.delay_of(this), end: true });
    this.forward(direction);
  }

  /** Forwards what is due, in order. */
  forward(direction) {
    clearTimeout(this.timers?.[direction]);
    if (this.half_open || this.proxy.stalls(this)) return;
    const queue = this.waiting[direction];
    const to = this.sockets[1 - direction];
    while (queue.length > 0 && queue[0].due_ms <= Date.now()) {
      const { chunk, end } = queue.shift();
      if (end) return this.destroy();
      if (!to.destroyed) to.write(chunk);
    }
    if (queue.length === 0) return;
    this.timers ??= [null, null];
    this.timers[direction] = setTimeout(() => this.forward(direction), queue[0].due_ms - Date.now());
  }

  destroy() {
    for (const timer of this.timers ?? []) clearTimeout(timer);
    for (const socket of this.sockets) socket.destroy();
    this.proxy.connections.delete(this);
  }
}

export class LossyProxy {
  static async start(target_port, port = 0) {
    const proxy = new LossyProxy();
    Object.assign(proxy, { target_port, connections: new Set(), faults: new Set() });
    proxy.server = createServer((client) => {
      if ([...proxy.faults].some(({ mode }) => mode === 'refuse')) return client.destroy();
      proxy.connections.add(new Connection(proxy, client));
    });
    await new Promise((resolve, reject) => proxy.server.on('error', reject).listen(port, '127.0.0.1', resolve));
    proxy.port = proxy.server.address().port;
    return proxy;
  }

  /** Does the fault concern this connection? `client` is a name such as "aiv2", or "*". */
  static concerns(fault, connection) {
    return fault.client === '*' || connection.name.startsWith(`cosiva-${fault.client}`);
  }

  delay_of(connection) {
    return Math.max(0, ...[...this.faults].filter((fault) => fault.mode === 'delay' && LossyProxy.concerns(fault, connection)).map((fault) => fault.delay_ms));
  }

  stalls(connection) {
    return [...this.faults].some((fault) => fault.mode === 'stall' && LossyProxy.concerns(fault, connection));
  }

  /** Begins {mode: delay|stall|cut|half_open|refuse, client, delay_ms?}; returns the function that ends it. */
  begin(fault) {
    const concerned = [...this.connections].filter((connection) => LossyProxy.concerns(fault, connection));
    if (fault.mode === 'cut') for (const connection of concerned) connection.destroy();
    if (fault.mode === 'half_open') for (const connection of concerned) connection.half_open = true;
    this.faults.add(fault);
    return () => {
      this.faults.delete(fault);
      // A half-open connection never comes back: both sides learn of it at the end.
      if (fault.mode === 'half_open') for (const connection of concerned) connection.destroy();
      for (const connection of this.connections) for (const direction of [0, 1]) connection.forward(direction);
    };
  }

  end_faults() {
    this.faults.clear();
    for (const connection of [...this.connections]) {
      if (connection.half_open) connection.destroy();
      else for (const direction of [0, 1]) connection.forward(direction);
    }
  }

  close() {
    for (const connection of [...this.connections]) connection.destroy();
    return new Promise((resolve) => this.server.close(resolve));
  }
}
