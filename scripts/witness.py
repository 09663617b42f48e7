"""Witnesses whether the machine runs: one thread per CPU sleeps 10 ms again and again, before everything else where it may
(as root: nothing that a tested program does makes it late then; a host that takes the CPU away does)."""

import os
import threading
import time

PERIOD_S = 0.010
LATE_S = 0.020


class Witness:
    """Remembers when a CPU did not run: (cpu, from, until), by time.monotonic()."""

    def __init__(self):
        self.stills = []
        for cpu in sorted(os.sched_getaffinity(0)):
            threading.Thread(target=self._watch, args=(cpu,), daemon=True).start()

    def _watch(self, cpu):
        # Each of these is for this thread alone.
        os.sched_setaffinity(0, {cpu})
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        except OSError:
            pass  # then a busy machine counts as one that stands still
        while True:
            due = time.monotonic() + PERIOD_S
            time.sleep(PERIOD_S)
            now = time.monotonic()
            if now - due > LATE_S:
                self.stills.append((cpu, due, now))

    def still_ms(self, since, until):
        """For how long of this time it stood still: that CPU which did so longest."""
        still = {}
        for cpu, begin, end in self.stills:
            still[cpu] = still.get(cpu, 0) + max(0, min(end, until) - max(begin, since))
        return 1e3 * max(still.values(), default=0)
