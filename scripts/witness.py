"""Measures whether the machine is suspended: one thread per CPU repeatedly sleeps 10 ms, with the highest priority if
permitted (as root a tested program cannot delay the thread then; only a host that withdraws the CPU can)."""

import os
import threading
import time

PERIOD_S = 0.010
LATE_S = 0.020


class Witness:
    """Records when a CPU did not run: (cpu, from, until), by time.monotonic()."""

    def __init__(self):
        self.stills = []
        for cpu in sorted(os.sched_getaffinity(0)):
            threading.Thread(target=self._watch, args=(cpu,), daemon=True).start()

    def _watch(self, cpu):
        # Each of these calls affects this thread only.
        os.sched_setaffinity(0, {cpu})
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        except OSError:
            pass  # then a busy machine counts as suspended
        while True:
            due = time.monotonic() + PERIOD_S
            time.sleep(PERIOD_S)
            now = time.monotonic()
            if now - due > LATE_S:
                self.stills.append((cpu, due, now))

    def still_ms(self, since, until):
        """For how long of this time the machine was suspended: the maximum over the CPUs."""
        still = {}
        for cpu, begin, end in self.stills:
            still[cpu] = still.get(cpu, 0) + max(0, min(end, until) - max(begin, since))
        return 1e3 * max(still.values(), default=0)
