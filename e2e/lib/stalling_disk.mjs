// A disk that blocks: a program started with this environment waits in fdatasync() and fsync() while a file exists.
import { execFileSync } from 'node:child_process';
import { rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

const source = String.raw`
#include <cstdlib>
#include <sys/syscall.h>
#include <unistd.h>
namespace {
int after_stall(long call, int file) {
  while (::access(std::getenv("STALL_FILE"), F_OK) == 0) ::usleep(5000);
  return static_cast<int>(::syscall(call, file));
}
}  // namespace
extern "C" int fdatasync(int file) { return after_stall(SYS_fdatasync, file); }
extern "C" int fsync(int file) { return after_stall(SYS_fsync, file); }
`;

export class StallingDisk {
  constructor(folder) {
    this.file = path.join(folder, 'stall');
    const library = path.join(folder, 'stalling_disk.so');
    writeFileSync(path.join(folder, 'stalling_disk.cpp'), source);
    execFileSync('c++', ['-shared', '-fPIC', '-O1', '-o', library, path.join(folder, 'stalling_disk.cpp')]);
    this.env = { LD_PRELOAD: library, STALL_FILE: this.file };
  }

  begin() {
    writeFileSync(this.file, '');
    this.began_ms = Date.now();
  }

  /** Returns for how long it was stalled [ms]. */
  end() {
    rmSync(this.file);
    return Date.now() - this.began_ms;
  }
}
