// vda-5050-lib's Virtual AGV: a third-party vehicle with VDA 5050 2.0.0 and without CoSiVA's messages.
import assert from 'node:assert/strict';
import vda5050 from 'vda-5050-lib';
import { finally_do } from './cleanup.mjs';
import { fetched, sleep } from './platform.mjs';

const { AgvController, VirtualAgvAdapter } = vda5050;

export const stranger = 'RobotCompany/001';
export const snapshot_of = async (url) => JSON.parse((await fetched(`${url}/api/v1/snapshot`, 2_000)).text);

export async function start_foreign_vehicle(t, { broker_port, circuit, waypoint, serial = '001', speed_mps = 0.8 }) {
  const start = circuit.at(waypoint);
  const controller = new AgvController(
    { manufacturer: 'RobotCompany', serialNumber: serial },
    { interfaceName: 'uagv', transport: { brokerUrl: `mqtt://127.0.0.1:${broker_port}` }, vdaVersion: '2.0.0' },
    { agvAdapterType: VirtualAgvAdapter, publishStateInterval: 1_000, publishVisualizationInterval: 100 },
    {
      initialPosition: { mapId: circuit.name, x: start.x, y: start.y, theta: circuit.heading(waypoint), lastNodeId: start.id },
      vehicleSpeed: speed_mps,
      tickRate: 50,
      // The AGV drives straight from node to node: its heading differs from the circuit's by half an edge's turn.
      agvNormalDeviationXyTolerance: 0.5,
      agvNormalDeviationThetaTolerance: Math.PI,
    },
  );
  await controller.start();
  finally_do(t, async () => {
    // An order between its OFFLINE message and the end of its connection makes the library throw, and never end.
    controller._mqtt?.removeAllListeners('message');
    await controller.stop();
  });
  return controller;
}

/** Follows one twin until it has driven `distance_m`; returns its sections. `each` is called with every snapshot. */
export async function follow(url, id, distance_m, within_ms, each = () => {}) {
  const end = Date.now() + within_ms;
  const sections = new Set();
  let driven = 0;
  let last = null;
  while (driven < distance_m) {
    assert.ok(Date.now() < end, `${id} drove ${driven.toFixed(1)} of ${distance_m.toFixed(1)} m within ${within_ms} ms`);
    const snapshot = await snapshot_of(url);
    const aiv = snapshot.aivs.find((candidate) => candidate.id === id);
    assert.ok(aiv, `${id} is shown`);
    assert.equal(aiv.connection, 'ONLINE');
    each(snapshot);
    if (aiv.section !== null) sections.add(aiv.section);
    if (last) driven += Math.hypot(aiv.x - last.x, aiv.y - last.y);
    last = aiv;
    await sleep(40);
  }
  return sections;
}
