#!/usr/bin/env python3
"""The sizes of modules and classes in src/, and the location of classes.

sources    A module has at most 25 .cpp files.
lines      A module has at most 4 000 lines in its .h and .cpp files.
header     x.cpp has x.h in the same folder; main.cpp and the sources of plugins (add_library(… MODULE …)) have none.
spread     The member functions of a class are defined in one .cpp, two at most.
shared     A nested class that is defined outside its class (struct Outer::Inner {…}), and any class called Inside or Impl,
           is used by one .cpp.
functions  A class has at most 25 declared member functions, without defaulted or deleted ones and friends, and without
           archive(), which lists the members of its state (scripts/check_snapshot.py).
members    A class has at most 15 data members, static ones not counted.
invariant  A class with private data and a public function that changes these states its invariant in the comment above the
           class (the word "invariant"), and one of its functions asserts with COSIVA_EXPECT. Functions of nested classes
           count. Only functions defined in a .cpp make the rule apply. The value is the number of missing parts, 1 or 2.

Tests are not counted: *_test.cpp, test_*, *_fixture.*, and all below testdata/ and testing/. Plain value structs
may have any number of members: a struct, not nested in a private section, without private section and without functions
other than operators, static and defaulted ones. They mirror a file, a message or a command line.

A module is the nearest folder above a file whose CMakeLists.txt makes a library or program. Exceptions are
listed in scripts/structure_allowed.txt, which may only shrink (scripts/ratchet.py). --write shrinks the list, --measure
rewrites it, --self-test checks small good and bad trees.
"""

import pathlib
import re
import sys
from dataclasses import dataclass, field

import ratchet
from cpp_source import Source, UnreadableSource

SOURCES_MAX, LINES_MAX, SPREAD_MAX, FUNCTIONS_MAX, MEMBERS_MAX = 25, 4000, 2, 25, 15
TEST = re.compile(r"(^|/)test_[^/]*$|_(test|fixture)\.(h|cpp)$|(^|/)(testdata|testing)/")
MAKES_TARGET = re.compile(r"^\s*(?:cosiva_module|add_library|add_executable)\(", re.MULTILINE)
PLUGIN = re.compile(r"\badd_library\(\s*\S+\s+MODULE\b([^)]*)\)")
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"(?:cosiva/)?([^"]+)"', re.MULTILINE)
ASSERTS = re.compile(r"\bCOSIVA_EXPECT\s*\(")
INVARIANT = re.compile(r"\binvariants?\b", re.IGNORECASE)

STATE_LIST = "archive"

RULES = {
    "sources": "not split into modules yet",
    "lines": "not split into modules yet",
    "header": "names no interface of its own yet",
    "spread": "not split into classes yet",
    "shared": "not split into classes yet",
    "functions": "not split into classes yet",
    "members": "not split into classes yet",
    "invariant": "invariant not stated or not asserted yet",
}
HEAD = """What scripts/check_structure.py lets pass: RULE NAME VALUE REASON. The list may only shrink (scripts/ratchet.py)."""


@dataclass
class File:
    name: str  # below src/
    module: str
    source: Source
    lines: int
    includes: set  # names below src/ that an include may mean

    @property
    def is_header(self):
        return self.name.endswith(".h")


@dataclass
class Type:
    """A class with its parts in other files."""

    name: str
    made: object
    file: File
    definitions: list = field(default_factory=list)  # (file name, Function)

    def simple_name(self):
        return self.made.name.split("::")[-1].replace("<>", "")

    def counted_functions(self):
        return [f for f in self.made.functions if not f.is_defaulted and f.name != STATE_LIST]

    def is_plain_value(self):
        functions = [f for f in self.counted_functions() if not f.is_operator and not f.is_static]
        return (
            self.made.key != "class" and self.made.access == "public" and not self.made.has_restricted_section
            and not functions
        )

    def has_private_data(self):
        return any(count for access, count in self.made.members.items() if access != "public")

    def mutators(self):
        """Public functions that may change the state and whose definition is in a .cpp."""
        defined = {f.name for _, f in self.definitions}
        return [
            f
            for f in self.counted_functions()
            if f.access == "public" and not f.is_static and not f.is_const and not f.is_operator
            and f.name.lstrip("~") != self.simple_name() and (f.name in defined or not self.file.is_header)
        ]


def read_modules(src):
    """Folders below src/ that make a library or program, and the sources of plugins."""
    modules, plugins = set(), set()
    for path in sorted(src.rglob("CMakeLists.txt")):
        text = re.sub(r"#[^\n]*", "", path.read_text())
        folder = path.parent.relative_to(src).as_posix()
        if MAKES_TARGET.search(text):
            modules.add(folder)
        for sources in PLUGIN.findall(text):
            plugins |= {f"{folder}/{name}" for name in sources.split()}
    return modules, plugins


def module_of(name, modules):
    folders = [str(folder) for folder in pathlib.PurePosixPath(name).parents]
    return next((folder for folder in folders if folder in modules), folders[0])


def read_files(src, modules, problems):
    files = []
    for path in sorted(p for p in src.rglob("*") if p.suffix in (".h", ".cpp")):
        name = path.relative_to(src).as_posix()
        if TEST.search(name):
            continue
        text = path.read_text()
        try:
            source = Source(text)
        except UnreadableSource as error:
            problems.append(f"src/{name}:{error}")
            continue
        folder, targets = name.rpartition("/")[0], INCLUDE.findall(text)
        includes = {*targets, *(f"{folder}/{target}" for target in targets)}
        files.append(File(name, module_of(name, modules), source, text.count("\n"), includes))
    return files


def read_types(files):
    """All classes, each with the functions that are defined outside of it."""
    types, by_class = {}, {}
    for file in files:
        for made in file.source.classes:
            name = f"{file.module}:{made.name}" if file.is_header else f"{file.name}:{made.name}"
            while name in types:
                name += "'"
            types[name] = Type(name, made, file)
            by_class.setdefault(made.name.replace("<>", ""), []).append(types[name])
    for file in files:
        for function in file.source.definitions:
            owner = owner_of(function, file, by_class)
            if owner:
                owner.definitions.append((file.name, function))
    return types


def owner_of(function, file, by_class):
    """The class of a definition: of this file, else of this module, else the only one of that name."""
    names = function.qualifier.split("::")
    for start in range(len(names)):
        candidates = by_class.get("::".join(names[start:]), [])
        local = [t for t in candidates if t.file is file]
        near = [t for t in candidates if t.file.module == file.module and t.file.is_header]
        for found in (local, near, [t for t in candidates if t.file.is_header]):
            if found:
                return found[0]
    return None


def measure_modules(files, plugins, found):
    names = {file.name for file in files}
    for module in {file.module for file in files}:
        own = [file for file in files if file.module == module]
        sources, lines = sum(not file.is_header for file in own), sum(file.lines for file in own)
        if sources > SOURCES_MAX:
            found["sources", module] = (sources, f"src/{module}: {sources} .cpp files, at most {SOURCES_MAX}")
        if lines > LINES_MAX:
            found["lines", module] = (lines, f"src/{module}: {lines} lines, at most {LINES_MAX}")
    for file in files:
        is_entry = file.name in plugins or file.name.endswith("/main.cpp")
        if not file.is_header and not is_entry and file.name.removesuffix(".cpp") + ".h" not in names:
            found["header", file.name] = (1, f"src/{file.name}: has no header of its name in its folder")


def users_of(type_, files):
    """The .cpp files that include the header of a nested class or define its functions."""
    including = {file.name for file in files if not file.is_header and type_.file.name in file.includes}
    return including | {name for name, _ in type_.definitions}


def measure_types(types, files, found):
    for name, type_ in types.items():
        where = f"src/{type_.file.name}:{type_.made.line}: {type_.made.name}"
        spread = {file for file, _ in type_.definitions if file.endswith(".cpp")}
        if len(spread) > SPREAD_MAX:
            found["spread", name] = (len(spread), f"{where} is defined in {len(spread)} .cpp files, at most {SPREAD_MAX}")
        if type_.file.is_header and (type_.made.out_of_line or type_.simple_name() in ("Inside", "Impl")):
            users = users_of(type_, files)
            if len(users) > 1:
                found["shared", name] = (len(users), f"{where} is shared by {len(users)} .cpp files")
        functions, members = len(type_.counted_functions()), sum(type_.made.members.values())
        if functions > FUNCTIONS_MAX:
            found["functions", name] = (functions, f"{where} has {functions} functions, at most {FUNCTIONS_MAX}")
        if members > MEMBERS_MAX and not type_.is_plain_value():
            found["members", name] = (members, f"{where} has {members} data members, at most {MEMBERS_MAX}")
        missing = missing_parts(type_, types)
        if missing:
            found["invariant", name] = (len(missing), f"{where} {' and '.join(missing)}")


def missing_parts(type_, types):
    if not type_.has_private_data() or not type_.mutators():
        return []
    own = [
        t for t in types.values()
        if t is type_ or (t.file.module == type_.file.module and t.made.name.startswith(type_.made.name + "::"))
    ]
    bodies = [f.body or "" for t in own for f in [*t.made.functions, *(d for _, d in t.definitions)]]
    missing = []
    if not any(INVARIANT.search(t.made.comment) for t in own):
        missing.append("states no invariant in the comment above it")
    if not any(ASSERTS.search(body) for body in bodies):
        missing.append("asserts nothing with COSIVA_EXPECT")
    return missing


def measure(root, problems):
    src = pathlib.Path(root) / "src"
    modules, plugins = read_modules(src)
    files = read_files(src, modules, problems)
    found = {}
    measure_modules(files, plugins, found)
    measure_types(read_types(files), files, found)
    return len(files), found


# ---- self-test -------------------------------------------------------------------------------------------------------


def class_of(functions=0, members=0, head="class Big"):
    inside = "".join(f"  void f{i}() const;\n" for i in range(functions)) + " private:\n"
    return f"{head} {{\n public:\n{inside}" + "".join(f"  int m{i}_{{}};\n" for i in range(members)) + "};"


HARD_SAMPLE = """
#include "x.h"
#define OPEN {
namespace cosiva::zone {
namespace {
constexpr auto big = 1'000'000; const char brace = '{'; const char* raw = R"x(struct Raw { int a; )" )x";
}  // namespace
enum class Kind : std::uint8_t { none, some };
using Callback = std::function<void(int)>;
template <typename T, std::size_t N = (3 > 2)>
  requires std::integral<T>
/// A comment with { and "quotes
class [[nodiscard]] Hard final : public Base<Hard<T>>, private Other {
  friend bool operator==(const Hard&, const Hard&) = default;
  friend class Friend;
  friend void swap(Hard& a, Hard& b) { std::swap(a.x_, b.x_); }
 public:
  explicit Hard(int x, std::string y = {"{"}) : Base{x}, x_{x}, y_(std::move(y)) { run(); }
  Hard(const Hard&) = delete;
  Hard& operator=(Hard&&) noexcept = default;
  virtual ~Hard() { if (x_) { x_ = 0; } }
  [[nodiscard]] std::vector<std::pair<int, double>>
      long_one(const std::map<int, std::vector<int>>& from,
               int to = 3) const;
  template <class F>
  auto apply(F&& f) -> decltype(f(1)) { return f([] { return 1; }()); }
  bool operator()(int a) const { return a < x_; }
  bool operator<(const Hard& other) const { return x_ < other.x_; }
  explicit operator bool() const { return x_ > 0; }
  static Hard make();
  virtual void pure() = 0;
  void inline_end() {};
  struct Nested { int a{}, b{}; double c{1.0}; };
  enum Colour { red, green };
  static constexpr int limit{3};
 private:
  int x_ : 3;
  std::string y_{"};"}, z_;
  std::function<int(int)> call_ = [](int v) -> int { if (v) { return 1; } return v < 2 ? 3 : 4; };
  int (*pointer_)(int, double){nullptr};
  std::array<int, (4 > 3) ? 2 : 1> array_{};
  std::unordered_map<std::string, std::function<void()>, Hash<std::string>> map_;
  struct { int inner; } unnamed_;
  mutable Base<int>& reference_;
  alignas(64) char buffer_[16];
  enum class Mode : std::uint8_t { on, off } mode_;
  Hard (Nested::*handler_)(const Kind&);
  const char* names_[2] = {"a", "b"};
};
void Hard::outside() { if (true) { } }
template <typename T> int Hard<T>::other(int x) const { return x; }
Hard::Nested Hard::returns() { return {}; }
Hard::~Hard() = default;
int free_function(int x) { return x; }
}  // namespace cosiva::zone
"""


def judge_reader():
    """Tests the reader on a sample of difficult declarations."""
    source = Source(HARD_SAMPLE)
    classes = {made.name: made for made in source.classes}
    hard = classes.get("Hard")
    if hard is None:
        return [f"the reader finds {sorted(classes)}"]
    counted = [f.name for f in hard.functions if not f.is_defaulted]
    wanted = [
        ("functions", counted, ["Hard", "~Hard", "long_one", "apply", "operator__", "operator_", "operator bool", "make",
                                "pure", "inline_end"]),
        ("defaulted", [f.name for f in hard.functions if f.is_defaulted], ["Hard", "operator_"]),
        ("const", [f.name for f in hard.functions if f.is_const],
         ["long_one", "operator__", "operator_", "operator bool"]),
        ("static", [f.name for f in hard.functions if f.is_static], ["make"]),
        ("members", hard.members, {"private": 13}),
        ("nested members", classes["Hard::Nested"].members, {"public": 3}),
        ("comment", hard.comment, ""),
        ("definitions", [(f.qualifier, f.name) for f in source.definitions],
         [("Hard", "outside"), ("Hard", "other"), ("Hard", "returns"), ("Hard", "~Hard")]),
        ("bodies", [bool(f.body) for f in source.definitions], [True, True, True, False]),
    ]
    return [f"the reader's {what}: {got}, wanted {want}" for what, got, want in wanted if got != want]


STATED = "/// Counts.\n/// Invariant: the count is not negative.\n"
COUNTER = (
    "class Counter {\n public:\n  Counter();\n  void add(int n);\n  int count() const;\n"
    " private:\n  int count_{};\n};"
)
ASSERTED = '#include "zone/counter.h"\nvoid Counter::add(int n) { COSIVA_EXPECT(n >= 0); count_ += n; }'
LIST = "scripts/structure_allowed.txt"
GOOD = {
    "src/zone/CMakeLists.txt": "cosiva_module(zone PUBLIC base)",
    "src/zone/counter.h": STATED + COUNTER,
    "src/zone/counter.cpp": ASSERTED,
    "src/zone/counter_test.cpp": class_of(40, 40) + "\n" * 5000,
    "src/zone/testing/zones.cpp": "int no_header_needed();",
    "src/zone/limits.h": class_of(25, 15),
    "src/zone/arguments.h": "struct Arguments {\n" + "int a{}, b{};\n" * 20
    + "bool operator==(const Arguments&) const = default;\n};",
    "src/zone/geometry/CMakeLists.txt": "# cosiva_module(zone)\ncosiva_module(zone/geometry)",
    "src/zone/geometry/big.h": "\n" * 3900,
    "src/app/CMakeLists.txt": "add_executable(cosiva main.cpp)\nadd_library(cosiva_mpi MODULE mpi.cpp)",
    "src/app/main.cpp": "int main() {}",
    "src/app/mpi.cpp": "",
    "src/app/old.cpp": "",
    "src/app/server.h": "class Server { public: void f(); private: struct Inside; std::unique_ptr<Inside> inside_; };",
    "src/app/server.cpp": "/// Invariant: none is lost.\nstruct Server::Inside { int x; void g() { COSIVA_EXPECT(x); } };\n"
    "void Server::f() {}",
    LIST: "# head\ncap header 1\n\nheader app/old.cpp 1 a list of free functions",
}
BAD = [
    ({f"src/zone/s{i}.{end}": "" for i in range(25) for end in ("h", "cpp")}, "src/zone: 26 .cpp files, at most 25"),
    ({"src/zone/long.h": "\n" * 4000}, "lines, at most 4000"),
    ({"src/zone/geometry/more.h": "\n" * 200}, "src/zone/geometry: 41"),
    ({"src/zone/lonely.cpp": ""}, "src/zone/lonely.cpp: has no header"),
    ({"src/zone/geometry/counter.cpp": ""}, "src/zone/geometry/counter.cpp: has no header"),  # another folder's header
    ({"src/zone/limits.h": class_of(26, 0)}, "src/zone/limits.h:1: Big has 26 functions"),
    ({"src/zone/limits.h": class_of(0, 16)}, "Big has 16 data members"),
    ({"src/zone/limits.h": class_of(0, 16, "struct Big")}, "Big has 16 data members"),  # it has a private section
    ({"src/zone/limits.h": "struct S { void f(); int " + ", ".join(f"m{i}" for i in range(16)) + "; };"}, "16 data members"),
    ({"src/zone/limits.h": "class C { struct Plan { " + "int a{};" * 16 + " }; };"}, "C::Plan has 16 data members"),
    ({f"src/zone/part{i}.{end}": f"void Counter::f{i}() {{}}" * (end == "cpp") for i in "12" for end in ("h", "cpp")},
     "Counter is defined in 3 .cpp files"),
    ({"src/app/inside.h": "struct Server::Inside { int x; };", "src/app/server.cpp": '#include "app/inside.h"',
      "src/app/old.cpp": '#include "cosiva/app/inside.h"'}, "Server::Inside is shared by 2 .cpp files"),
    ({"src/app/impl.h": "class A { class Impl { void f(); void g(); }; };", "src/app/old.cpp": "void A::Impl::f() {}",
      "src/app/server.cpp": "void A::Impl::g() {}"}, "A::Impl is shared by 2 .cpp files"),
    ({"src/zone/counter.h": COUNTER}, "Counter states no invariant"),
    ({"src/zone/counter.h": STATED + "\n" + COUNTER}, "Counter states no invariant"),  # a blank line between
    ({"src/zone/counter.cpp": "void Counter::add(int n) { count_ += n; }  // COSIVA_EXPECT(n)"}, "Counter asserts nothing"),
    ({"src/app/server.cpp": "struct Server::Inside { int x; };\nvoid Server::f() {}"},
     "states no invariant in the comment above it and asserts nothing"),
    ({"src/zone/odd.h": "struct Odd { void f( };"}, "src/zone/odd.h:1: '}' closes nothing"),
    ({"src/zone/odd.h": "struct Odd {"}, "src/zone/odd.h:1: '{' is never closed"),
    # The allow-list.
    ({LIST: ""}, "src/app/old.cpp: has no header"),
    ({LIST: "header app/old.cpp 1 a reason"}, "1 entries for header, the cap is 0"),
    ({LIST: "cap header 2\nheader app/old.cpp 1 a reason"}, "lower the cap from 2"),
    ({LIST: "cap header 1\nheader app/old.cpp 2 a reason"}, "shrink the entry from 2 to 1"),
    ({LIST: "cap header 1\nheader app/old.cpp 1"}, "an entry is RULE NAME VALUE REASON"),
    ({LIST: "cap header 1\nheader app/old.cpp 1 a\nheader app/old.cpp 1 b"}, "is listed twice"),
    ({LIST: "heder app/old.cpp 1 a reason"}, "'heder' is not a rule"),
    ({"src/app/old.h": ""}, "header app/old.cpp: the entry is no longer needed"),
    ({"src/zone/limits.h": class_of(27, 0), LIST: GOOD[LIST] + "\ncap functions 1\nfunctions zone:Big 26 a reason"},
     "Big has 27 functions, at most 25; structure_allowed.txt allows 26"),
]


def judge_rewriting():
    """--write shrinks and never adds; --measure adds and keeps the reasons, also of entries moved to another module."""
    measured = {("functions", "zone/edit:A"): (30, ""), ("functions", "zone:B"): (40, "")}
    allowed = ratchet.AllowList({("functions", "zone:A"): (31, "why"), ("functions", "zone:B"): (41, "b")}, {"functions": 2})
    shrunk = ratchet.shrunk(measured, allowed)
    anew = ratchet.measured_anew(measured, allowed, RULES)
    grown = ratchet.shrunk({("functions", "zone:B"): (50, "")}, allowed)
    wanted = [
        (shrunk.entries, {("functions", "zone:B"): (40, "b")}),
        (shrunk.caps, {"functions": 1}),
        (grown.entries, {("functions", "zone:B"): (41, "b")}),
        (anew.entries, {("functions", "zone/edit:A"): (30, "why"), ("functions", "zone:B"): (40, "b")}),
        (anew.caps, {"functions": 2}),
    ]
    return [f"the list is rewritten to {got}, wanted {want}" for got, want in wanted if got != want]


CHECK = ratchet.Ratchet("structure", "files", RULES, HEAD, LIST, measure)

if __name__ == "__main__":
    sys.exit(CHECK.main(__doc__, GOOD, BAD, (judge_reader, judge_rewriting)))
