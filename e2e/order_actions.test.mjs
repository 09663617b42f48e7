// A third-party master control, without CoSiVA's server, has a CoSiVA AIV pick, drop and charge: HARD and SOFT actions
// at nodes, NONE actions while it drives.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { action, ForeignMaster, Hard, None, order_over, Soft } from './lib/foreign_master.mjs';
import { cosiva_json, eventually, work_folder } from './lib/platform.mjs';

const vehicle_file = `
load_positions = ["front", "back"]
[action.pick]
preparation_s = 0.5
duration_s = 2
[action.drop]
duration_s = 1
[action.polish]
scopes = ["edge"]
duration_s = 60
`;

test('a third-party master control has a CoSiVA AIV handle loads and charge', { timeout: 150_000 }, async (t) => {
  const file = path.join(work_folder(t), 'vehicle.toml');
  writeFileSync(file, vehicle_file);
  const control = await ForeignMaster.start(t, ['--vehicle-file', file]);
  const { circuit, ground_truth, first } = control;
  const status = (id, state = control.state) => state.actionStates.find((each) => each.actionId === id)?.actionStatus;
  const states_while = (id, ...wanted) => control.states.filter((state) => wanted.includes(status(id, state)));

  await t.test('which the factsheet declares', async () => {
    await control.instant('factsheetRequest');
    await eventually('the factsheet', () => control.factsheet !== null);
    const declared = Object.fromEntries(control.factsheet.protocolFeatures.agvActions.map((each) => [each.actionType, each]));
    assert.deepEqual(declared.pick.actionScopes, ['NODE', 'EDGE']);
    assert.deepEqual(declared.pick.blockingTypes, ['NONE', 'SOFT', 'HARD']);
    assert.deepEqual(declared.startCharging.actionScopes, ['INSTANT', 'NODE']);
    assert.deepEqual(declared.polish.actionScopes, ['EDGE']);
    assert.deepEqual(control.factsheet.loadSpecification.loadPositions, ['front', 'back']);
    assert.deepEqual(control.state.loads, []);
  });

  await t.test('picks HARD, polishes an edge while it drives, drops SOFT, and charges', async () => {
    const order = order_over(circuit, first, 8);
    const pick = action('pick', Hard, { stationType: 'floor', loadType: 'EPAL', loadId: 'L1' });
    const polish = action('polish', None);
    const drop = action('drop', Soft, { loadId: 'L1' });
    const detect = action('detectObject', Soft);
    const charge = action('startCharging', Hard);
    order.nodes[2].actions = [pick];
    order.edges[3].actions = [polish];
    order.nodes[5].actions = [drop, detect];
    order.nodes[7].actions = [charge];
    const run = await control.assign(order);
    const { error, by_cancelation } = await control.within(60_000, run.done, 'the order is processed');
    assert.equal(error, undefined);
    assert.equal(by_cancelation, false);
    await eventually('the battery is charged', () => control.state.batteryState.charging === true);
    for (const each of [pick, polish, drop, detect, charge]) assert.equal(status(each.actionId), 'FINISHED', each.actionType);

    const handles = states_while(pick.actionId, 'INITIALIZING', 'RUNNING');
    assert.ok(handles.length > 0);
    for (const state of handles) assert.deepEqual([state.driving, state.lastNodeId, state.loads], [false, order.nodes[2].nodeId, []]);
    const loaded = control.states.filter((state) => state.loads.length > 0);
    assert.deepEqual(loaded[0].loads, [{ loadId: 'L1', loadType: 'EPAL', loadPosition: 'front' }]);
    const polishes = states_while(polish.actionId, 'RUNNING');
    assert.ok(polishes.some((state) => state.driving), 'a NONE action and driving go together');
    for (const state of polishes) assert.equal(state.lastNodeId, order.nodes[3].nodeId, 'only on its edge');
    assert.ok(states_while(drop.actionId, 'INITIALIZING', 'RUNNING').some((state) => status(detect.actionId, state) === 'RUNNING'), 'SOFT actions run together');
    for (const state of states_while(drop.actionId, 'INITIALIZING', 'RUNNING')) assert.equal(state.driving, false);
    assert.deepEqual(control.state.loads, []);
  });

  await t.test('and no longer charges when it drives', async () => {
    await control.within(20_000, (await control.assign(order_over(circuit, first + 7, 2))).done, 'the order is processed');
    assert.equal(control.state.batteryState.charging, false);
  });

  await t.test('a drop without a load fails, with an error that names action and node', async () => {
    const order = order_over(circuit, first + 8, 2);
    const drop = action('drop', Hard);
    order.nodes[1].actions = [drop];
    await control.assign(order);
    await eventually('the drop fails', () => status(drop.actionId) === 'FAILED', { within_ms: 15_000 });
    const error = control.state.errors.find(({ errorType }) => errorType === 'orderActionError');
    assert.deepEqual(error.errorReferences, [
      { referenceKey: 'actionId', referenceValue: drop.actionId },
      { referenceKey: 'actionType', referenceValue: 'drop' },
      { referenceKey: 'nodeId', referenceValue: order.nodes[1].nodeId },
    ]);
  });

  await t.test('pause and cancellation reach a pick', async () => {
    await eventually('the last order is over', () => control.state.nodeStates.length === 0);
    const order = order_over(circuit, first + 9, 3);
    const pick = action('pick', Hard, { stationType: 'floor', loadType: 'EPAL' });
    order.nodes[1].actions = [pick];
    const run = await control.assign(order);
    await eventually('it picks', () => status(pick.actionId) === 'RUNNING', { within_ms: 15_000 });
    await control.instant('startPause');
    await eventually('it is paused', () => status(pick.actionId) === 'PAUSED', { within_ms: 2_000 });
    await control.instant('stopPause');
    await eventually('it picks again', () => status(pick.actionId) === 'RUNNING', { within_ms: 2_000 });
    await control.instant('cancelOrder');
    const { by_cancelation } = await control.within(8_000, run.done, 'the order is processed');
    assert.equal(by_cancelation, true);
    assert.equal(status(pick.actionId), 'FAILED');
    assert.deepEqual([control.state.nodeStates, control.state.loads], [[], []]);
  });

  ground_truth.assert_no_collision();

  await t.test('and the AIV replays to the digest that it ended with', async () => {
    await control.vehicle.stop();
    const replayed = await cosiva_json(['replay', control.journals.aiv, '--json']);
    assert.equal(replayed.equal, true, JSON.stringify(replayed));
  });
});
