// Ten deviations of a running platform from the bijection, all of which the page names.
import { Bus } from './bus.mjs';
import { eventually, sleep } from './platform.mjs';

const header = (serialNumber, headerId) => ({ headerId, timestamp: new Date().toISOString(), version: '2.1.0', manufacturer: 'ACME', serialNumber });

function state_at(serial, headerId, x, y) {
  return {
    ...header(serial, headerId), orderId: '', orderUpdateId: 0, lastNodeId: '', lastNodeSequenceId: 0, nodeStates: [], edgeStates: [], actionStates: [],
    driving: false, paused: false, newBaseRequest: false, errors: [], information: [], operatingMode: 'AUTOMATIC',
    agvPosition: { x, y, theta: 0, mapId: 'lacet4', positionInitialized: true },
    batteryState: { batteryCharge: 12, charging: false }, safetyState: { eStop: 'NONE', fieldViolation: false },
  };
}

/**
 * Third-party vehicles that report ten times a second, and then end their connection (four), sign off (three) or are silent
 * (three). Their twins stay, as orphans: ten findings, with the reason.
 */
export async function ten_findings(t, platform) {
  const bus = await Bus.open(t, await platform.broker_port(), []);
  const topic = (i, name) => `uagv/v2/ACME/${i + 1}/${name}`;
  const all = Array.from({ length: 10 }, (_, i) => i);
  const connection = (i, headerId, connectionState) => bus.publish(topic(i, 'connection'), { ...header(String(i + 1), headerId), connectionState }, { qos: 1 });
  await Promise.all(all.map((i) => connection(i, 0, 'ONLINE')));
  for (let report = 0; report < 6; ++report) {
    await Promise.all(all.map((i) => bus.publish(topic(i, 'state'), state_at(String(i + 1), report, -1.2 + 0.27 * i, 0.15), { qos: 1 })));
    await sleep(100);
  }
  await Promise.all(all.slice(0, 7).map((i) => connection(i, 1, i < 4 ? 'CONNECTIONBROKEN' : 'OFFLINE')));
  await eventually('ten orphans', async () => (await platform.get('bijection')).orphans.length >= 10, { within_ms: 8_000, every_ms: 100 });
}
