#!/usr/bin/python3
"""Validates LIF files against the official schema of LIF 1.0.

Checks the given files, or by default those of the repository: the layouts in zones/ and the output of CoSiVA's writer.
Prints the first faults of each with their locations and exits with 1 if there is any. --self-test checks known files:
two valid ones of other projects, and the standard's own examples, which are invalid.
"""
import argparse
import json
import pathlib
import sys

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parent.parent
TESTDATA = ROOT / "src" / "zone" / "lif" / "testdata"
KNOWN_GOOD = {"kit-ifl-lab.lif.json", "vda5050-core-sample.lif.json"}


def place(error):
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in error.absolute_path)
    return text.lstrip(".") or "(file)"


def load_validator():
    schema = json.loads((TESTDATA / "LIF.schema").read_text(encoding="utf-8"))
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def faults(validator, path):
    layout = json.loads(path.read_text(encoding="utf-8"))
    errors = sorted(validator.iter_errors(layout), key=lambda e: list(map(str, e.absolute_path)))
    return [f"{path.name}: {place(error)}: {error.message[:200]}" for error in errors]


def self_test(validator):
    wrongly = 0
    files = sorted(TESTDATA.glob("*.lif.json"))
    for path in files:
        found = faults(validator, path)
        if bool(found) == (path.name in KNOWN_GOOD):
            wrongly += 1
            print(f"{path.name} should be {'valid' if found else 'refused'}: {found[:1]}", file=sys.stderr)
    print(f"self-test: {len(files)} files checked, {wrongly} wrong")
    return 1 if wrongly or not files else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=pathlib.Path, help="LIF files; default: those of the repository")
    parser.add_argument("--self-test", action="store_true", help="check known files")
    arguments = parser.parse_args()
    validator = load_validator()
    if arguments.self_test:
        return self_test(validator)
    files = arguments.files or sorted((ROOT / "zones").glob("*.lif.json")) + sorted((TESTDATA / "written").glob("*.json"))
    bad = 0
    for path in files:
        found = faults(validator, path)
        bad += bool(found)
        for fault in found[:5]:
            print(fault, file=sys.stderr)
    print(f"{len(files) - bad} valid, {bad} bad")
    # Without any file the check could not fail.
    return 1 if bad or not files else 0


if __name__ == "__main__":
    sys.exit(main())
