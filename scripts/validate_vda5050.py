#!/usr/bin/python3
"""Validates VDA 5050 messages against the official 2.1.0 schemas.

Reads one JSON object per line, {"topic": ..., "payload": ...}, from the given files or from standard input. The last
level of the topic (order, instantActions, state, visualization, connection, factsheet) chooses the schema; a line of
any other topic is an error unless --skip-others is given. The payload is the message, or its text. Prints the first
fault of each bad line with its location and exits with 1; a good run prints the number of valid messages of each kind.

Faults of the schemas themselves, corrected in memory because the document takes precedence (2.1.0, clause 6):
  state      actionStatus lacks PAUSED (document 6.11 has it)
  factsheet  blockingTypes puts the enum on the array instead of on its items, so that no list passes
"""
import argparse
import collections
import json
import pathlib
import sys

import jsonschema

KINDS = ("order", "instantActions", "state", "visualization", "connection", "factsheet")
SCHEMAS = pathlib.Path(__file__).resolve().parent.parent / "src" / "wire" / "vda5050" / "schemas"


def mend_state(schema):
    status = schema["properties"]["actionStates"]["items"]["properties"]["actionStatus"]
    if "PAUSED" not in status["enum"]:
        status["enum"].append("PAUSED")


def mend_factsheet(schema):
    actions = schema["properties"]["protocolFeatures"]["properties"]["agvActions"]
    blocking = actions["items"]["properties"]["blockingTypes"]
    if "enum" in blocking:
        blocking["items"] = {"type": "string", "enum": blocking.pop("enum")}


MENDINGS = {"state": mend_state, "factsheet": mend_factsheet}


def load_validator(kind):
    schema = json.loads((SCHEMAS / f"{kind}.schema").read_text(encoding="utf-8"))
    MENDINGS.get(kind, lambda _: None)(schema)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def place(error):
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in error.absolute_path)
    return text.lstrip(".") or "(message)"


def validate_line(line, validators, skip_others):
    """The kind of a valid message, None for a skipped one; raises ValueError with the fault otherwise."""
    record = json.loads(line)
    kind = record["topic"].rsplit("/", 1)[-1]
    if kind not in validators:
        if skip_others:
            return None
        raise ValueError(f"topic '{record['topic']}' is not a topic of VDA 5050: {', '.join(KINDS)}")
    payload = record["payload"]
    message = json.loads(payload) if isinstance(payload, str) else payload
    errors = sorted(validators[kind].iter_errors(message), key=lambda e: list(map(str, e.absolute_path)))
    if errors:
        raise ValueError(f"{kind}: {place(errors[0])}: {errors[0].message[:300]}")
    return kind


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", help="NDJSON files; default: standard input")
    parser.add_argument("--skip-others", action="store_true", help="skip topics that are not part of VDA 5050")
    arguments = parser.parse_args()

    validators = {kind: load_validator(kind) for kind in KINDS}
    counts = collections.Counter()
    bad = 0
    for name in arguments.files or ["-"]:
        stream = sys.stdin if name == "-" else open(name, encoding="utf-8")
        with stream:
            for number, line in enumerate(stream, 1):
                if not line.strip():
                    continue
                try:
                    kind = validate_line(line, validators, arguments.skip_others)
                    counts[kind or "skipped"] += 1
                except (ValueError, KeyError, TypeError) as fault:
                    bad += 1
                    print(f"{name}:{number}: {fault}", file=sys.stderr)
    print(f"{sum(counts.values())} valid, {bad} bad: " + ", ".join(f"{k} {n}" for k, n in sorted(counts.items())))
    # Without any message the check could not fail.
    return 1 if bad or not counts else 0


if __name__ == "__main__":
    sys.exit(main())
