// vda-5050-lib's Virtual AGV: somebody else's vehicle, which speaks VDA 5050 2.0.0 and knows nothing of us.
import { finally_do } from './cleanup.mjs';
import vda5050 from 'vda-5050-lib';

const { AgvController, VirtualAgvAdapter } = vda5050;

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
      // It drives straight from node to node: its heading differs from the circuit's by half an edge's turn.
      agvNormalDeviationXyTolerance: 0.5,
      agvNormalDeviationThetaTolerance: Math.PI,
    },
  );
  await controller.start();
  finally_do(t, () => controller.stop());
  return controller;
}
