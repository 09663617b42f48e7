#!/usr/bin/env python3
"""Runs clang-tidy over our sources, and only over those that changed since they last passed.

What passed is remembered, for every checkout of this user, by a hash of all that clang-tidy could see: the file, our
headers it reaches, its compile command, the .clang-tidy files and clang-tidy's version. It lies where ccache's memory does,
in $XDG_CACHE_HOME (~/.cache). Needs a compile_commands.json (--build).
Tests are left out unless asked for (--tests): they take longer than all the rest, and the compiler is strict with them.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(rb'^[ \t]*#[ \t]*include[ \t]+"([^"]+)"', re.MULTILINE)
OURS = ("src", "bench", "fuzz", "e2e")
month_s = 30 * 24 * 3600


def reached(path, seen):
    """The file and every header of ours that it includes, directly or not."""
    if path in seen or not path.is_file():
        return
    seen[path] = path.read_bytes()
    for name in INCLUDE.findall(seen[path]):
        for folder in (ROOT / "src", path.parent):
            reached(folder / name.decode(), seen)


def command_of(entry):
    """The compile command without what only the compiler that built it understands: its precompiled headers."""
    words, out = shlex.split(entry["command"]), []
    skip = False
    for index, word in enumerate(words):
        if skip:
            skip = False
        elif word == "-include" and "cmake_pch" in words[index + 1]:
            skip = True
        elif word not in ("-Winvalid-pch", "-fpch-preprocess"):
            out.append(word)
    return out


def tasks_from(build, version):
    base = hashlib.sha256(version)
    for config in sorted(ROOT.glob("**/.clang-tidy")):
        if "node_modules" not in config.parts and "build" not in config.relative_to(ROOT).parts:
            base.update(config.read_bytes())
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        path = pathlib.Path(entry["file"])
        if path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0] in OURS and "node_modules" not in path.parts:
            found.setdefault(path, entry)
    for path, entry in sorted(found.items()):
        command = command_of(entry)
        digest = base.copy()
        # The same in every checkout: what lies where is told by the names of what was reached.
        digest.update("\0".join(command).replace(str(ROOT), "").encode())
        seen = {}
        reached(path, seen)
        for header in sorted(seen):
            digest.update(b"\0" + str(header.relative_to(ROOT)).encode() + b"\0" + seen[header])
        yield path, dict(entry, command=shlex.join(command)), digest.hexdigest()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--all", action="store_true", help="also what passed before")
    parser.add_argument("--tests", action="store_true", help="also *_test.cpp")
    parser.add_argument("only", nargs="*", help="only files whose path contains one of these")
    arguments = parser.parse_args()

    version = subprocess.run(["clang-tidy", "--version"], capture_output=True, check=True).stdout
    home = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache")
    cache = home / "cosiva/tidy"
    cache.mkdir(parents=True, exist_ok=True)
    for old in cache.iterdir():
        if time.time() - old.stat().st_mtime > month_s:
            old.unlink()
    tasks = list(tasks_from(arguments.build, version))
    if not arguments.tests:
        tasks = [t for t in tasks if not t[0].name.endswith("_test.cpp")]
    if arguments.only:
        tasks = [t for t in tasks if any(part in str(t[0].relative_to(ROOT)) for part in arguments.only)]
    todo = [t for t in tasks if arguments.all or not (cache / t[2]).exists()]

    # clang-tidy reads the commands as we cleaned them, from a database of our own.
    database = ROOT / "build/tidy-commands"
    database.mkdir(parents=True, exist_ok=True)
    (database / "compile_commands.json").write_text(json.dumps([entry for _, entry, _ in tasks]))

    def tidy(task):
        path, _, digest = task
        run = subprocess.run(["clang-tidy", "--quiet", "-p", str(database), str(path)], capture_output=True, text=True)
        if run.returncode == 0:
            (cache / digest).touch()
        return path, run

    start, failed = time.monotonic(), 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for path, run in pool.map(tidy, todo):
            if run.returncode != 0:
                failed += 1
                print(f"--- {path.relative_to(ROOT)}\n{run.stdout.strip()}")
                if "error:" not in run.stdout:
                    print(run.stderr.strip())
    seconds = time.monotonic() - start
    print(f"tidy: {len(tasks)} files, {len(todo)} looked at in {seconds:.0f} s, {failed} with findings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
