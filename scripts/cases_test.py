#!/usr/bin/env python3
"""Tests of cases.py: a failed test is repeated if the machine was suspended, and not otherwise."""

import os
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest
import unittest.mock

import cases
from witness import Witness

COUNTED = 'printf x >>"$0.$1"; test $(wc -c <"$0.$1") -ge "$1" || { echo "not yet, as <said>"; exit 1; }'


NODE = """# Subtest: a stop holds
    not ok 2 - a stop holds
      ---
      error: |-
        not within 60000 ms: all drive
      ...
not ok 1 - accepted
"""
SPEC = """▶ axe finds no violation
    ✖ tags and beacons (4044.509248ms)
      AssertionError [ERR_ASSERTION]: color-contrast: Elements must meet minimum ratios
✖ failing tests:
"""
GOOGLE = """[ RUN      ] Plant.stops
plant_test.cpp:12: Failure
Expected equality of these values:
[  FAILED  ] Plant.stops (3 ms)
"""


class Still:
    """A witness that reports suspensions of the given durations, the last one repeatedly."""

    def __init__(self, *ms):
        self.ms = list(ms)

    def still_ms(self, since, until):
        assert since <= until
        return self.ms.pop(0) if len(self.ms) > 1 else self.ms[0]


class Judged(unittest.TestCase):
    def setUp(self):
        patched = unittest.mock.patch.multiple(cases, QUIET_S=0.01, QUIET_STILL_MS=float("inf"), PATIENCE_S=60)
        patched.start()
        self.addCleanup(patched.stop)
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def judge(self, goods, still_ms, *arguments, extra=""):
        """Tests that pass at their `goods`-th run: (passed, failed), the output, and how often each ran."""
        tests = "".join(f'add_test("some: passes at run {good}." sh -c [==[{COUNTED}]==] "{self.folder}/ran" {good})\n' for good in goods)
        (self.folder / "CTestTestfile.cmake").write_text(tests + extra)
        said = []
        counts = cases.Judge(["--test-dir", str(self.folder), "-j", "2", *arguments], Still(still_ms), said.append).judge()
        runs = [len(file.read_text()) for good in goods if (file := self.folder / f"ran.{good}").exists()]
        return counts, "".join(said), runs

    def test_a_passing_test_is_run_once_also_on_a_suspended_machine(self):
        for still_ms, folder in ((0, "ran"), (1e6, "still")):
            with self.subTest(folder):
                (self.folder / folder).mkdir()
                self.folder = self.folder / folder
                counts, _, runs = self.judge([1], still_ms)
                self.assertEqual((counts, runs), ((1, 0), [1]))

    def test_the_list_at_the_end_repeats_the_lines_that_name_a_failure(self):
        for output, reasons in ((NODE, ["not ok 2 - a stop holds", "error: |- not within 60000 ms: all drive", "not ok 1 - accepted"]),
                                (SPEC, ["✖ tags and beacons (4044.509248ms)",
                                        "AssertionError [ERR_ASSERTION]: color-contrast: Elements must meet minimum ratios"]),
                                (GOOGLE, ["plant_test.cpp:12: Failure", "[  FAILED  ] Plant.stops (3 ms)"])):
            file = self.folder / "output"
            file.write_text(output)
            extra = f'add_test("fails." sh -c [==[cat "{file}"; exit 1]==])\n'
            _, said, _ = self.judge([1], 0, extra=extra)
            self.assertTrue(said.endswith("\tfails. (Failed)\n" + "".join(f"\t    {line}\n" for line in reasons)), said)

    def test_a_failure_without_suspension_counts_and_is_reported_with_its_output(self):
        counts, said, runs = self.judge([1, 2], 0)
        self.assertEqual((counts, runs), ((1, 1), [1, 1]))
        self.assertIn("not yet, as <said>", said)
        self.assertIn("FAILED:\n\tsome: passes at run 2. (Failed)\n\t    not yet, as <said>\n", said)

    def test_a_failure_during_a_suspension_is_repeated_alone(self):
        counts, said, runs = self.judge([1, 3], cases.STILL_MS + 1)
        self.assertEqual((counts, runs), ((2, 0), [1, 3]))
        self.assertIn(": some: passes at run 3. ... to be evaluated\n", said)
        self.assertIn("repeated, because the machine was suspended for 201 ms of it: some: passes at run 3.", said)
        self.assertNotIn("Failed", said)
        self.assertNotIn("not yet", said)

    def test_a_short_test_is_more_sensitive_to_suspensions_than_a_long_one(self):
        sleeps = 'add_test(long sh -c "sleep 4.5; exit 1")\n'
        counts, said, runs = self.judge([2], cases.STILL_MS - 1, extra=sleeps)
        self.assertEqual((counts, runs), ((1, 1), [2]))
        self.assertIn("199 ms of it: some: passes at run 2.", said)
        self.assertNotIn("of it: long", said)

    def test_a_test_is_run_six_times_at_most(self):
        counts, _, runs = self.judge([99], cases.STILL_MS + 1)
        self.assertEqual((counts, runs), ((0, 1), [6]))

    def test_a_repetition_waits_until_the_machine_runs(self):
        with unittest.mock.patch.multiple(cases, QUIET_STILL_MS=50, QUIET_S=0.1):
            witness = Still(60, 51, 70, 50, 60)
            cases.Judge([], witness, print).until_the_machine_runs(time.monotonic() + 60)
            self.assertEqual(witness.ms, [60])
            cases.Judge([], Still(60), print).until_the_machine_runs(time.monotonic() + 0.2)  # it does not, until the timeout

    def test_after_the_timeout_no_test_is_repeated(self):
        cases.PATIENCE_S = -1
        counts, _, runs = self.judge([99], cases.STILL_MS + 1)
        self.assertEqual((counts, runs), ((0, 1), [1]))

    def test_skipped_disabled_and_unstartable_tests_have_failed(self):
        skipped = 'add_test(skipped sh -c "exit 77")\nset_tests_properties(skipped PROPERTIES SKIP_RETURN_CODE 77)\n'
        disabled = 'add_test(disabled true)\nset_tests_properties(disabled PROPERTIES DISABLED ON)\n'
        nobody = 'add_test(nobody /nonexistent)\n'
        counts, said, _ = self.judge([1], 1e6, extra=skipped + disabled + nobody)
        self.assertEqual(counts, (1, 3))
        self.assertNotIn("repeated", said)

    def suite(self, *lines, code=0):
        """A test that prints what a program of GoogleTest prints."""
        (self.folder / "said").write_text("\n".join(lines) + "\n")
        return f'add_test("zone: Suite" sh -c [==[cat {self.folder}/said; exit {code}]==])\n'

    def test_the_cases_of_a_suite_are_counted_and_timed(self):
        passing = self.suite("[ RUN      ] Suite.a", "[       OK ] Suite.a (12 ms)", "[       OK ] Many/Suite.b/0 (9000 ms)",
                             "[----------] 2 tests from Suite (9012 ms total)")
        counts, said, _ = self.judge([1], 0, extra=passing)
        self.assertEqual(counts, (3, 0))
        self.assertIn("The slowest:\n     9.0 s  zone: Many/Suite.b/0\n", said)

    def test_a_failed_case_counts_once_although_named_twice(self):
        failing = self.suite("[       OK ] Suite.a (12 ms)", "[  FAILED  ] Suite.b, where GetParam() = 4 (3 ms)",
                             "[  FAILED  ] 1 test, listed below:", "[  FAILED  ] Suite.b, where GetParam() = 4", code=1)
        counts, said, _ = self.judge([], 0, extra=failing)
        self.assertEqual(counts, (1, 1))
        self.assertIn("[  FAILED  ] Suite.b, where GetParam() = 4 (3 ms)", said)

    def test_a_crashed_suite_counts_as_failed_beside_its_passed_cases(self):
        self.assertEqual(self.judge([], 0, extra=self.suite("[       OK ] Suite.a (12 ms)", "[ RUN      ] Suite.b", code=139))[0], (1, 1))

    def test_output_longer_than_ctest_keeps_by_default_is_counted(self):
        lines = [f"[       OK ] Suite.case_{i} (0 ms)" for i in range(2000)]
        self.assertEqual(self.judge([], 0, extra=self.suite(*lines))[0], (2000, 0))

    def test_a_run_without_tests_counts_as_one_failure(self):
        self.assertEqual(self.judge([1], 0, "-R", "nothing")[0], (0, 1))

    def test_a_hanging_test_is_ended_and_has_failed(self):
        hangs = 'add_test(hangs sleep 60)\nset_tests_properties(hangs PROPERTIES TIMEOUT 1)\n'
        self.assertEqual(self.judge([1], 0, extra=hangs)[0], (1, 1))


class Witnessed(unittest.TestCase):
    def test_the_witness_measures_the_duration_of_a_suspension(self):
        witness = Witness()
        time.sleep(0.3)
        since = time.monotonic()
        with subprocess.Popen(["sh", "-c", f"sleep 0.5; kill -CONT {os.getpid()}"]):
            os.kill(os.getpid(), signal.SIGSTOP)
        time.sleep(0.1)
        until = time.monotonic()
        self.assertGreater(witness.still_ms(since, until), 400)
        self.assertLess(witness.still_ms(since, until), 1e3 * (until - since))
        self.assertEqual(witness.still_ms(since - 1000, since - 999), 0)

    def test_the_cpu_with_the_longest_suspension_counts(self):
        witness = Witness()
        witness.stills = [(0, 1.0, 1.5), (1, 1.2, 1.5), (0, 3.0, 4.0), (1, 3.0, 4.5)]
        self.assertAlmostEqual(witness.still_ms(1.25, 3.5), 750)
        self.assertAlmostEqual(witness.still_ms(1.25, 9), 1750)


if __name__ == "__main__":
    unittest.main()
