#!/usr/bin/python3
"""Validates battery types against their schema, docs/protocols/battery-type.schema.json.

Checks the given files, or by default those of the repository. Prints the faults of each with their locations and exits
with 1 if there is any. --self-test modifies a valid file in known ways: each fault must be found.
"""
import argparse
import copy
import json
import pathlib
import sys

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parent.parent


def validator():
    schema = json.loads((ROOT / "docs/protocols/battery-type.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def faults(judge, document):
    errors = sorted(judge.iter_errors(document), key=lambda e: list(map(str, e.absolute_path)))
    return [f"{'.'.join(map(str, e.absolute_path)) or '(file)'}: {e.message[:160]}" for e in errors]


def self_test(judge):
    good = json.loads((ROOT / "batteries/leaf33.json").read_text(encoding="utf-8"))
    spoilers = [
        lambda d: d.pop("licence"),
        lambda d: d.update(source=" "),
        lambda d: d.update(capacity=30.5),
        lambda d: d.update(capacity_ampere_hour="30.5"),
        lambda d: d["series_ohm"].__setitem__(3, -0.001),
        lambda d: d["charge_fraction"].__setitem__(13, 100),
        lambda d: d.update(format="cosiva-battery-type/2"),
    ]
    wrongly = 1 if faults(judge, good) else 0
    for spoil in spoilers:
        bad = copy.deepcopy(good)
        spoil(bad)
        wrongly += 0 if faults(judge, bad) else 1
    print(f"self-test: {len(spoilers) + 1} files checked, {wrongly} wrong")
    return 1 if wrongly else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=pathlib.Path, help="battery types; default: those of the repository")
    parser.add_argument("--self-test", action="store_true", help="check known files")
    arguments = parser.parse_args()
    judge = validator()
    if arguments.self_test:
        return self_test(judge)
    files = arguments.files or sorted((ROOT / "batteries").glob("*.json"))
    bad = 0
    for path in files:
        found = faults(judge, json.loads(path.read_text(encoding="utf-8")))
        bad += 1 if found else 0
        for fault in found:
            print(f"{path.name}: {fault}", file=sys.stderr)
    print(f"{len(files)} battery types, {bad} with faults")
    return 1 if bad or not files else 0


if __name__ == "__main__":
    sys.exit(main())
