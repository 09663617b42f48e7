// Operators who give commands over HTTP, and the log of their requests: what was confirmed, refused, and what has an unknown
// outcome because no response arrived.
const request_ms = 6_000;

export function serials_of(body, aivs) {
  if (body.vehicle === '*') return Array.from({ length: aivs }, (_, i) => `AIV${i + 1}`);
  return (body.vehicles ?? [body.vehicle]).map((name) => name.split('/')[1]);
}

export class Operators {
  /** @param url  () => address of the server */
  constructor(url, aivs) {
    Object.assign(this, { url, aivs, log: [] });
  }

  async get(what, within_ms = 2_000) {
    const response = await fetch(`${this.url()}/api/v1/${what}`, { signal: AbortSignal.timeout(within_ms) });
    if (response.status !== 200) throw new Error(`GET ${what}: ${response.status}`);
    return response.json();
  }

  /**
   * @returns the entry: {operator, body, sent_ms, done_ms, status, id, error, outcome: confirmed|refused|unknown, durable}.
   * `durable` is false of a Stop whose record the response states to be not durable yet
   */
  async give(operator, body) {
    const entry = { operator, body, sent_ms: Date.now(), outcome: 'open' };
    this.log.push(entry);
    try {
      const response = await fetch(`${this.url()}/api/v1/commands`, {
        method: 'POST',
        headers: { 'content-type': 'application/json' },
        body: JSON.stringify(body),
        signal: AbortSignal.timeout(request_ms),
      });
      entry.status = response.status;
      entry.done_ms = Date.now();
      const content = await response.json();
      entry.id = content.id;
      entry.error = content.error;
      entry.durable = response.status === 202 && content.durable !== false;
      entry.states_durable = typeof content.durable === 'boolean';
      entry.outcome = response.status === 202 ? 'confirmed' : 'refused';
    } catch (error) {
      entry.done_ms = Date.now();
      entry.reason = error.cause?.code ?? error.name;
      // Without a connection the server has received nothing.
      entry.outcome = entry.reason === 'ECONNREFUSED' ? 'refused' : 'unknown';
    }
    return entry;
  }

  concerning(serial) {
    return this.log.filter(({ body }) => serials_of(body, this.aivs).includes(serial));
  }

  /** Could a command to restart the vehicle still take effect, or have taken effect after a Stop? */
  restart_is_open(serial) {
    return this.concerning(serial).some(({ body, outcome }) => body.command === 'restart' && (outcome === 'open' || outcome === 'unknown'));
  }
}
