// Clients that burden the server: connections without a request, and one enormous body.
import { request } from 'node:http';
import { connect } from 'node:net';

/** Opens `count` connections; every second one sends the beginning of a request. Returns the function that closes them. */
export function idle_connections(port, count) {
  const sockets = Array.from({ length: count }, (_, i) => {
    const socket = connect(port, '127.0.0.1', () => {
      if (i % 2 === 0) socket.write('POST /api/v1/commands HTTP/1.1\r\nhost: 127.0.0.1\r\n');
    });
    return socket.on('error', () => {});
  });
  return () => sockets.forEach((socket) => socket.destroy());
}

/** Sends a JSON body of that size; the status of the response, or the error's code. */
export function send_large_body(port, path, megabytes, within_ms = 60_000) {
  const beginning = path === 'commands' ? '{"command":"stop","vehicle":"' : '{"file":"large.toml","text":"';
  const body = Buffer.concat([Buffer.from(beginning), Buffer.alloc(megabytes << 20, 'a'), Buffer.from('"}')]);
  return new Promise((resolve) => {
    const sent = request({ port, host: '127.0.0.1', path: `/api/v1/${path}`, method: 'POST', headers: { 'content-type': 'application/json', 'content-length': body.length } });
    const timer = setTimeout(() => sent.destroy(Object.assign(new Error('late'), { code: 'LATE' })), within_ms);
    const finish = (result) => {
      clearTimeout(timer);
      resolve(result);
    };
    sent.on('response', (response) => {
      response.resume();
      finish(response.statusCode);
    });
    sent.on('error', (error) => finish(error.code));
    sent.end(body);
  });
}
