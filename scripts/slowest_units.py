#!/usr/bin/env python3
"""Lists the units with the longest compile times, and fails if one took too long.

    scripts/slowest_units.py [--since FILE] [--limit SECONDS] BUILD…

cmake/compile writes the processor seconds of every object to a file next to it (none if ccache had the result). A unit
over the limit keeps one core busy while the others are idle, and delays every edit: split the unit, or concentrate the
expensive templates in one source. --since: only units compiled after that file was written."""

import argparse
import pathlib
import re
import sys

SECONDS = re.compile(r"(\d+)m([\d.]+)s")
SHOWN = 10


def seconds_in(text):
    """The children's time, as printed by the shell's `times`: the shell's own on one line, its children's on the next."""
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
    parser.add_argument("--limit", type=float, default=60.0, help="processor seconds that one unit may take")
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
