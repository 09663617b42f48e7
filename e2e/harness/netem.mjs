// Packet loss and delay by the kernel (`tc netem`), only in a network namespace of the harness: on the machine's own
// loopback it would disturb other programs.
import { execFileSync, spawnSync } from 'node:child_process';

const inside_variable = 'COSIVA_CHAOS_OWN_NETWORK';

/** Why netem cannot be used, or '' where it can. */
export function netem_obstacle() {
  const script = 'ip link set lo up && tc qdisc add dev lo root netem delay 1ms';
  const tried = spawnSync('unshare', ['--net', 'sh', '-c', script], { encoding: 'utf8' });
  if (tried.error) return tried.error.message;
  return tried.status === 0 ? '' : (tried.stderr || tried.stdout || `exit ${tried.status}`).trim().split('\n')[0];
}

export function in_own_network() {
  return process.env[inside_variable] === '1';
}

/** Runs this command again in a network namespace of its own; returns its exit code. */
export function again_in_own_network() {
  const command = [process.execPath, ...process.execArgv, ...process.argv.slice(1)];
  const result = spawnSync('unshare', ['--net', 'sh', '-c', 'ip link set lo up && exec "$@"', 'sh', ...command], {
    stdio: 'inherit',
    env: { ...process.env, [inside_variable]: '1' },
  });
  return result.status ?? 1;
}

export function begin_netem({ delay_ms, loss_percent }) {
  execFileSync('tc', ['qdisc', 'replace', 'dev', 'lo', 'root', 'netem', 'delay', `${delay_ms}ms`, `${Math.ceil(delay_ms / 2)}ms`, 'loss', `${loss_percent}%`], { stdio: 'pipe' });
  return end_netem;
}

export function end_netem() {
  spawnSync('tc', ['qdisc', 'del', 'dev', 'lo', 'root'], { stdio: 'pipe' });
}
