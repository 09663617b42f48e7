// One CoSiVA vehicle with its plant, without CoSiVA's server, under a third-party master control (vda-5050-lib).
import path from 'node:path';
import { mkdirSync } from 'node:fs';
import vda5050 from 'vda-5050-lib';
import { finally_do } from './cleanup.mjs';
import { Bus, Truth } from './bus.mjs';
import { Circuit } from './circuit.mjs';
import { cosiva_binary, eventually, Program, sleep, start_broker, work_folder, zone_file } from './platform.mjs';

const { BlockingType, MasterController, createUuid } = vda5050;
const aiv = { manufacturer: 'CoSiVA', serialNumber: 'AIV1' };
const start = { section: 'loop_se', s: 1.2 }; // the first [[start]] of zones/lacet4.toml

export const { Hard, Soft, None } = BlockingType;

/** An action of an order. */
export const action = (actionType, blockingType, parameters = {}) => ({
  actionId: createUuid(),
  actionType,
  blockingType,
  actionParameters: Object.entries(parameters).map(([key, value]) => ({ key, value })),
});

/** An order over waypoints index … index + count − 1, all of them released. */
export function order_over(circuit, index, count) {
  const nodes = Array.from({ length: count }, (_, i) => {
    const { id, x, y } = circuit.at(index, i);
    // The vehicle is anywhere between the first waypoint and the next.
    const allowed = i === 0 ? { allowedDeviationXy: 0.5 } : {};
    return { nodeId: id, sequenceId: 2 * i, released: true, nodePosition: { x, y, mapId: circuit.name, ...allowed }, actions: [] };
  });
  const edges = nodes.slice(1).map((node, i) => ({
    edgeId: `${nodes[i].nodeId}-${node.nodeId}`, sequenceId: 2 * i + 1, released: true, startNodeId: nodes[i].nodeId, endNodeId: node.nodeId, actions: [],
  }));
  return { orderId: createUuid(), orderUpdateId: 0, nodes, edges };
}

export class ForeignMaster {
  /** @param more  arguments of `cosiva aiv` */
  static async start(t, more = []) {
    const self = new ForeignMaster();
    self.circuit = await Circuit.load();
    const folder = work_folder(t);
    self.folder = folder;
    const broker = await start_broker(t, folder);
    const sockets = path.join(folder, 'boards');
    mkdirSync(sockets);
    const zone = zone_file('lacet4');
    const part = (...args) => new Program(t, cosiva_binary(), [...args, '--sockets', sockets, '--broker', broker.address], { cwd: folder });
    self.journals = { plant: path.join(folder, 'plant.journal'), aiv: path.join(folder, 'aiv.journal') };
    self.plant = part('plant', '--zone', zone, '--vehicles', '1', '--record', self.journals.plant);
    self.vehicle = part('aiv', '--record', self.journals.aiv, '--number', '1', '--zone', zone, '--start', `${start.section}:${start.s}`, '--state-file', path.join(folder, 'aiv1.state_file'), ...more);
    self.ground_truth = await Truth.follow(t, broker.port);
    const bus = await Bus.open(t, broker.port, ['uagv/v2/CoSiVA/AIV1/state', 'uagv/v2/CoSiVA/AIV1/factsheet']);
    self.state = null;
    self.states = [];
    self.factsheet = null;
    bus.on_message((topic, payload) => {
      const message = JSON.parse(payload.toString());
      if (topic.endsWith('factsheet')) return void (self.factsheet = message);
      self.state = message;
      self.states.push(message);
    });
    await eventually(`the AIV reports where it is\n${self.vehicle.words}`, () => self.state?.agvPosition?.positionInitialized === true);

    // CoSiVA's headers state 2.1.0; this library compares the whole version and would drop every message of the AIV.
    self.master = new MasterController(
      { interfaceName: 'uagv', transport: { brokerUrl: `mqtt://127.0.0.1:${broker.port}` }, vdaVersion: '2.0.0', topicObjectValidation: { inbound: false, outbound: true } },
      { targetAgvs: aiv },
    );
    await self.master.start();
    finally_do(t, () => self.master.stop());
    await sleep(300);
    self.first = self.circuit.behind(start.section, start.s);
    return self;
  }

  /** Assigns an order; `done` resolves when it is processed, `traversed` and `actions` grow meanwhile. */
  async assign(order) {
    const run = { traversed: [], actions: [] };
    run.done = new Promise((resolve) => {
      run.settle = resolve;
    });
    await this.master.assignOrder(aiv, order, {
      onOrderProcessed: (error, by_cancelation) => run.settle({ error, by_cancelation }),
      onNodeTraversed: (node) => run.traversed.push(node.nodeId),
      onActionStateChanged: ({ actionId, actionStatus }) => run.actions.push([actionId, actionStatus]),
    });
    return run;
  }

  instant(actionType, parameters = {}) {
    return new Promise((resolve, reject) => {
      setTimeout(() => reject(new Error(`${actionType} was not finished within 8 s`)), 8_000).unref();
      this.master.initiateInstantActions(aiv, { instantActions: [action(actionType, Hard, parameters)] }, {
        onActionStateChanged: ({ actionStatus, resultDescription }) => {
          if (actionStatus === 'FINISHED') resolve(resultDescription);
          if (actionStatus === 'FAILED') reject(new Error(`${actionType} failed: ${resultDescription}`));
        },
        onActionError: (error) => reject(new Error(`${actionType}: ${error.errorType} ${error.errorDescription}`)),
      }).catch(reject);
    });
  }

  within(ms, promise, what) {
    return Promise.race([promise, new Promise((_resolve, reject) => setTimeout(() => reject(new Error(`not within ${ms} ms: ${what}; errors ${JSON.stringify(this.state.errors)}`)), ms).unref())]);
  }
}
