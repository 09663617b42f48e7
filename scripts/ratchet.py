"""Allow-lists that may only shrink, for checks that count violations in the tree.

A list is a text file. `cap RULE N` fixes how many entries a rule may have. Each other line is one exception:

    RULE NAME VALUE REASON

The check fails when a violation has no entry, when a value grew, when a value fell below its entry, when an entry is no
longer needed, and when the number of entries differs from the cap. `--write` lowers values and caps and removes entries;
only `--measure` adds entries.
"""

import argparse
import pathlib
from dataclasses import dataclass, field

import checker


@dataclass
class AllowList:
    entries: dict = field(default_factory=dict)  # (rule, name): (value, reason)
    caps: dict = field(default_factory=dict)


def read(path, rules, problems):
    """The list in a file; a file that does not exist is an empty list."""
    allowed = AllowList()
    lines = path.read_text().splitlines() if path.exists() else []
    for number, line in enumerate(lines, 1):
        words = line.split(maxsplit=3)
        where = f"{path.name}:{number}"
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "cap" and len(words) == 3 and words[1] in rules and words[2].isdigit():
            allowed.caps[words[1]] = int(words[2])
        elif words[0] not in rules:
            problems.append(f"{where}: '{words[0]}' is not a rule")
        elif len(words) < 4 or not words[2].isdigit():
            problems.append(f"{where}: an entry is RULE NAME VALUE REASON")
        elif (words[0], words[1]) in allowed.entries:
            problems.append(f"{where}: {words[0]} {words[1]} is listed twice")
        else:
            allowed.entries[words[0], words[1]] = (int(words[2]), words[3])
    return allowed


def compare(measured, allowed, rules, file_name):
    """The problems. `measured` is {(rule, name): (value, complaint)}; it holds violations only."""
    problems = []
    for key, (value, complaint) in sorted(measured.items()):
        limit = allowed.entries.get(key, (None, ""))[0]
        if limit is None:
            problems.append(complaint)
        elif value > limit:
            problems.append(f"{complaint}; {file_name} allows {limit}")
        elif value < limit:
            problems.append(f"{file_name}: {' '.join(key)}: shrink the entry from {limit} to {value} (--write does it)")
    for key in sorted(allowed.entries.keys() - measured.keys()):
        problems.append(f"{file_name}: {' '.join(key)}: the entry is no longer needed, remove it (--write does it)")
    for rule in rules:
        count = sum(1 for entry_rule, _ in allowed.entries if entry_rule == rule)
        cap = allowed.caps.get(rule, 0)
        if count > cap:
            problems.append(f"{file_name}: {count} entries for {rule}, the cap is {cap}: the list may only shrink")
        elif count < cap:
            problems.append(f"{file_name}: {count} entries for {rule}: lower the cap from {cap} (--write does it)")
    return problems


def shrunk(measured, allowed):
    """The list with values lowered to the measured ones, and without unneeded entries."""
    kept = {
        key: (min(value, measured[key][0]), reason) for key, (value, reason) in allowed.entries.items() if key in measured
    }
    return with_caps(kept, allowed.caps)


def with_caps(entries, caps_max=None):
    caps = {}
    for rule, _ in entries:
        caps[rule] = caps.get(rule, 0) + 1
    if caps_max is not None:
        caps = {rule: min(count, caps_max.get(rule, 0)) for rule, count in caps.items()}
    return AllowList(entries, caps)


def last_part(name):
    return name.replace(":", "/").split("/")[-1]


def measured_anew(measured, allowed, reasons):
    """A list of all measured violations. Entries keep their reasons, also if their module changed."""
    by_last_part = {(rule, last_part(name)): reason for (rule, name), (_, reason) in allowed.entries.items()}
    entries = {}
    for (rule, name), (value, _) in measured.items():
        kept = allowed.entries.get((rule, name), (0, by_last_part.get((rule, last_part(name)), reasons[rule])))
        entries[rule, name] = (value, kept[1])
    return with_caps(entries)


def text_of(allowed, rules, head):
    lines = [f"# {line}".rstrip() for line in head.strip().splitlines()]
    lines += [""] + [f"cap {rule} {allowed.caps[rule]}" for rule in rules if rule in allowed.caps]
    for rule in rules:
        entries = sorted((name, *rest) for (entry_rule, name), rest in allowed.entries.items() if entry_rule == rule)
        if entries:
            lines += [""] + [f"{rule} {name} {value} {reason}" for name, value, reason in entries]
    return "\n".join(lines) + "\n"


@dataclass
class Ratchet:
    """A check with such a list. `measure(root, problems)` returns (number of items read, measured)."""

    name: str
    what: str
    rules: dict  # rule: reason that --measure writes
    head: str
    file: str  # path of the list below the root
    measure: object

    def check(self, root):
        problems = []
        looked_at, measured = self.measure(root, problems)
        allowed = read(root / self.file, self.rules, problems)
        return looked_at, problems + compare(measured, allowed, self.rules, pathlib.Path(self.file).name)

    def rewrite(self, root, anew):
        problems = []
        _, measured = self.measure(root, problems)
        path = root / self.file
        allowed = read(path, self.rules, problems)
        made = measured_anew(measured, allowed, self.rules) if anew else shrunk(measured, allowed)
        path.write_text(text_of(made, self.rules, self.head))
        print(f"{self.name}: {len(made.entries)} entries in {self.file}, {len(allowed.entries)} before")
        return problems

    def main(self, description, good, bad, more_self_tests=()):
        parser = argparse.ArgumentParser(description=description.splitlines()[0])
        parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
        parser.add_argument("--self-test", action="store_true", help="check known good and bad trees instead")
        parser.add_argument("--write", action="store_true", help="lower the allow-list to the measured values; adds nothing")
        parser.add_argument("--measure", action="store_true", help="rewrite the allow-list, after a deliberate move")
        arguments = parser.parse_args()
        if arguments.self_test:
            failures = [failure for test in more_self_tests for failure in test()]
            for failure in failures:
                print(failure)
            return max(checker.self_test(self.name, self.check, good, bad), 1 if failures else 0)
        if arguments.write or arguments.measure:
            for problem in self.rewrite(arguments.root, arguments.measure):
                print(problem)
        looked_at, problems = self.check(arguments.root)
        for problem in problems:
            print(problem)
        print(f"{self.name}: {looked_at} {self.what}, {len(problems)} problems")
        return 1 if problems else 0
