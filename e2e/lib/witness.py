"""Witnesses whether the machine runs: one thread per CPU sleeps 10 ms again and again, before everything else where it may
(as root: nothing that the tested program does makes it late then; a host that takes the CPU away does), and prints
"cpu milliseconds" each time it wakes 20 ms late or more. Ends when its standard input does."""
import os
import sys
import threading
import time

PERIOD_S = 0.010
LATE_S = 0.020


def watch(cpu):
    os.sched_setaffinity(0, {cpu})
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError:
        pass  # then a busy machine counts as one that stands still
    while True:
        due = time.monotonic() + PERIOD_S
        time.sleep(PERIOD_S)
        late = time.monotonic() - due
        if late > LATE_S:
            os.write(1, f"{cpu} {1e3 * late:.0f}\n".encode())


for cpu in sorted(os.sched_getaffinity(0)):
    threading.Thread(target=watch, args=(cpu,), daemon=True).start()
sys.stdin.read()
