// Fixed schedules: combinations that random ones meet rarely, most of which have found a defect. `scripts/chaos --case NAME`.
const everyone = '*';
const stop = { command: 'stop', vehicle: everyone };
const limit = { command: 'limit', vehicle: 'CoSiVA/AIV2', speed: 0.1234 };
const full = { at_ms: 300, what: 'fill', strict: false, ms: 6_000 };

function kill(at_ms, part, back_ms = 300) {
  return { at_ms, what: 'kill', part, examine: false, back_ms };
}

function give(at_ms, body) {
  return { at_ms, what: 'command', operator: 'A', body };
}

function killed_after(body, after_ms) {
  return { at_ms: 500, what: 'command_then_kill', operator: 'A', body, after_ms };
}

function repeated(count, kind, actions) {
  return Array.from({ length: count }, () => ({ kind, actions }));
}

const large_body = { what: 'body', megabytes: 60, path: 'zone/switch' };

/** name: {why, topology, disk_megabytes?, episodes} */
export const cases = {
  stop_then_kill: { why: 'the server dies within milliseconds of its response to a Stop', episodes: repeated(4, 'stop', [killed_after(stop, 0)]) },
  limit_then_kill: { why: 'the server dies before it executes a command that it has confirmed', episodes: repeated(4, 'free', [killed_after(limit, 0)]) },
  dead_vehicle: { why: 'a Stop for a vehicle that is dead, then the server or `up` dies', episodes: [{ kind: 'stop', actions: [kill(1_300, 'aiv1'), give(1_600, stop), kill(2_000, 'server')] }, { kind: 'stop', actions: [kill(1_300, 'aiv1'), give(1_600, stop), kill(2_000, 'up')] }] },
  stop_on_full_disk: {
    why: 'a Stop on a full disk, and the server, a vehicle or `up` dies before the disk has space again',
    episodes: [
      { kind: 'stop', actions: [full, give(1_500, stop), kill(3_000, 'server')] },
      { kind: 'stop', actions: [full, kill(1_300, 'aiv1'), give(1_500, stop), kill(2_000, 'server')] },
      { kind: 'stop', actions: [full, give(1_500, stop), kill(3_000, 'up')] },
    ],
  },
  large_body: { why: 'a body that the server needs seconds to evaluate', episodes: [{ kind: 'free', actions: [{ at_ms: 500, ...large_body }] }, { kind: 'stop', actions: [{ at_ms: 500, ...large_body }, give(1_500, stop)] }] },
  large_body_small_disk: { why: 'a body that is larger than the free space of the disk', disk_megabytes: 40, episodes: [{ kind: 'free', actions: [{ at_ms: 500, ...large_body }] }] },
  up_again_at_once: { why: '`up` is started again while the server of the killed one is still busy', episodes: [{ kind: 'free', actions: [{ at_ms: 500, ...large_body }, kill(2_500, 'up', 100)] }, ...repeated(2, 'free', [kill(500, 'up', 1)])] },
};

export function plan_of(name) {
  const { topology = 'private', episodes } = cases[name];
  return [{ topology, episodes }];
}
