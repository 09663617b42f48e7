// Processes read from /proc: parents, children and listening ports. Independent of cosiva's own output.
import { readdirSync, readFileSync, readlinkSync } from 'node:fs';

/** @returns {{pid: number, parent: number, argv: string[], state: string}[]} */
export function all_processes() {
  const processes = [];
  for (const name of readdirSync('/proc')) {
    if (!/^\d+$/.test(name)) continue;
    try {
      const stat = readFileSync(`/proc/${name}/stat`, 'utf8');
      // The name in brackets may contain anything, brackets too: fields start after the last one.
      const [state, parent] = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
      const argv = readFileSync(`/proc/${name}/cmdline`, 'utf8').split('\0').slice(0, -1);
      processes.push({ pid: Number(name), parent: Number(parent), argv, state });
    } catch {
      // The process ended during the scan.
    }
  }
  return processes;
}

/** All processes below `pid`, children first; zombies are left out. */
export function descendants(pid) {
  const all = all_processes().filter((process) => process.state !== 'Z');
  const found = [];
  let parents = new Set([pid]);
  while (parents.size > 0) {
    const next = all.filter((process) => parents.has(process.parent));
    found.push(...next);
    parents = new Set(next.map((process) => process.pid));
  }
  return found;
}

export function alive(pid) {
  return all_processes().some((process) => process.pid === pid && process.state !== 'Z');
}

/** Whether the process was there to receive the signal: it may end at any time. */
export function send_signal(pid, signal) {
  try {
    process.kill(pid, signal);
    return true;
  } catch (error) {
    if (error.code !== 'ESRCH') throw error;
    return false;
  }
}

/** The TCP ports of IPv4 loopback on which a process listens. */
export function listening_ports(pid) {
  const inodes = new Set();
  for (const fd of readdirSync(`/proc/${pid}/fd`)) {
    try {
      const match = /^socket:\[(\d+)\]$/.exec(readlinkSync(`/proc/${pid}/fd/${fd}`));
      if (match) inodes.add(match[1]);
    } catch {
      // Closed during the scan.
    }
  }
  const listen = '0A';
  return readFileSync('/proc/net/tcp', 'utf8')
    .split('\n')
    .slice(1)
    .map((line) => line.trim().split(/\s+/))
    .filter((fields) => fields[3] === listen && inodes.has(fields[9]))
    .map((fields) => parseInt(fields[1].split(':')[1], 16));
}
