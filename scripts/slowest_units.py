#!/usr/bin/env python3
"""Names the units that took the compiler longest, and fails when one took too long.

    scripts/slowest_units.py [--since FILE] [--limit SECONDS] BUILD…

cmake/compile writes beside every object how many seconds of the processor it took (what ccache knew already took none). A
unit over the limit keeps one core busy while the others have nothing left to do, and whoever edits it waits for it: split
it, or keep the templates that cost it in one source. --since: only what was compiled after that file was written."""

import argparse
import pathlib
import re
import sys

SECONDS = re.compile(r"(\d+)m([\d.]+)s")
SHOWN = 10


def seconds_in(text):
    """The children's time, as the shell's `times` writes it: the shell's own on one line, its children's on the next."""
    return sum(60 * int(minutes) + float(seconds) for minutes, seconds in SECONDS.findall(text.splitlines()[1]))


def slowest(builds, since):
    """Seconds and the name of each unit compiled since then, slowest first."""
    taken = []
    for build in builds:
        for file in build.rglob("*.cpu"):
            if file.stat().st_mtime >= since:
                taken.append((seconds_in(file.read_text()), str(file.relative_to(build.parent)).removesuffix(".o.cpu")))
    return sorted(taken, reverse=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--since", type=pathlib.Path)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of the processor that one unit may take")
    parser.add_argument("builds", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    units = slowest(arguments.builds, arguments.since.stat().st_mtime if arguments.since else 0.0)
    for seconds, name in units[:SHOWN]:
        print(f"{seconds:6.1f} CPU-s  {name}")
    print(f"{len(units)} units compiled, {sum(seconds for seconds, _ in units):.0f} CPU-s in all")
    over = [name for seconds, name in units if seconds > arguments.limit]
    if over:
        print(f"over {arguments.limit:g} CPU-s: {', '.join(over)}")
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())
