// The communications of the made-up platform, with raw messages as VDA 5050 and CoSiVA's own topics have them.
export class Traces {
  next = 1;
  stored = [];
  constructor(limit = 20_000) {
    this.limit = limit;
  }
  add(time_ms, from, to, kind, topic, content, raw) {
    this.stored.push({ n: this.next++, time_ms, from, to, kind, topic, content: content.slice(0, 200), raw: typeof raw === 'string' ? raw : JSON.stringify(raw) });
    if (this.stored.length > 2 * this.limit) this.stored.splice(0, this.stored.length - this.limit);
  }
  list(after, limit) {
    const oldest = this.stored[0]?.n ?? this.next;
    const from = Math.max(0, after - oldest);
    const traces = this.stored.slice(from, from + limit).map(({ n, time_ms, from: sender, to, kind, content }) => ({ n, time_ms, from: sender, to, kind, content }));
    return { next: traces.length > 0 ? traces.at(-1).n + 1 : this.next, oldest, traces };
  }
  one(n) {
    return this.stored[n - (this.stored[0]?.n ?? 0)] ?? null;
  }
}

const version = '2.1.0';
const maker_of = (id) => id.split('/');
const header = (id, now, headerId) => ({ headerId, timestamp: new Date(now).toISOString(), version, manufacturer: maker_of(id)[0], serialNumber: maker_of(id)[1] });
export const topic_of = (id, kind) => `uagv/v2/${id}/${kind}`;

let header_id = 0;

export function state_of(aiv, now, map) {
  return {
    ...header(aiv.id, now, ++header_id), orderId: aiv.orderId, orderUpdateId: aiv.orderUpdateId, lastNodeId: aiv.lastNode, lastNodeSequenceId: 2 * aiv.orderUpdateId,
    nodeStates: [{ nodeId: `${aiv.section}@next`, sequenceId: 2 * aiv.orderUpdateId + 2, released: true }], edgeStates: [],
    agvPosition: { x: aiv.x, y: aiv.y, theta: aiv.heading, mapId: map, positionInitialized: true }, velocity: { vx: aiv.speed, vy: 0, omega: 0 },
    driving: aiv.driving, paused: aiv.paused, newBaseRequest: false, distanceSinceLastNode: 0.12, operatingMode: 'AUTOMATIC',
    batteryState: { batteryCharge: aiv.battery, charging: false }, errors: [], actionStates: [],
    information: [{ infoType: 'lastTag', infoLevel: 'INFO', infoReferences: [{ referenceKey: 'tag', referenceValue: String(aiv.lastTag) }, { referenceKey: 'distance_m', referenceValue: aiv.sinceTag_m.toFixed(3) }] }],
    safetyState: { eStop: 'NONE', fieldViolation: aiv.fieldViolation },
  };
}

export function visualization_of(aiv, now, map) {
  return {
    ...header(aiv.id, now, ++header_id), agvPosition: { x: aiv.reported.x, y: aiv.reported.y, theta: aiv.reported.heading, mapId: map, positionInitialized: true },
    velocity: { vx: aiv.speed, vy: 0, omega: 0 },
  };
}

export function intent_of(aiv, now, map) {
  const [manufacturer, serialNumber] = aiv.id.split('/');
  return {
    headerId: ++header_id, timestamp: new Date(now).toISOString(), mapId: map, manufacturer, serialNumber, x: aiv.reported.x, y: aiv.reported.y, heading: aiv.reported.heading,
    speed: aiv.speed, braking: false, priority: aiv.priority, position: { section: aiv.section, s: 0.5 },
    crossings: [{ name: 'X1', entry: 0.31, exit: 0.71, arrival: 0.9, departure: 1.9, mayEnter: false }], route: [],
  };
}

export function order_of(aiv, now, map) {
  const nodes = [0, 1, 2, 3].map((i) => ({
    nodeId: `${aiv.section}@${(aiv.orderUpdateId + i) * 300}`, sequenceId: 2 * (aiv.orderUpdateId + i), released: i < 3,
    nodePosition: { x: aiv.x, y: aiv.y, mapId: map, allowedDeviationXY: 0.05 }, actions: [],
  }));
  const edges = nodes.slice(1).map((node, i) => ({ edgeId: `${nodes[i].nodeId}-${node.nodeId}`, sequenceId: nodes[i].sequenceId + 1, released: node.released, startNodeId: nodes[i].nodeId, endNodeId: node.nodeId, actions: [] }));
  return { ...header(aiv.id, now, ++header_id), orderId: aiv.orderId, orderUpdateId: aiv.orderUpdateId, nodes, edges };
}

export function action_of(id, now, command, action_id) {
  const action = command === 'stop' ? { actionType: 'startPause' } : command === 'restart' ? { actionType: 'stopPause' } : command === 'cancel' ? { actionType: 'cancelOrder' }
    : { actionType: 'setSpeedLimit', actionParameters: [{ key: 'profile', value: command }] };
  return { ...header(id, now, ++header_id), actions: [{ actionId: action_id, blockingType: 'NONE', ...action }] };
}
