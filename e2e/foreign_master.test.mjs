// A third-party master control, without CoSiVA's server, drives a CoSiVA AIV over four nodes, pauses, resumes,
// cancels.
import assert from 'node:assert/strict';
import path from 'node:path';
import { mkdirSync } from 'node:fs';
import { test } from 'node:test';
import vda5050 from 'vda-5050-lib';
import { finally_do } from './lib/cleanup.mjs';
import { Bus, Truth } from './lib/bus.mjs';
import { Circuit } from './lib/circuit.mjs';
import { cosiva_binary, cosiva_json, eventually, Program, sleep, start_broker, work_folder, zone_file } from './lib/platform.mjs';

const { BlockingType, MasterController, createUuid } = vda5050;
const aiv = { manufacturer: 'CoSiVA', serialNumber: 'AIV1' };
const start = { section: 'loop_se', s: 1.2 }; // the first [[start]] of zones/lacet4.toml

/** An order over waypoints index … index + count − 1, all of them released. */
function order_over(circuit, index, count) {
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

test('a third-party master control drives a CoSiVA AIV', { timeout: 150_000 }, async (t) => {
  const circuit = await Circuit.load();
  const folder = work_folder(t);
  const broker = await start_broker(t, folder);
  const sockets = path.join(folder, 'boards');
  mkdirSync(sockets);
  const zone = zone_file('lacet4');
  const part = (...args) => new Program(t, cosiva_binary(), [...args, '--sockets', sockets, '--broker', broker.address], { cwd: folder });
  const journals = { plant: path.join(folder, 'plant.journal'), aiv: path.join(folder, 'aiv.journal') };
  const plant = part('plant', '--zone', zone, '--vehicles', '1', '--record', journals.plant);
  const vehicle = part('aiv', '--record', journals.aiv, '--number', '1', '--zone', zone, '--start', `${start.section}:${start.s}`, '--state-file', path.join(folder, 'aiv1.state_file'));
  const ground_truth = await Truth.follow(t, broker.port);
  const bus = await Bus.open(t, broker.port, ['uagv/v2/CoSiVA/AIV1/state']);
  let state = null;
  bus.on_message((_topic, payload) => (state = JSON.parse(payload.toString())));
  await eventually(`the AIV reports where it is\n${vehicle.words}`, () => state?.agvPosition?.positionInitialized === true);

  // CoSiVA's headers state 2.1.0; this library compares the whole version and would drop every message of the AIV.
  const master = new MasterController(
    { interfaceName: 'uagv', transport: { brokerUrl: `mqtt://127.0.0.1:${broker.port}` }, vdaVersion: '2.0.0', topicObjectValidation: { inbound: false, outbound: true } },
    { targetAgvs: aiv },
  );
  await master.start();
  finally_do(t, () => master.stop());
  await sleep(300);

  /** Assigns an order; `done` resolves when it is processed, `traversed` grows meanwhile. */
  const assign = async (order) => {
    const run = { traversed: [] };
    run.done = new Promise((resolve) => {
      run.settle = resolve;
    });
    await master.assignOrder(aiv, order, {
      onOrderProcessed: (error, by_cancelation) => run.settle({ error, by_cancelation }),
      onNodeTraversed: (node) => run.traversed.push(node.nodeId),
    });
    return run;
  };
  const instant = (actionType) =>
    new Promise((resolve, reject) => {
      const action = { actionId: createUuid(), actionType, blockingType: BlockingType.Hard };
      setTimeout(() => reject(new Error(`${actionType} was not finished within 8 s`)), 8_000).unref();
      master.initiateInstantActions(aiv, { instantActions: [action] }, {
        onActionStateChanged: ({ actionStatus, resultDescription }) => {
          if (actionStatus === 'FINISHED') resolve(resultDescription);
          if (actionStatus === 'FAILED') reject(new Error(`${actionType} failed: ${resultDescription}`));
        },
        onActionError: (error) => reject(new Error(`${actionType}: ${error.errorType} ${error.errorDescription}`)),
      }).catch(reject);
    });
  const within = (ms, promise, what) =>
    Promise.race([promise, new Promise((_resolve, reject) => setTimeout(() => reject(new Error(`not within ${ms} ms: ${what}; errors ${JSON.stringify(state.errors)}`)), ms).unref())]);

  const first = circuit.behind(start.section, start.s);

  await t.test('over four nodes, in order', async () => {
    const order = order_over(circuit, first, 5);
    const run = await assign(order);
    const { error, by_cancelation } = await within(30_000, run.done, 'the order is processed');
    assert.equal(error, undefined);
    assert.equal(by_cancelation, false);
    const reached = order.nodes.slice(1).map((node) => node.nodeId);
    assert.deepEqual(run.traversed.filter((id) => id !== order.nodes[0].nodeId), reached);
    await ground_truth.stands(1, 2_000);
    const goal = circuit.at(first, 4);
    const { x, y } = ground_truth.vehicle(1);
    assert.ok(Math.hypot(x - goal.x, y - goal.y) < 0.06, `it stopped ${Math.hypot(x - goal.x, y - goal.y).toFixed(3)} m from the last node`);
  });

  let long;
  await t.test('pauses it', async () => {
    long = await assign(order_over(circuit, first + 4, 9));
    await ground_truth.moves(1, 5_000);
    await instant('startPause');
    await ground_truth.stands(1, 2_000);
    await eventually('its state reports it', () => state.paused === true && state.driving === false, { within_ms: 2_000 });
    const before = ground_truth.vehicle(1).distance;
    await sleep(1_000);
    assert.ok(ground_truth.vehicle(1).distance - before < 0.005);
  });

  await t.test('resumes it', async () => {
    await instant('stopPause');
    await ground_truth.moves(1, 2_000);
    assert.equal(state.paused, false);
  });

  await t.test('cancels its order', async () => {
    await instant('cancelOrder');
    const { by_cancelation } = await within(8_000, long.done, 'the order is processed');
    assert.equal(by_cancelation, true);
    await ground_truth.stands(1, 2_000);
    assert.deepEqual([state.nodeStates, state.edgeStates], [[], []]);
  });

  await t.test('receives noOrderToCancel when there is none', async () => {
    await assert.rejects(instant('cancelOrder'));
    await eventually('the state names the reason', () => state.errors.some((error) => error.errorType === 'noOrderToCancel'), { within_ms: 3_000 });
  });

  await t.test('is refused an order that starts far away, and the vehicle stays', async () => {
    const before = ground_truth.vehicle(1).distance;
    await assign(order_over(circuit, first + 30, 3));
    await eventually('an error names it', () => state.errors.some((error) => /noRouteError|orderError|validationError/.test(error.errorType)), { within_ms: 3_000 });
    await sleep(500);
    assert.ok(ground_truth.vehicle(1).distance - before < 0.005);
  });

  ground_truth.assert_no_collision();

  await t.test('and both parts replay to the digests that they ended with', async () => {
    await vehicle.stop();
    await plant.stop();
    for (const kind of ['aiv', 'plant']) {
      const replayed = await cosiva_json(['replay', journals[kind], '--json']);
      assert.equal(replayed.kind, kind);
      assert.equal(replayed.equal, true, `${kind}: ${JSON.stringify(replayed)}`);
    }
  });
});
