// A TCP proxy in front of a broker that delays some of the segments, as a radio link with losses does.
import { createServer, connect } from 'node:net';
import { finally_do } from './cleanup.mjs';

/** Numbers from 0 to 1, the same in each run (Park and Miller). */
function drawn(seed) {
  let state = seed;
  return () => (state = (state * 48_271) % 2_147_483_647) / 2_147_483_647;
}

/** Forwards to `port`; a delayed segment delays those after it on the same connection. Returns {port, delayed, count}. */
export async function slow_proxy(t, port, { ratio = 0.01, delay_ms = 200, seed = 1 } = {}) {
  const random = drawn(seed);
  const proxy = { port: 0, segments: 0, delayed: 0 };
  const sockets = new Set();
  const forward = (from, to) => {
    let last_ms = 0;
    from.on('data', (bytes) => {
      ++proxy.segments;
      const is_late = random() < ratio;
      if (is_late) ++proxy.delayed;
      const due_ms = Math.max(last_ms, performance.now() + (is_late ? delay_ms : 0));
      last_ms = due_ms;
      const wait_ms = due_ms - performance.now();
      if (wait_ms <= 0) to.write(bytes);
      else setTimeout(() => to.write(bytes), wait_ms);
    });
    from.on('close', () => to.destroy());
    from.on('error', () => to.destroy());
  };
  const server = createServer({ noDelay: true }, (client) => {
    const broker = connect({ port, host: '127.0.0.1', noDelay: true });
    for (const socket of [client, broker]) sockets.add(socket);
    forward(client, broker);
    forward(broker, client);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  proxy.port = server.address().port;
  finally_do(t, () => {
    for (const socket of sockets) socket.destroy();
    server.close();
  });
  return proxy;
}
