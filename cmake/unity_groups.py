#!/usr/bin/env python3
"""Distributes each folder's sources, and its tests, over unity units: a number per file, as a CMake variable.

Two sources may not share a unit when the earlier one declares, in an anonymous namespace or as a macro, a name that the
later one uses within the same namespace: the names would clash, or the later source would mean another thing. Sources of
such a pair land in different units, so that a source stays free in what it calls its own helpers. Names are found without a
compiler, and too many rather than too few; where that was wrong, the compiler refuses the unit.
"""

import argparse
import functools
import pathlib
import re
import sys

IGNORED = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.MULTILINE)
NAMESPACE = re.compile(r"^namespace ([\w:]+) \{", re.MULTILINE)
DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.MULTILINE)
TOKEN = re.compile(r"[A-Za-z_]\w*|->|::|[^\s\w]|\d[\w.']*")
# A name of the standard library, and a member of some value, cannot be meant for a helper of another source.
FOREIGN = ("std", "chrono", "ranges", "views", "filesystem")
DECLARED_BEFORE = ("(", "=", "{", ";", "[", ":")
# Libraries whose templates cost every source that uses them seconds of its own: such a source counts for several.
HEAVY = ("Eigen::", "estimation/linear.h", "CLI::", "boost::")
HEAVY_COUNT = 6
MACROS = "#define"  # stands for the namespace of macros


def closing(tokens, start):
    """The index behind the brace that closes the one at `start`."""
    depth = 0
    for index in range(start, len(tokens)):
        if tokens[index] == "{":
            depth += 1
        elif tokens[index] == "}":
            depth -= 1
            if depth == 0:
                return index + 1
    return len(tokens)


def declared_in(tokens):
    """The names that one anonymous namespace declares; `tokens` are what stands between its braces."""
    names, index, parentheses = set(), 0, 0
    while index < len(tokens):
        token = tokens[index]
        if token == "{":
            index = closing(tokens, index)
            continue
        parentheses += (token == "(") - (token == ")")
        follows = tokens[index + 1] if index + 1 < len(tokens) else ""
        if parentheses == 0 and (token[0].isalpha() or token[0] == "_") and follows in DECLARED_BEFORE:
            if (index == 0 or tokens[index - 1] != "::") and not token.isupper():  # TEST (…) declares no TEST
                names.add(token)
        index += 1
        if parentheses == 0 and token == "=":  # what a name is set to declares nothing
            while index < len(tokens) and tokens[index] != ";":
                index = closing(tokens, index) if tokens[index] == "{" else index + 1
    return names


@functools.cache
def names_of(text):
    """What a source declares for itself alone, by namespace, all the names that it uses, and its namespaces."""
    text = IGNORED.sub('""', text)
    spaces = set(NAMESPACE.findall(text)) or {""}
    macros, own = set(MACRO.findall(text)), set()
    tokens = TOKEN.findall(DIRECTIVE.sub("", text))
    for index in range(len(tokens) - 1):
        if tokens[index] == "namespace" and tokens[index + 1] == "{":
            own |= declared_in(tokens[index + 2 : closing(tokens, index + 1) - 1])
    used = set()
    for index, token in enumerate(tokens):
        before = tokens[index - 1] if index else ""
        qualifier = tokens[index - 2] if index > 1 and before == "::" else ""
        if before not in (".", "->") and qualifier not in FOREIGN:
            used.add(token)
    return {MACROS: macros} | {space: own for space in spaces}, used, spaces


def reaches(space, spaces):
    """Whether a text of the namespaces `spaces` finds what is declared in the namespace `space`. A name that stands outside
    all namespaces is hidden within others by the name that is meant there; a macro (MACROS) is not."""
    return space == MACROS or any(inner == space or (space and inner.startswith(space + "::")) for inner in spaces)


def groups_of(texts, most, headers=None):
    """A group for each of the sources in order: the first one with room in which no name clashes. `headers`: per source,
    the texts of the headers that its unit would show to helpers of earlier sources."""
    groups, chosen = [], []  # per group: the names by namespace, and the number of sources
    for index, text in enumerate(texts):
        shown = {}  # by namespaces: the names used there
        for part in (text, *(headers[index] if headers else ())):
            _, used, spaces = names_of(part)
            shown.setdefault(frozenset(spaces), set()).update(used)
        size = HEAVY_COUNT if any(name in text for name in HEAVY) else 1
        fits = (
            i
            for i, (own, total) in enumerate(groups)
            if total + size <= most
            and not any(names & used for space, names in own.items() for spaces, used in shown.items() if reaches(space, spaces))
        )
        group = next(fits, len(groups))
        if group == len(groups):
            groups.append([{}, 0])
        for space, names in names_of(text)[0].items():
            groups[group][0].setdefault(space, set()).update(names)
        groups[group][1] += size
        chosen.append(group)
    return chosen


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("most", type=int, help="sources per unit at most")
    parser.add_argument("root", type=pathlib.Path, help="where the folders are looked for")
    arguments = parser.parse_args()
    targets = {}
    for file in sorted(arguments.root.rglob("*.cpp")):
        targets.setdefault((file.parent, file.name.endswith("_test.cpp")), []).append(file)
    for files in targets.values():
        groups = groups_of([file.read_text() for file in files], arguments.most)
        for file, group in zip(files, groups):
            print(f"set(unity_group_{file.relative_to(arguments.root)} {group})")


if __name__ == "__main__":
    sys.exit(main())
