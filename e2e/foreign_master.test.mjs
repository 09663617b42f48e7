// A third-party master control, without CoSiVA's server, drives a CoSiVA AIV over four nodes, pauses, resumes,
// cancels.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ForeignMaster, order_over } from './lib/foreign_master.mjs';
import { cosiva_json, eventually, sleep } from './lib/platform.mjs';

test('a third-party master control drives a CoSiVA AIV', { timeout: 150_000 }, async (t) => {
  const control = await ForeignMaster.start(t);
  const { circuit, ground_truth, first } = control;

  await t.test('over four nodes, in order', async () => {
    const order = order_over(circuit, first, 5);
    const run = await control.assign(order);
    const { error, by_cancelation } = await control.within(30_000, run.done, 'the order is processed');
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
    long = await control.assign(order_over(circuit, first + 4, 9));
    await ground_truth.moves(1, 5_000);
    await control.instant('startPause');
    await ground_truth.stands(1, 2_000);
    await eventually('its state reports it', () => control.state.paused === true && control.state.driving === false, { within_ms: 2_000 });
    const before = ground_truth.vehicle(1).distance;
    await sleep(1_000);
    assert.ok(ground_truth.vehicle(1).distance - before < 0.005);
  });

  await t.test('resumes it', async () => {
    await control.instant('stopPause');
    await ground_truth.moves(1, 2_000);
    assert.equal(control.state.paused, false);
  });

  await t.test('cancels its order', async () => {
    await control.instant('cancelOrder');
    const { by_cancelation } = await control.within(8_000, long.done, 'the order is processed');
    assert.equal(by_cancelation, true);
    await ground_truth.stands(1, 2_000);
    assert.deepEqual([control.state.nodeStates, control.state.edgeStates], [[], []]);
  });

  await t.test('receives noOrderToCancel when there is none', async () => {
    await assert.rejects(control.instant('cancelOrder'));
    await eventually('the state names the reason', () => control.state.errors.some((error) => error.errorType === 'noOrderToCancel'), { within_ms: 3_000 });
  });

  await t.test('is refused an order that starts far away, and the vehicle stays', async () => {
    const before = ground_truth.vehicle(1).distance;
    await control.assign(order_over(circuit, first + 30, 3));
    await eventually('an error names it', () => control.state.errors.some((error) => /noRouteError|orderError|validationError/.test(error.errorType)), { within_ms: 3_000 });
    await sleep(500);
    assert.ok(ground_truth.vehicle(1).distance - before < 0.005);
  });

  ground_truth.assert_no_collision();

  await t.test('and both parts replay to the digests that they ended with', async () => {
    await control.vehicle.stop();
    await control.plant.stop();
    for (const kind of ['aiv', 'plant']) {
      const replayed = await cosiva_json(['replay', control.journals[kind], '--json']);
      assert.equal(replayed.kind, kind);
      assert.equal(replayed.equal, true, `${kind}: ${JSON.stringify(replayed)}`);
    }
  });
});
