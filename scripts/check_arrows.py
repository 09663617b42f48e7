#!/usr/bin/env python3
"""The dependencies between modules: every #include in src/ must be declared in the module's link list.

Reads the cosiva_module(...) calls of src/**/CMakeLists.txt and every #include of src/, and fails on
  - an include of a module that the including module's list does not name (indirect declarations do not count), and on a
    declared target that no file includes;
  - an include of a header that its module does not declare public (HEADERS), and on a public header that does not exist;
  - a public header that includes a module declared only PRIVATE;
  - an include that is not written "cosiva/<module>/x.h";
  - a library's header (simdjson, toml++, mosquitto, Boost, CLI11) where the list does not name the library;
  - links set without cosiva_module, cycles, and an include of src/app from outside it;
  - a dependency, direct or not, between the physical and the virtual side: their common modules are zone, aiv and wire.
Tests may also use the modules in TEST, and include any header of another module. --self-test checks small bad trees, each
of which must fail.
"""

import pathlib
import re
import sys
from dataclasses import dataclass, field

import checker

CALL = re.compile(r"\bcosiva_module\(([^)]*)\)", re.DOTALL)
PREFIX = "cosiva/"
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
# Headers of libraries that only modules which declare them may include.
LIBRARIES = {
    "simdjson": "simdjson::simdjson",
    "toml++": "tomlplusplus::tomlplusplus",
    "mosquitto": "${MOSQUITTO_LIBRARY}",
    "boost": "Boost::headers",
    "curl": "CURL::libcurl",
    "zip": "PkgConfig::LIBZIP",
    "CLI": "CLI11::CLI11",
    "Eigen": "Eigen3::Eigen",
    "sqlite3": "SQLite::SQLite3",
    "apriltag": "${APRILTAG_LIBRARY}",
    "pugixml.hpp": "pugixml::pugixml",
    "librsvg": "PkgConfig::LIBRSVG",
}
SIDES = ("physical", "virtual")


@dataclass
class Module:
    name: str
    headers: list = field(default_factory=list)
    excepted: list = field(default_factory=list)  # plugins: other libraries of the same folder
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
        own = "cosiva_" + folder.replace("/", "_")
        if re.search(rf"\btarget_(link_libraries|include_directories)\(\s*{own}\b", text):
            problems.append(f"{path}: links are declared in cosiva_module(...) and nowhere else")
        for call in calls:
            words = call.split()
            module = Module(words[0])
            if module.name != folder:
                problems.append(f"{path}: declares the module {module.name}, but is in {folder}")
            scope = None
            for word in words[1:]:
                if word in module.links or word in ("HEADERS", "EXCEPT"):
                    scope = word
                elif scope is None:
                    problems.append(f"{path}: '{word}' is neither HEADERS, EXCEPT, PUBLIC, PRIVATE nor TEST")
                elif scope == "HEADERS":
                    module.headers.append(word)
                    if not (path.parent / word).exists():
                        problems.append(f"{path}: the public header {word} does not exist")
                elif scope == "EXCEPT":
                    module.excepted.append(word)
                else:
                    module.links[scope].append(word)
            modules[module.name] = module
        if not calls and any(path.parent.glob("*.cpp")):
            problems.append(f"{path}: has sources, but no cosiva_module(...)")
    return modules


def owner(modules, file):
    """The module that a file of src/ belongs to: its folder, or the nearest one above it that is a module."""
    return next((str(folder) for folder in pathlib.PurePosixPath(file).parents if str(folder) in modules), None)


def in_app(module):
    return module.split("/")[0] == "app"


def reach(modules, start, scopes=("PUBLIC", "PRIVATE")):
    """All modules reachable from `start`, with the path to each."""
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
        for scope, targets in module.links.items():
            for target in targets:
                if in_app(target) and not in_app(name) and scope != "TEST":
                    problems.append(f"{name}: only app may use {target}")
                elif "::" not in target and "$" not in target and target not in modules:
                    problems.append(f"{name}: {scope} names {target}, which is not a module")
        ways = reach(modules, name)
        for target in [t for t in module.links["PUBLIC"] + module.links["PRIVATE"] if t in modules]:
            back = reach(modules, target).get(name)
            if back:
                problems.append(f"{name}: is part of a cycle: {' -> '.join([name] + back)}")
        side = name.split("/")[0]
        for other in SIDES:
            if side in SIDES and side != other:
                for target, way in ways.items():
                    if target.split("/")[0] == other:
                        problems.append(f"{name}: {side} must not reach {other}: {' -> '.join(way)}")


def is_test(file):
    """Tests and their utilities: x_test.cpp, test_x.h, x_fixture.h, testing/."""
    return bool(re.search(r"(^|/)test_[^/]*$|_test\.cpp$|_fixture\.(h|cpp)$|(^|/)testing/", file))


def check_includes(src, modules, problems):
    files = sorted([*src.rglob("*.h"), *src.rglob("*.cpp")])
    includes = {}
    for path in files:
        text = path.read_text()
        found = [(m.group(1), m.group(2), text.count("\n", 0, m.start()) + 1) for m in INCLUDE.finditer(text)]
        includes[path.relative_to(src).as_posix()] = found

    public = {f"{name}/{header}" for name, module in modules.items() for header in module.headers}
    used = {name: set() for name in modules}
    for file, found in includes.items():
        here = owner(modules, file)
        if here is None:
            problems.append(f"{file}: belongs to no module")
            continue
        module = modules[here]
        if file.rpartition("/")[2] in module.excepted:
            continue
        test = is_test(file) and not here.endswith("testing")
        allowed = module.may_include(test)
        for target, library, line in found:
            where = f"{file}:{line}"
            first = (target or library).split("/")[0].removesuffix(".h")
            if first in LIBRARIES:
                used[here].add(LIBRARIES[first])
                if LIBRARIES[first] not in allowed:
                    problems.append(f"{where}: uses {first}, but {here} does not declare {LIBRARIES[first]}")
                continue
            if target is None:
                continue
            if not target.startswith(PREFIX) or target.removeprefix(PREFIX) not in includes:
                problems.append(f'{where}: "{target}" is not a "cosiva/<module>/x.h" of src/ (libraries are included with <>)')
                continue
            target = target.removeprefix(PREFIX)
            there = owner(modules, target)
            used[here].add(there)
            if there not in allowed:
                problems.append(f"{where}: {here} includes {target}, but does not declare {there}")
            elif there != here and not test and target not in public:
                problems.append(f"{where}: {target} is not among the public headers (HEADERS) of {there}")
            elif there == here and not test and file in public and target not in public:
                problems.append(f"{where}: the public header {file} includes {target}, which is not public")
            elif not test and file in public and there != here and there not in module.links["PUBLIC"]:
                problems.append(f"{where}: this header is public, therefore {here} must declare {there} PUBLIC")
    for name, module in modules.items():
        for target in [t for scope in module.links.values() for t in scope if t in modules and t not in used[name]]:
            problems.append(f"{name}: declares {target}, which no file of it includes")


def check(root):
    src = pathlib.Path(root) / "src"
    problems = []
    modules = read_modules(src, problems)
    check_graph(modules, problems)
    check_includes(src, modules, problems)
    return modules, problems


# ---- self-test -------------------------------------------------------------------------------------------------------

GOOD = {
    "base/CMakeLists.txt": "cosiva_module(base HEADERS a.h)",
    "base/a.h": "",
    "base/hidden.h": "",
    "base/a.cpp": '#include "cosiva/base/hidden.h"',
    "zone/circuit/CMakeLists.txt":
        "cosiva_module(zone/circuit HEADERS z.h PUBLIC base PRIVATE simdjson::simdjson TEST zone/testing)",
    "zone/circuit/z.h": '#include "cosiva/base/a.h"\n#include <vector>',
    "zone/circuit/z.cpp": '#include "cosiva/zone/circuit/z.h"\n#include <simdjson.h>',
    "zone/circuit/z_test.cpp": '#include "cosiva/zone/testing/test_zones.h"',
    "zone/testing/CMakeLists.txt": "cosiva_module(zone/testing HEADERS test_zones.h PUBLIC wire)",
    "zone/testing/test_zones.h": '#include "cosiva/wire/w.h"',
    "wire/CMakeLists.txt":
        "cosiva_module(wire HEADERS w.h PUBLIC  # what a comment says, (is not read)\n zone/circuit)",
    "wire/w.h": '#include "cosiva/zone/circuit/z.h"',
    "physical/plant/CMakeLists.txt": "cosiva_module(physical/plant HEADERS p.h PUBLIC wire)",
    "physical/plant/p.h": '#include "cosiva/wire/w.h"',
    "virtual/server/CMakeLists.txt": "cosiva_module(virtual/server HEADERS s.h PUBLIC wire)",
    "virtual/server/s.h": '#include "cosiva/wire/w.h"',
    "app/gvs/CMakeLists.txt": "cosiva_module(app/gvs EXCEPT plugin.cpp HEADERS g.h)\n"
        "add_library(cosiva_plugin MODULE plugin.cpp)\ntarget_link_libraries(cosiva_plugin opencv)",
    "app/gvs/g.h": "",
    "app/gvs/plugin.cpp": '#include "opencv.h"',
    "app/CMakeLists.txt": "cosiva_module(app PRIVATE app/gvs physical/plant virtual/server CLI11::CLI11)\n"
        "add_executable(cosiva main.cpp)\ntarget_link_libraries(cosiva cosiva_app)",
    "app/c.cpp": '#include "cosiva/physical/plant/p.h"\n#include "cosiva/virtual/server/s.h"\n#include <CLI/CLI.hpp>\n'
        '#include "cosiva/app/gvs/g.h"',
}
# Changes of the good tree, and a part of the expected message.
BAD = [
    ({"zone/circuit/z.cpp": '#include "cosiva/wire/w.h"'}, "does not declare wire"),
    # Reached through wire, not declared.
    ({"physical/plant/p.h": '#include "cosiva/zone/circuit/z.h"'}, "does not declare zone/circuit"),
    ({"zone/circuit/z.h": '#include "base/a.h"'}, 'is not a "cosiva/<module>/x.h"'),
    ({"zone/circuit/z.cpp": '#include "z.h"'}, 'is not a "cosiva/<module>/x.h"'),
    ({"zone/circuit/z.cpp": '#include "cosiva/base/hidden.h"'}, "is not among the public headers"),
    ({"base/a.h": '#include "cosiva/base/hidden.h"'}, "which is not public"),
    ({"base/CMakeLists.txt": "cosiva_module(base HEADERS a.h gone.h)"}, "the public header gone.h does not exist"),
    ({"virtual/server/s.h": ""}, "declares wire, which no file of it includes"),
    ({"base/b.cpp": "#include <simdjson.h>"}, "does not declare simdjson::simdjson"),
    ({"wire/w.h": "#include <boost/asio.hpp>"}, "does not declare Boost::headers"),
    ({"virtual/server/s.h": '#include "cosiva/physical/plant/p.h"'}, "does not declare physical/plant"),
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
    ({"base/CMakeLists.txt": "cosiva_module(base PRIVATE zone/circuit)"}, "is part of a cycle"),
    (
        {"zone/circuit/CMakeLists.txt": "cosiva_module(zone/circuit HEADERS z.h PRIVATE base simdjson::simdjson)"},
        "declare base PUBLIC",
    ),
    (
        {"zone/circuit/CMakeLists.txt": "cosiva_module(zone/circuit PUBLIC base nowhere TEST wire)"},
        "which is not a module",
    ),
    (
        {
            "wire/CMakeLists.txt": "cosiva_module(wire HEADERS w.h PUBLIC zone/circuit PRIVATE app/gvs)",
            "wire/w.cpp": '#include "cosiva/app/gvs/g.h"',
        },
        "only app may use app/gvs",
    ),
    ({"wire/w.h": '#include "cosiva/zone/gone.h"'}, 'is not a "cosiva/<module>/x.h"'),
    (
        {"wire/CMakeLists.txt": "cosiva_module(wire PUBLIC zone/circuit)\ntarget_link_libraries(cosiva_wire app)"},
        "nowhere else",
    ),
    ({"lost/l.cpp": ""}, "belongs to no module"),
    ({"app/CMakeLists.txt": "add_executable(cosiva c.cpp)"}, "has sources, but no cosiva_module"),
]


if __name__ == "__main__":
    sys.exit(checker.main("arrows", __doc__, "modules", check, GOOD, BAD, under="src"))
