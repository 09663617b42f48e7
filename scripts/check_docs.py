#!/usr/bin/env python3
"""Every file, folder, test and link named by the documents exists.

In *.md of the root folder and docs/**/*.md:
  - a path in backquotes that starts at one of our top folders (`src/zone/geometry/section.h`), * is a wildcard;
  - the target of a relative link or image;
  - in docs/paper-map.md each item A1 to A39 has one row, whose last column begins with its state;
  - in docs/paper-map.md and docs/reliability.md also every `Suite.test` in backquotes, which must exist as TEST(Suite, test) in src/ or e2e/.
--self-test checks small good and bad documents.
"""

import pathlib
import re
import sys

import checker

TOPS = r"(?:src|docs|zones|batteries|scenarios|rules|scripts|bench|web|e2e|examples|fuzz|cmake|\.ci)"
PATH = re.compile(rf"`({TOPS}(?:/[\w.*@+-]+)+/?)(?::\d+)?`")
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
TEST_NAME = re.compile(r"`([A-Z]\w*)\.([a-zA-Z]\w*)`")
TEST_CASE = re.compile(r"\b(?:TEST|TEST_F|TEST_P|TYPED_TEST|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\(\s*(\w+),\s*(\w+)")
# Documents in which `Suite.test` is the name of a test.
NAMES_TESTS = ("docs/paper-map.md", "docs/reliability.md")
MAP = "docs/paper-map.md"
ITEM = re.compile(r"^\| (A\d+) \|.*\| (\S[^|]*) \|$")
STATE = re.compile(r"(TRUE|PARTLY|BEYOND)\b[.:,]? \S")
ITEMS = [f"A{n}" for n in range(1, 40)]
# Created by building or testing, therefore not in a fresh checkout.
MADE = ("web/dist", "e2e/artefacts")


def items(document):
    """What is wrong with the items of the article in the map."""
    rows = [match.groups() for line in document.read_text().splitlines() if (match := ITEM.match(line))]
    named = [item for item, _ in rows]
    for item in ITEMS:
        if named.count(item) != 1:
            yield f"{MAP}: {item} has {named.count(item)} rows, expected 1"
    for item, state in rows:
        if not STATE.match(state):
            yield f"{MAP}: the last column of {item} begins with none of TRUE, PARTLY and BEYOND and a sentence"


def check(root):
    problems, documents = [], [*sorted(root.glob("*.md")), *sorted((root / "docs").rglob("*.md"))]
    tests = None
    problems += items(root / MAP) if (root / MAP).exists() else []
    for document in [d for d in documents if d.exists()]:
        name = document.relative_to(root).as_posix()
        for number, line in enumerate(document.read_text().splitlines(), 1):
            where = f"{name}:{number}"
            for path in PATH.findall(line):
                if not path.startswith(MADE) and not any(root.glob(path.rstrip("/"))):
                    problems.append(f"{where}: there is no {path}")
            for target in LINK.findall(line):
                if "://" not in target and not target.startswith("mailto:") and not (document.parent / target).exists():
                    problems.append(f"{where}: the link target {target} does not exist")
            if name in NAMES_TESTS:
                if tests is None:
                    files = [*(root / "src").rglob("*.cpp"), *(root / "e2e").glob("*.cpp")]
                    tests = {case for file in files for case in TEST_CASE.findall(file.read_text())}
                for suite, test in TEST_NAME.findall(line):
                    if (suite, test) not in tests:
                        problems.append(f"{where}: there is no TEST({suite}, {test})")
    return len(documents), problems


# ---- self-test -------------------------------------------------------------------------------------------------------

GOOD = {
    "README.md": "[a](docs/a.md#part) [b](https://example.org/) `src/zone/z.h` `src/*/z.h` `web/dist/x`",
    "docs/a.md": "[back](../README.md) `scripts/run`",
    MAP: "".join(f"| A{n} | `Section.ends_where_it_should` | TRUE. So it is |\n" for n in range(1, 40)),
    "src/zone/z.h": "",
    "src/zone/z_test.cpp": "TEST(Section, ends_where_it_should) {}",
    "scripts/run": "",
}
BAD = [
    ({"README.md": "see `src/zone/gone.h`"}, "README.md:1: there is no src/zone/gone.h"),
    ({"README.md": "\n[x](docs/gone.md)"}, "README.md:2: the link target docs/gone.md"),
    ({"README.md": "![x](docs/images/gone.png)"}, "docs/images/gone.png does not exist"),
    ({"docs/guide/g.md": "`src/nothing/*.h`"}, "there is no src/nothing/*.h"),
    ({MAP: "`Section.is_gone`"}, "no TEST(Section, is_gone)"),
    ({MAP: "| A1 | x | here |"}, "the last column of A1 begins with none of"),
    ({MAP: "| A1 | x | TRUE |"}, "the last column of A1 begins with none of"),
    ({MAP: "| A1 | x | TRUE. Yes |\n| A1 | y | TRUE. Twice |"}, "A1 has 2 rows"),
    ({MAP: "| A1 | x | TRUE. Yes |"}, "A39 has 0 rows"),
]


if __name__ == "__main__":
    sys.exit(checker.main("docs", __doc__, "documents", check, GOOD, BAD))
