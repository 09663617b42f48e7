// Who tells whether the machine runs (witness.py), and what it told.
import { spawn } from 'node:child_process';
import path from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';

const program = path.join(path.dirname(fileURLToPath(import.meta.url)), 'witness.py');

export class Witness {
  constructor() {
    this.reset();
    this.child = spawn('python3', [program], { stdio: ['pipe', 'pipe', 'inherit'] });
    // Where it does not start, or is gone, a machine counts as one that runs.
    for (const source of [this.child, this.child.stdin]) source.on('error', () => {});
    createInterface({ input: this.child.stdout }).on('line', (line) => {
      const [cpu, late_ms] = line.split(' ').map(Number);
      this.still.set(cpu, (this.still.get(cpu) ?? 0) + late_ms);
      this.longest_ms = Math.max(this.longest_ms, late_ms);
    });
  }

  /** What it told before counts no more. */
  reset() {
    this.still = new Map(); // per CPU [ms]
    this.longest_ms = 0;
  }

  /** For how long, of the CPU that stood still longest. */
  get still_ms() {
    return Math.max(0, ...this.still.values());
  }

  end() {
    this.child.stdin.end();
  }
}
