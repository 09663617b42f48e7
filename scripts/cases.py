#!/usr/bin/env python3
"""Runs ctest, and evaluates its result: limits of time apply only while the machine is not suspended.

    scripts/cases.py --test-dir build/release -j 2 -E '^e2e'

If a test fails while the machine itself was suspended (a virtual machine whose host has no time for it), as observed by
a witness thread, the test is repeated alone once the machine runs. A test that fails without a suspension has failed.
Skipped or disabled tests count as failed. A test that is a suite of GoogleTest counts as many as it has cases. Ends with
"N passed, N failed"; exit code 1 if anything failed."""

import os
import re
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

from witness import Witness

STILL_MS = 200  # a suspension up to this total affects no long test,
STILL_SHARE = 0.05  # and one up to this ratio of its duration no short test
QUIET_S = 15  # with almost no suspension, before a test is repeated
QUIET_STILL_MS = 50  # a machine is never completely undisturbed
TRIES = 6
SLOWEST = 20  # number of cases listed with their times
PATIENCE_S = 1200  # for all repetitions; a host was overloaded for up to four consecutive minutes

START = re.compile(r"\s*Start\s+(\d+): (.*)")
END = re.compile(r"\s*\d+/\d+ Test\s+#(\d+): .*? (?=\.{3})")
OUTPUT_BYTES = "20000000"  # of a test, kept by ctest: a suite's output tells the results of its cases
REASON = re.compile(r"^.*(?:\bnot ok \d|✖ (?!failing tests)|: Failure$|\b[Ee]rror: (?:\|-\n)?|Error \[\w+\]: |\[  FAILED  \] |runtime error|Timeout).*$", re.MULTILINE)
REASONS = 12  # lines of a failed test that the list at the end repeats
CASE = re.compile(r"^\[ (?:      OK| FAILED ) \] ([^\s,]+).* \((\d+) ms\)$", re.MULTILINE)


class Suite:
    """The cases of a test: those of a suite of GoogleTest, by its output; otherwise the test itself is the only one."""

    def __init__(self, name, passed, seconds, output):
        cases = [(match[0].startswith("[       OK"), match[1], float(match[2]) / 1e3) for match in CASE.finditer(output)]
        good = [case for case in cases if case[0]]
        self.seconds = [(each, f"{name.split(': ')[0]}: {case}") for _, case, each in cases] or [(seconds, name)]
        self.passed = max(len(good), 1) if passed else len(good)
        # A suite that ended at once, by a crash or a timeout, names no failed case.
        self.failed = 0 if passed else max(len(cases) - len(good), 1)


class Case:
    """A test: its name, its result in ctest's report, and the duration of suspensions during the test."""

    def __init__(self, name, element, span, witness):
        self.name = name
        self.passed = element.get("status") == "run" and element.find("failure") is None
        self.ran = element.get("status") in ("run", "fail")
        self.output = element.findtext("system-out") or ""
        self.seconds = span[1] - span[0]
        self.suite = Suite(name, self.passed, self.seconds, self.output)
        self.still_ms = witness.still_ms(*span)
        self.excused = self.still_ms > min(STILL_MS, 1e3 * STILL_SHARE * self.seconds)

    def reasons(self):
        """The first lines of the output that name a failure; without any, its last line."""
        lines = REASON.findall(self.output)[:REASONS] or self.output.rstrip().splitlines()[-1:]
        one_line = (re.sub(r"\s*\n\s*", " ", line.strip()) for line in lines)
        return "".join(f"\t    {line}\n" for line in one_line)


def run_ctest(arguments, witness, on_line):
    """The cases by name; none if ctest wrote no report."""
    began, spans = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.xml")
        command = ["ctest", *arguments, "--output-junit", report, "--test-output-size-passed", OUTPUT_BYTES,
                   "--test-output-size-failed", OUTPUT_BYTES]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace") as ctest:
            for line in ctest.stdout:
                if match := START.match(line):
                    began[match[1]] = (match[2].rstrip("\n"), time.monotonic())
                elif (match := END.match(line)) and match[1] in began:
                    name, since = began[match[1]]
                    spans[name] = (since, time.monotonic())
                on_line(line)
        try:
            elements = xml.etree.ElementTree.parse(report).getroot().iter("testcase")
        except (OSError, xml.etree.ElementTree.ParseError):
            return {}
    return {name: Case(name, element, spans.get(name, (0, 0)), witness)
            for element in elements for name in [element.get("name")]}


class Judge:
    def __init__(self, arguments, witness, say):
        self.arguments, self.witness, self.say = arguments, witness, say

    def judge(self):
        """The numbers of passed and failed cases."""
        cases = run_ctest(self.arguments, self.witness, self._progress)
        if not cases:
            self.say("ctest has run no tests\n")
            return 0, 1
        slowest = sorted((timed for case in cases.values() for timed in case.suite.seconds), reverse=True)[:SLOWEST]
        self.say("The slowest:\n" + "".join(f"{seconds:8.1f} s  {name}\n" for seconds, name in slowest))
        self._again(cases)
        failed = [case for case in cases.values() if not case.passed]
        for case in failed:
            self.say(f"\n--- {case.name}; the machine was suspended for {case.still_ms:.0f} ms of it\n{case.output}\n")
        if failed:
            self.say("The following tests FAILED:\n" + "".join(f"\t{case.name} (Failed)\n{case.reasons()}" for case in failed))
        return sum(case.suite.passed for case in cases.values()), sum(case.suite.failed for case in cases.values())

    def _progress(self, line):
        """Prints ctest's progress; failures are evaluated, and reported completely, at the end."""
        if match := END.match(line):
            self.say(f"{match[0]}... to be evaluated\n" if "***" in line else line)

    def _again(self, cases):
        """Repeats tests that failed while the machine was suspended."""
        end = time.monotonic() + PATIENCE_S
        for name in [name for name, case in cases.items() if not case.passed]:
            for _ in range(1, TRIES):
                case = cases[name]
                if case.passed or not case.ran or not case.excused or time.monotonic() > end:
                    break
                self.say(f"repeated, because the machine was suspended for {case.still_ms:.0f} ms of it: {name}\n")
                self.until_the_machine_runs(end)
                cases[name] = self._alone(name) or case

    def _alone(self, name):
        exactly = "^" + re.sub(r"([^A-Za-z0-9_ ,:/'-])", r"\\\1", name) + "$"
        return run_ctest([*self.arguments, "-j", "1", "-R", exactly], self.witness, self._progress).get(name)

    def until_the_machine_runs(self, end):
        while time.monotonic() < end:
            since = time.monotonic()
            time.sleep(QUIET_S)
            if self.witness.still_ms(since, time.monotonic()) <= QUIET_STILL_MS:
                return


def main():
    arguments = sys.argv[1:]
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if arguments else 2
    passed, failed = Judge(arguments, Witness(), lambda text: print(text, end="", flush=True)).judge()
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
