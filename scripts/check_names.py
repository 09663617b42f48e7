#!/usr/bin/env python3
"""Names that are not permitted in certain folders.

blind   src/virtual and the page's sources name no ready zone, zone format or vehicle make (A19): they process any input.
        Tests may, since they have to provide an input.
pure    the cores (all of src/ except adapters, hmi and app) use no elementary function, random number or hash order that
        could differ between machines, and no thread, clock, file or socket: bit-identical results (docs/architecture.md).
        Tests may: they compare with libm and read files.
heard   a property's result is used: rc::check() returns it and tells GoogleTest nothing, so that a discarded one cannot fail.
once    a type of a namespace is defined in one file: the linker would keep one of two definitions for both. Types in
        anonymous namespaces are not seen by the linker.

--self-test checks small good and bad files.
"""

import pathlib
import re
import sys

import checker

CONCRETE = (
    r"lacet|indus(?!tr)|clover|toml|opendrive|xodr|movingai|\blif\b"
    r"|kuka|jungheinrich|omron|seegrid|turtlebot|raspberry|\bmir\d|vda-5050-lib"
)


def concrete(root):
    """CONCRETE and the names of all included zones."""
    zones = {file.name.partition(".")[0] for file in root.glob("zones/*") if file.suffix != ".LICENSE"}
    return re.compile("|".join([CONCRETE, *(rf"\b{re.escape(zone)}\b" for zone in sorted(zones))]), re.IGNORECASE)


MATH = (
    "sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt"
    "|hypot"
    "|fma|erf|erfc|tgamma|lgamma|beta|legendre"
)
SHELL_HEADERS = (
    "thread|mutex|shared_mutex|condition_variable|future|atomic|random|filesystem|fstream|iostream"
    "|unistd.h|time.h|ctime|pthread.h|signal.h|csignal|poll.h|fcntl.h|sys/[a-z_]+.h|netinet/[a-z_]+.h|arpa/[a-z_]+.h"
)
IMPURE = [
    (re.compile(rf"\bstd::({MATH})[fl]?\b"), "differs in its last bit between machines; base/math.h has its own"),
    (re.compile(r"\bstd::(rand|srand|random_device|mt19937|minstd_rand|\w+_distribution|shuffle|sample)\b|\brand\(\)"),
     "differs between libraries; base/random.h has streams"),
    (re.compile(r"\bstd::(jthread|thread|async|mutex|atomic|condition_variable|future|promise)\b"),
     "a core runs in the thread of its caller"),
    (re.compile(r"\b(system_clock|steady_clock|high_resolution_clock|utc_clock)\b"
                r"|\b(clock_gettime|gettimeofday|localtime|mktime)\b|\bstd::time\("), "a core is given the time"),
    (re.compile(r"\bstd::([io]?fstream|filesystem|cout|cin|cerr|clog)\b|\b(fopen|getenv|system|popen|fork|socket)\("),
     "a core uses no resource of the machine"),
    (re.compile(r"\bstd::hash\b"), "differs between libraries; base/digest.h replaces it"),
    (re.compile(rf"^\s*#\s*include\s*<({SHELL_HEADERS})>", re.MULTILINE), "belongs in a shell"),
]
# A bare call of a libm name; unless the folder declares a function of its own by that name, such as `void log(…)`.
BARE = re.compile(rf"(?:\breturn\s+|(?<![\w\s.:>&*~])\s*|\s[-+*/]\s+)(?<![\w.:>])({MATH})[fl]?\(")
DECLARED = re.compile(rf"^[ \t]*(?:\[\[\w+\]\] |static |inline |constexpr )*(?!return\b)[\w:<>]+[&*]? ({MATH})\(", re.M)
UNORDERED = re.compile(r"\bunordered_(?:multi)?(?:map|set)\s*<[^;{}()]*>\s+(\w+)")
# CoSiVA's own elementary functions are written here and only here; a failed expectation is printed to stderr.
PURE_EXCEPT = {"base/math.cpp", "base/math.h", "base/expect.cpp"}
SHELLS = {"adapters", "app", "hmi"}


def code_only(text):
    """The text with comments and literals blanked out, line numbers kept."""
    token = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)
    return token.sub(lambda m: re.sub(r"[^\n]", " ", m.group(0)) or " ", text)


def is_test(path):
    """Tests, and what only tests use: thing_test.cpp, test_things.h, thing_fixture.h, testing/, thing.test.ts."""
    return path.parent.name == "testing" or bool(re.search(r"^test_|_test\.cpp$|_fixture\.(h|cpp)$|\.test\.ts$", path.name))


def sources(folder, suffixes):
    return [p for p in sorted(folder.rglob("*")) if p.suffix in suffixes and not is_test(p)]


def check_blind(root, problems):
    files = sources(root / "src/virtual", {".h", ".cpp", ".txt"}) + sources(
        root / "web/src", {".ts", ".svelte", ".css", ".html", ".js"})
    words = concrete(root)
    for path in files:
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for word in words.findall(line):
                problems.append(f"{path.relative_to(root)}:{number}: names '{word}', which is concrete (A19)")
    return len(files)


def check_pure(root, problems):
    src = root / "src"
    files = [p for p in sources(src, {".h", ".cpp"}) if p.relative_to(src).parts[0] not in SHELLS]
    for path in files:
        name = path.relative_to(src).as_posix()
        if name in PURE_EXCEPT:
            continue
        text = code_only(path.read_text())
        where = f"src/{name}"
        for pattern, why in IMPURE:
            for match in pattern.finditer(text):
                line = text.count("\n", 0, match.start() + len(match.group(0)) - len(match.group(0).lstrip())) + 1
                problems.append(f"{where}:{line}: {match.group(0).strip()}: {why}")
        own = {n for p in path.parent.iterdir() if p.suffix in (".h", ".cpp") for n in DECLARED.findall(p.read_text())}
        for match in [m for m in BARE.finditer(text) if m.group(1) not in own]:
            line = text.count("\n", 0, match.start(1)) + 1
            problems.append(f"{where}:{line}: {match.group(1)}(: looks like libm; base/math.h has its own")
        # A lookup in a hash map is permitted, iterating over it is not. A header's members count in its source.
        twin = path.with_suffix(".h")
        header = code_only(twin.read_text()) if twin.exists() else ""
        for member in sorted({*UNORDERED.findall(text), *UNORDERED.findall(header)}):
            for match in re.finditer(rf"\bfor\s*\([^;)]*:\s*(?:\w+(?:\.|->))*{member}\b|\b{member}\.c?begin\(", text):
                line = text.count("\n", 0, match.start()) + 1
                problems.append(f"{where}:{line}: iterates over '{member}' in hash order")
    return len(files)


NAMESPACE = re.compile(r"^namespace(?: ([\w:]+))? \{|^\}  // namespace|^(?:struct|class|enum class|enum) (?:\[\[\w+\]\] )?(\w+)\b(?!::)[^;{]*\{",
                       re.MULTILINE)


def check_once(root, problems):
    files, defined = sources(root / "src", {".h", ".cpp"}), {}
    for path in files:
        spaces = []
        for match in NAMESPACE.finditer(path.read_text()):
            if match[0].startswith("namespace"):
                spaces.append(match[1])
            elif match[0].startswith("}"):
                del spaces[-1:]
            elif None not in spaces:
                first = defined.setdefault("::".join([*spaces, match[2]]), path)
                if first != path:
                    problems.append(f"{path.relative_to(root)}: {match[2]} is also a type of the same namespace in {first.relative_to(root)}")
    return len(files)


def check_heard(root, problems):
    for path in sorted(root.glob("src/**/*.cpp")):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if re.match(r"\s*rc::check\(", line):
                problems.append(f"{path.relative_to(root)}:{number}: the result of rc::check is discarded; EXPECT_TRUE(rc::check(…))")


def check(root):
    problems = []
    check_heard(root, problems)
    count = check_blind(root, problems) + check_pure(root, problems)
    check_once(root, problems)
    return count, problems


# ---- self-test -------------------------------------------------------------------------------------------------------

GOOD = {
    "src/virtual/server/a.cpp": '#include "zone/rtm.h"\n// industrial vehicles of any make, any lifetime\nint life;',
    "src/virtual/server/a_test.cpp": 'auto zone = load("lacet4.toml");',
    "web/src/a.svelte": "<p>Circuit</p>",
    "zones/dock7.toml": "",
    "src/zone/toml.cpp": "// std::sin would do here\nauto s = sincos(x).sin; auto e = det_exp(y); auto p = c.pow(2);\n"
    'auto t = "std::thread rand() sin(1)"; double v = std::sqrt(2); auto w = std::floor(v);',
    "src/zone/toml_test.cpp": "EXPECT_NEAR(std::sin(x), y, 1e-12); std::ifstream file;",
    "src/aiv/log.h": "void log(int x);\nstatic std::string exp(int y);\n double& beta(int z);",
    "src/aiv/log.cpp": "{ log(3); }",
    "src/aiv/log_test.cpp": "  EXPECT_TRUE(rc::check([] {}));\n  return rc::check(name, [] {});",
    "src/aiv/look.cpp": "std::unordered_map<int, int> seen; auto it = seen.find(3); for (auto x : other) {}",
    "src/zone/lane.h": "namespace cosiva::zone {\nstruct Lane {\n  int a;\n};\nclass Other;\n}  // namespace cosiva::zone",
    "src/zone/other.h": "namespace cosiva::zone {\nclass Other {\n};\n}  // namespace cosiva::zone",
    "src/zone/hidden.cpp": "namespace cosiva::zone {\nnamespace {\nstruct Lane {\n};\n}  // namespace\n}  // namespace cosiva::zone",
    "src/wire/lane.h": "namespace cosiva::wire {\nstruct Lane {\n};\n}  // namespace cosiva::wire",
    "src/adapters/clock.cpp": "auto now = std::chrono::system_clock::now(); std::thread t;",
    "src/app/main.cpp": "std::cout << std::sin(1);",
}
BAD = [
    ({"src/virtual/simulator/x.cpp": "if (name == CircuitLacet4) draw();"}, "names 'Lacet'"),
    ({"src/virtual/simulator/x.h": "// reads TOML"}, "names 'TOML'"),
    ({"zones/yard.lif.json": "", "src/virtual/x.cpp": "if (name == Yard)"}, "names 'Yard'"),
    ({"web/src/x.ts": 'import lif from "x"'}, "names 'lif'"),
    ({"web/src/x.ts": "const indus8 = 1"}, "names 'indus'"),
    ({"src/base/x.cpp": "double y = std::sin(x);"}, "src/base/x.cpp:1: std::sin"),
    ({"src/zone/x.cpp": "\n\ndouble y = hypot(a, b);"}, "src/zone/x.cpp:3: hypot("),
    ({"src/zone/x.cpp": "double y = std::atan2f(a, b);"}, "std::atan2f"),
    ({"src/zone/x.cpp": "double f() { return exp(1.0); }"}, "exp("),
    ({"src/zone/x.cpp": "double y = 2.0 * tan(1.0);"}, "tan("),
    ({"src/zone/x.cpp": "f(cos(1.0));"}, "cos("),
    ({"src/aiv/x.cpp": "std::uniform_real_distribution<double> d;"}, "uniform_real_distribution"),
    ({"src/physical/plant/x.cpp": "#include <random>"}, "belongs in a shell"),
    ({"src/wire/x.cpp": "// fine\n#include <sys/socket.h>"}, "src/wire/x.cpp:2"),
    ({"src/wire/x_test.cpp": "void f() {\n  rc::check([] {});\n}"}, "src/wire/x_test.cpp:2: the result of rc::check is discarded"),
    ({"src/wire/x.cpp": "std::jthread t;"}, "a core runs in the thread of its caller"),
    ({"src/journal/x.cpp": "auto t = std::chrono::steady_clock::now();"}, "a core is given the time"),
    ({"src/journal/x.cpp": "std::ofstream out;"}, "uses no resource of the machine"),
    ({"src/experiments/runs/world/x.cpp": 'getenv("HOME");'}, "uses no resource of the machine"),
    (
        {
            "src/virtual/server/y.h": "struct Y { std::unordered_map<std::string, int> all_; };",
            "src/virtual/server/y.cpp": "void f() { for (const auto& [k, v] : all_) use(k); }",
        },
        "iterates over 'all_' in hash order",
    ),
    (
        {
            "src/zone/x.h": "namespace cosiva::zone {\nstruct Rail {\n};\n}  // namespace cosiva::zone",
            "src/zone/y/y.cpp": "namespace cosiva::zone {\nnamespace {\nint i;\n}  // namespace\nenum class Rail { a };\n}",
        },
        "src/zone/y/y.cpp: Rail is also a type of the same namespace in src/zone/x.h",
    ),
    ({"src/aiv/x.cpp": "std::unordered_set<int> seen; auto i = seen.begin();"}, "iterates over 'seen' in hash order"),
]


if __name__ == "__main__":
    sys.exit(checker.main("names", __doc__, "files", check, GOOD, BAD))
