"""Common code of the repository's checks: each evaluates a tree of files, and known bad trees in its self-test
(--self-test), so that no check becomes ineffective unnoticed."""

import argparse
import pathlib
import tempfile


def judge(check, tree, under="."):
    """The problems that `check(root)` finds in a tree given as {path: text}, laid out below `under`."""
    with tempfile.TemporaryDirectory() as root:
        for name, text in tree.items():
            path = pathlib.Path(root) / under / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text + "\n")
        return check(pathlib.Path(root))[1]


def self_test(name, check, good, bad, under="."):
    """`good` must pass; each of `bad`, (change to good, part of the expected message), must not."""
    failures = [f"a good tree was refused: {problem}" for problem in judge(check, good, under)]
    for change, complaint in bad:
        problems = judge(check, good | change, under)
        if not any(complaint in problem for problem in problems):
            failures.append(f"{change} should be refused with '{complaint}', got {problems}")
    for failure in failures:
        print(failure)
    print(f"{name}, self-test: {1 + len(bad)} trees checked, {len(failures)} wrong")
    return 1 if failures else 0


def main(name, description, what, check, good, bad, under="."):
    """The command line of a check. `check(root)` returns the checked items and the problems; `what` names the items."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    parser.add_argument("--self-test", action="store_true", help="check known good and bad trees instead")
    arguments = parser.parse_args()
    if arguments.self_test:
        return self_test(name, check, good, bad, under)
    looked_at, problems = check(arguments.root)
    for problem in problems:
        print(problem)
    count = looked_at if isinstance(looked_at, int) else len(looked_at)
    print(f"{name}: {count} {what}, {len(problems)} problems")
    return 1 if problems else 0
