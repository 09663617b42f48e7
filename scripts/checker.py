"""What the checks of the house share: each judges a tree of files, and judges known bad trees first (--self-test), so that
none can rot into a yes."""

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
    """`good` must pass; each of `bad`, (change to good, piece of the complaint that must follow), must not."""
    failures = [f"a good tree was refused: {problem}" for problem in judge(check, good, under)]
    for change, complaint in bad:
        problems = judge(check, good | change, under)
        if not any(complaint in problem for problem in problems):
            failures.append(f"{change} should be refused with '{complaint}', got {problems}")
    for failure in failures:
        print(failure)
    print(f"{name}, self-test: {1 + len(bad)} trees judged, {len(failures)} wrongly")
    return 1 if failures else 0


def main(name, description, what, check, good, bad, under="."):
    """The command line of a check. `check(root)` gives what it looked at and the problems; `what` names the former."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    parser.add_argument("--self-test", action="store_true", help="judge known good and bad trees instead")
    arguments = parser.parse_args()
    if arguments.self_test:
        return self_test(name, check, good, bad, under)
    looked_at, problems = check(arguments.root)
    for problem in problems:
        print(problem)
    count = looked_at if isinstance(looked_at, int) else len(looked_at)
    print(f"{name}: {count} {what}, {len(problems)} problems")
    return 1 if problems else 0
