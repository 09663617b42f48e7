// The disk of the store: a small tmpfs where mounting is permitted; otherwise an ordinary folder, and RLIMIT_FSIZE of the
// running server instead of a full disk.
import { execFile, execFileSync } from 'node:child_process';
import { closeSync, mkdirSync, openSync, rmSync, statfsSync, writeSync } from 'node:fs';
import path from 'node:path';
import { promisify } from 'node:util';

function runs(command, args) {
  try {
    execFileSync(command, args, { stdio: 'pipe' });
    return true;
  } catch {
    return false;
  }
}

export class SmallDisk {
  /** @param limit_of_server  () => pid of the running server, for the fallback */
  static make(folder, megabytes, limit_of_server) {
    const disk = new SmallDisk();
    mkdirSync(folder, { recursive: true });
    Object.assign(disk, { folder, limit_of_server, full: false });
    disk.mounted = runs('mount', ['-t', 'tmpfs', '-o', `size=${megabytes}M,mode=0700`, 'tmpfs', folder]);
    disk.limits = !disk.mounted && runs('prlimit', ['--version']);
    disk.kind = disk.mounted ? `tmpfs of ${megabytes} MB` : disk.limits ? 'RLIMIT_FSIZE of the server (no permission to mount)' : 'none (neither mount nor prlimit)';
    return disk;
  }

  get can_fill() {
    return this.mounted || this.limits;
  }

  free_bytes() {
    const { bavail, bsize } = statfsSync(this.folder);
    return bavail * bsize;
  }

  /** Leaves no block free. */
  async fill() {
    this.full = true;
    if (!this.mounted) return runs('prlimit', ['--pid', String(this.limit_of_server()), '--fsize=1:']);
    // The bulk by another process, since on a busy machine it takes long; the rest by writing, until the disk refuses.
    const filler = path.join(this.folder, 'filler');
    await promisify(execFile)('fallocate', ['-l', String(Math.max(4096, this.free_bytes() - (1 << 20))), filler]).catch(() => {});
    if (!this.full) return this.free();
    const file = openSync(filler, 'a');
    const block = Buffer.alloc(1 << 20);
    for (let bytes = block.length; bytes >= 512; ) {
      try {
        if (writeSync(file, block, 0, bytes) < bytes) bytes >>= 1;
      } catch (error) {
        if (error.code !== 'ENOSPC') throw error;
        bytes >>= 1;
      }
    }
    closeSync(file);
    return true;
  }

  free() {
    this.full = false;
    if (this.mounted) return rmSync(path.join(this.folder, 'filler'), { force: true });
    const pid = this.limit_of_server();
    if (pid) runs('prlimit', ['--pid', String(pid), '--fsize=unlimited:']);
  }

  remove() {
    if (!this.mounted) return;
    if (!runs('umount', [this.folder])) runs('umount', ['-l', this.folder]);
  }
}
