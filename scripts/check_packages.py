#!/usr/bin/env python3
"""The npm lock files of web/ and e2e/ are complete, so that `npm ci` can install from them.

A registry that does not serve an optional package (another operating system's build of a bundler) makes `npm install`
write a lock file without that package; `npm ci` refuses such a file on every machine. No network is needed:
  - the first entry of package-lock.json repeats the dependencies of package.json;
  - every dependency of a locked package, including optional ones, is locked too;
  - packages pinned by `overrides` are locked at that version;
  - every locked package has an integrity value, and names no registry but the public default.
With --self-test the check evaluates small good and bad folders.
"""

import json
import sys

import checker

FOLDERS = ("web", "e2e")
REGISTRY = "https://registry.npmjs.org/"
ASKED = ("dependencies", "devDependencies", "optionalDependencies")


def found_from(packages, path, name):
    """Where Node finds `name` from the package at `path`: in its folder, then in every folder above; None if nowhere."""
    while True:
        candidate = f"{path}/node_modules/{name}" if path else f"node_modules/{name}"
        if candidate in packages:
            return candidate
        if not path:
            return None
        path = path.rpartition("node_modules/")[0].rstrip("/")


def needed(path, package):
    """The names that must be locked for the package at `path`; only the root's development packages are installed."""
    kinds = ASKED if path == "" else ("dependencies", "optionalDependencies")
    names = {name for kind in kinds for name in package.get(kind, {})}
    optional_peers = {name for name, meta in package.get("peerDependenciesMeta", {}).items() if meta.get("optional")}
    return sorted(names | (package.get("peerDependencies", {}).keys() - optional_peers))


def check_folder(root, folder, problems):
    wanted = json.loads((root / folder / "package.json").read_text())
    packages = json.loads((root / folder / "package-lock.json").read_text()).get("packages", {})
    where = f"{folder}/package-lock.json"
    for kind in ASKED:
        if wanted.get(kind, {}) != packages.get("", {}).get(kind, {}):
            problems.append(f"{where}: its {kind} are not those of package.json")
    for path, package in packages.items():
        for name in needed(path, package):
            if found_from(packages, path, name) is None:
                problems.append(f"{where}: lacks {name}, which {path or 'package.json'} depends on")
        if path == "":
            continue
        name = path.rpartition("node_modules/")[2]
        pinned = wanted.get("overrides", {}).get(name)
        if pinned is not None and package.get("version") != pinned:
            problems.append(f"{where}: {path} is {package.get('version')}, overrides pins {pinned}")
        if not package.get("integrity"):
            problems.append(f"{where}: {path} has no integrity value")
        if not package.get("resolved", REGISTRY).startswith(REGISTRY):
            problems.append(f"{where}: {path} names another registry than the public default")
    return len(packages)


def check(root):
    problems = []
    count = sum(check_folder(root, folder, problems) for folder in FOLDERS)
    return count, problems


# ---- self-test -------------------------------------------------------------------------------------------------------

PACKAGE = {"dependencies": {"a": "1.0.0"}, "devDependencies": {"b": "2.0.0"}, "overrides": {"c": "3.0.0"}}
LOCKED = {"version": "1.0.0", "integrity": "sha512-x"}
LOCK = {
    "": {"dependencies": {"a": "1.0.0"}, "devDependencies": {"b": "2.0.0"}},
    "node_modules/a": LOCKED | {"optionalDependencies": {"c": "^3.0.0"}, "devDependencies": {"not-installed": "1"}},
    "node_modules/b": LOCKED | {
        "dependencies": {"a": "*", "d": "1"},
        "peerDependencies": {"a": "*", "sass": "*"},
        "peerDependenciesMeta": {"sass": {"optional": True}},
    },
    "node_modules/b/node_modules/d": LOCKED | {"dependencies": {"a": "*"}, "resolved": f"{REGISTRY}d/-/d-1.tgz"},
    "node_modules/c": LOCKED | {"version": "3.0.0"},
}


def folder_files(folder, package, lock):
    return {f"{folder}/package.json": json.dumps(package), f"{folder}/package-lock.json": json.dumps({"packages": lock})}


def web_with(path, entry):
    """The good web/ with one entry of its lock file replaced, or removed if `entry` is None."""
    lock = LOCK | {path: entry}
    return folder_files("web", PACKAGE, {name: package for name, package in lock.items() if package is not None})


GOOD = folder_files("web", PACKAGE, LOCK) | folder_files("e2e", {}, {"": {}})
BAD = [
    (web_with("node_modules/c", None), "web/package-lock.json: lacks c, which node_modules/a depends on"),
    (web_with("node_modules/b/node_modules/d", None), "lacks d, which node_modules/b depends on"),
    (web_with("node_modules/b", LOCK["node_modules/b"] | {"peerDependencies": {"less": "*"}}), "lacks less"),
    (web_with("node_modules/b", None), "lacks b, which package.json depends on"),
    (web_with("", {"dependencies": {"a": "1.0.1"}}), "its dependencies are not those of package.json"),
    (web_with("node_modules/c", LOCKED | {"version": "3.0.1"}), "node_modules/c is 3.0.1, overrides pins 3.0.0"),
    (web_with("node_modules/c", {"version": "3.0.0"}), "node_modules/c has no integrity value"),
    (web_with("node_modules/a", LOCKED | {"resolved": "https://mirror.example/a.tgz"}), "names another registry"),
    (folder_files("e2e", {"dependencies": {"mqtt": "5.9.1"}}, {"": {}}), "e2e/package-lock.json: its dependencies"),
]


if __name__ == "__main__":
    sys.exit(checker.main("packages", __doc__, "locked packages", check, GOOD, BAD))
