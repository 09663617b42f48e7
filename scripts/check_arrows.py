#!/usr/bin/env python3
"""The arrows between folders: every #include in src/ must be declared in the folder's link list.

Reads the cosiva_module(...) calls of src/**/CMakeLists.txt and every #include "..." of src/, and fails on
  - an include of a module that the including folder's list does not name (a list of lists is not enough: what a file
    includes, its folder declares);
  - a header shown to others that includes what its folder declares only PRIVATE;
  - a library's header (simdjson, toml++, mosquitto, Boost, CLI11) where the list does not name the library;
  - links set behind cosiva_module's back, circles, and an include of src/app;
  - a way from the physical side to the virtual one or back, however long: they only meet in zone, aiv and wire.
Tests may also use what TEST names. With --self-test it judges small bad trees, each of which must fail.
"""

import pathlib
import re
import sys
from dataclasses import dataclass, field

import checker

CALL = re.compile(r"\bcosiva_module\(([^)]*)\)", re.DOTALL)
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
# Headers of libraries that only the folders which declare them may touch.
LIBRARIES = {
    "simdjson": "simdjson::simdjson",
    "toml++": "tomlplusplus::tomlplusplus",
    "mosquitto": "${MOSQUITTO_LIBRARY}",
    "boost": "Boost::headers",
    "CLI": "CLI11::CLI11",
    "Eigen": "Eigen3::Eigen",
    "sqlite3": "SQLite::SQLite3",
    "apriltag": "${APRILTAG_LIBRARY}",
}
SIDES = ("physical", "virtual")


@dataclass
class Module:
    name: str
    links: dict = field(default_factory=lambda: {"PUBLIC": [], "PRIVATE": [], "TEST": []})

    def may_include(self, is_test):
        scopes = ("PUBLIC", "PRIVATE", "TEST") if is_test else ("PUBLIC", "PRIVATE")
        return {target for scope in scopes for target in self.links[scope]} | {self.name}


def without_comments(text):
    return re.sub(r"#[^\n]*", "", text)


def read_modules(src, problems):
    modules = {}
    for path in sorted(src.rglob("CMakeLists.txt")):
        folder = path.parent.relative_to(src).as_posix()
        text = without_comments(path.read_text())
        calls = CALL.findall(text)
        if folder != "app" and re.search(r"\btarget_(link_libraries|include_directories)\b", text):
            problems.append(f"{path}: links are the arrows, so they go into cosiva_module(...) and nowhere else")
        for call in calls:
            words = call.split()
            module = Module(words[0])
            if module.name != folder:
                problems.append(f"{path}: declares the module {module.name}, but stands in {folder}")
            scope = None
            for word in words[1:]:
                if word in module.links:
                    scope = word
                elif scope is None:
                    problems.append(f"{path}: '{word}' is neither PUBLIC, PRIVATE nor TEST")
                else:
                    module.links[scope].append(word)
            modules[module.name] = module
        if not calls and folder != "app" and any(path.parent.glob("*.cpp")):
            problems.append(f"{path}: has sources, but no cosiva_module(...)")
    # The command is wiring: everything is open to it, and it to nobody.
    everything = [name for name in modules if name != "app"]
    modules["app"] = Module("app", {"PUBLIC": everything, "PRIVATE": list(LIBRARIES.values()), "TEST": []})
    return modules


def owner(modules, file):
    """The module that a file of src/ belongs to: its folder, or the nearest one above it that is a module."""
    return next((str(folder) for folder in pathlib.PurePosixPath(file).parents if str(folder) in modules), None)


def reach(modules, start, scopes=("PUBLIC", "PRIVATE")):
    """All modules that can be got to from `start`, with the way there."""
    ways = {start: [start]}
    todo = [start]
    while todo:
        name = todo.pop()
        for scope in scopes:
            for target in modules[name].links[scope]:
                if target in modules and target not in ways:
                    ways[target] = ways[name] + [target]
                    todo.append(target)
    return ways


def check_graph(modules, problems):
    for name, module in modules.items():
        if name == "app":
            continue
        for scope, targets in module.links.items():
            for target in targets:
                if target == "app":
                    problems.append(f"{name}: nobody may use app")
                elif "::" not in target and "$" not in target and target not in modules:
                    problems.append(f"{name}: {scope} names {target}, which is no module")
        ways = reach(modules, name)
        for target in [t for t in module.links["PUBLIC"] + module.links["PRIVATE"] if t in modules]:
            back = reach(modules, target).get(name)
            if back:
                problems.append(f"{name}: goes round in a circle: {' -> '.join([name] + back)}")
        side = name.split("/")[0]
        for other in SIDES:
            if side in SIDES and side != other:
                for target, way in ways.items():
                    if target.split("/")[0] == other:
                        problems.append(f"{name}: {side} must not reach {other}: {' -> '.join(way)}")


def is_test(file):
    """Tests, and what only tests use: thing_test.cpp, test_things.h, thing_bench.h."""
    return bool(re.search(r"(^|/)test_[^/]*$|_test\.cpp$|_bench\.(h|cpp)$", file))


def check_includes(src, modules, problems):
    files = sorted([*src.rglob("*.h"), *src.rglob("*.cpp")])
    includes = {}
    for path in files:
        text = path.read_text()
        found = [(m.group(1), m.group(2), text.count("\n", 0, m.start()) + 1) for m in INCLUDE.finditer(text)]
        includes[path.relative_to(src).as_posix()] = found

    # Headers that other folders see, directly or through another header of the same folder: their includes are public.
    shown, todo = set(), []
    for file, found in includes.items():
        if not is_test(file):
            todo += [t for t, _, _ in found if t in includes and owner(modules, t) != owner(modules, file)]
    while todo:
        file = todo.pop()
        if file not in shown:
            shown.add(file)
            todo += [t for t, _, _ in includes[file] if t in includes and owner(modules, t) == owner(modules, file)]

    for file, found in includes.items():
        here = owner(modules, file)
        if here is None:
            problems.append(f"{file}: belongs to no module")
            continue
        module = modules[here]
        allowed = module.may_include(is_test(file))
        for target, library, line in found:
            where = f"{file}:{line}"
            first = (target or library).split("/")[0].removesuffix(".h")
            if first in LIBRARIES:
                if LIBRARIES[first] not in allowed:
                    problems.append(f"{where}: uses {first}, but {here} does not declare {LIBRARIES[first]}")
                continue
            if target is None:
                continue
            there = owner(modules, target)
            if target not in includes or there is None:
                problems.append(f'{where}: "{target}" is no file of src/ (libraries go in <>)')
            elif there == "app" and here != "app":
                problems.append(f"{where}: nobody includes app")
            elif there not in allowed:
                problems.append(f"{where}: {here} includes {target}, but does not declare {there}")
            elif file in shown and there != here and here != "app" and there not in module.links["PUBLIC"]:
                problems.append(f"{where}: others see this header, so {here} must declare {there} PUBLIC")


def check(root):
    src = pathlib.Path(root) / "src"
    problems = []
    modules = read_modules(src, problems)
    check_graph(modules, problems)
    check_includes(src, modules, problems)
    return modules, problems


# ---- self-test -------------------------------------------------------------------------------------------------------

GOOD = {
    "base/CMakeLists.txt": "cosiva_module(base)",
    "base/a.h": "",
    "zone/CMakeLists.txt": "cosiva_module(zone PUBLIC base PRIVATE simdjson::simdjson TEST wire)",
    "zone/z.h": '#include "base/a.h"\n#include <vector>',
    "zone/z.cpp": '#include "zone/z.h"\n#include <simdjson.h>',
    "zone/z_test.cpp": '#include "zone/test_zones.h"',
    "zone/test_zones.h": '#include "wire/w.h"',
    "wire/CMakeLists.txt": "cosiva_module(wire PUBLIC base  # what a comment says, (is not read)\n zone)",
    "wire/w.h": '#include "zone/z.h"',
    "physical/plant/CMakeLists.txt": "cosiva_module(physical/plant PUBLIC wire)",
    "physical/plant/p.h": '#include "wire/w.h"',
    "virtual/server/CMakeLists.txt": "cosiva_module(virtual/server PUBLIC wire)",
    "virtual/server/s.h": '#include "wire/w.h"',
    "app/CMakeLists.txt": "add_executable(cosiva main.cpp)\ntarget_link_libraries(cosiva zone)",
    "app/main.cpp": '#include "physical/plant/p.h"\n#include "virtual/server/s.h"\n#include <CLI/CLI.hpp>',
}
# What is changed in the good tree, and a piece of the complaint that must follow.
BAD = [
    ({"zone/z.cpp": '#include "wire/w.h"'}, "does not declare wire"),
    ({"physical/plant/p.h": '#include "zone/z.h"'}, "does not declare zone"),  # reached through wire, not declared
    ({"base/b.cpp": "#include <simdjson.h>"}, "does not declare simdjson::simdjson"),
    ({"wire/w.h": "#include <boost/asio.hpp>"}, "does not declare Boost::headers"),
    ({"virtual/server/s.h": '#include "physical/plant/p.h"'}, "does not declare physical/plant"),
    (
        {"virtual/server/CMakeLists.txt": "cosiva_module(virtual/server PUBLIC wire physical/plant)"},
        "must not reach physical",
    ),
    (
        {
            "between/CMakeLists.txt": "cosiva_module(between PUBLIC physical/plant)",
            "virtual/server/CMakeLists.txt": "cosiva_module(virtual/server PUBLIC wire PRIVATE between)",
        },
        "virtual/server -> between -> physical/plant",
    ),
    ({"base/CMakeLists.txt": "cosiva_module(base PRIVATE zone)"}, "goes round in a circle"),
    ({"zone/CMakeLists.txt": "cosiva_module(zone PRIVATE base simdjson::simdjson TEST wire)"}, "declare base PUBLIC"),
    ({"zone/CMakeLists.txt": "cosiva_module(zone PUBLIC base nowhere TEST wire)"}, "which is no module"),
    ({"wire/w.h": '#include "app/main.h"', "app/main.h": ""}, "nobody includes app"),
    ({"wire/w.h": '#include "zone/gone.h"'}, "is no file of src/"),
    (
        {"wire/CMakeLists.txt": "cosiva_module(wire PUBLIC base zone)\ntarget_link_libraries(cosiva_wire app)"},
        "nowhere else",
    ),
    ({"lost/l.cpp": ""}, "belongs to no module"),
]


if __name__ == "__main__":
    sys.exit(checker.main("arrows", __doc__, "modules", check, GOOD, BAD, under="src"))
