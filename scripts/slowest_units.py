#!/usr/bin/env python3
"""Lists the units with the longest compile times, and fails if one takes too large a share of them all.

    scripts/slowest_units.py [--since FILE] [--share RATIO] BUILD…

cmake/compile writes the processor seconds of every object to a file next to it (almost none if ccache had the result). A
unit with a large share keeps one core busy while the others are idle, and delays every edit: split the unit, or concentrate
the expensive templates in one source. A share does not depend on the machine, as seconds would. It is judged where most of
the the builds' units were compiled. --since: only units compiled after that file was written."""

import argparse
import pathlib
import re
import sys

SECONDS = re.compile(r"(\d+)m([\d.]+)s")
SHOWN = 10
COMPILED_S = 0.5  # ccache copies an object in less


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


def over(units, count, share):
    """The names of the units with a larger share of the time, if most of the builds' `count` units were compiled; else none."""
    compiled = sum(seconds >= COMPILED_S for seconds, _ in units)
    total = sum(seconds for seconds, _ in units)
    return [name for seconds, name in units if seconds > share * total] if 2 * compiled > count else []


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--since", type=pathlib.Path)
    parser.add_argument("--share", type=float, default=0.03, help="of the processor time of all units, that one may take")
    parser.add_argument("builds", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    units = slowest(arguments.builds, arguments.since.stat().st_mtime if arguments.since else 0.0)
    total = sum(seconds for seconds, _ in units)
    for seconds, name in units[:SHOWN]:
        print(f"{seconds:6.1f} CPU-s  {seconds / max(total, seconds, 1e-9):5.1%}  {name}")
    print(f"{len(units)} units compiled, {total:.0f} CPU-s in all")
    slow = over(units, len(slowest(arguments.builds, 0.0)), arguments.share)
    if slow:
        print(f"over {arguments.share:.1%} of the time: {', '.join(slow)}")
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
