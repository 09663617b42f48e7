#!/usr/bin/env python3
"""Tests of the build scripts: grouping of sources into units, input of clang-tidy, list of slow units."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(HERE), str(HERE.parent / "cmake")]

import slowest_units
import tidy
import unity_groups


def source(own="", rest=""):
    return f"namespace cosiva {{\nnamespace {{\n{own}\n}}  // namespace\n{rest}\n}}  // namespace cosiva\n"


class UnityGroups(unittest.TestCase):
    def groups(self, *texts, most=12):
        return unity_groups.groups_of(texts, most)

    def test_sources_with_different_helper_names_are_in_one_unit(self):
        self.assertEqual(self.groups(source("int one() { return 1; }"), source("int two() { return 2; }")), [0, 0])

    def test_sources_that_declare_the_same_name_are_in_different_units(self):
        for own in ("int helper() { return 1; }", "constexpr int helper = 1;", "struct helper {};", "class helper : B {};",
                    "enum class helper { a };", "template <class T>\nT helper(const T& t) { return t; }", "int helper[2];",
                    "using helper = int;", "std::vector<int> helper{1};"):
            with self.subTest(own):
                self.assertEqual(self.groups(source(own), source("int other();"), source(own)), [0, 0, 1])

    def test_a_later_source_using_the_name_of_an_earlier_helper_is_separated(self):
        self.assertEqual(self.groups(source("double step;"), source("", "void f() { double step = 1.0; }")), [0, 1])
        self.assertEqual(self.groups(source("", "void f() { double step = 1.0; }"), source("double step;")), [0, 0])

    def test_a_macro_counts_as_a_name(self):
        self.assertEqual(self.groups("#define LIMIT 3\n", source("", "int LIMIT_OF(int LIMIT);")), [0, 1])

    def test_members_std_names_comments_and_strings_do_not_clash(self):
        own = source("int find() { return 1; }\nint size;")
        rest = 'int f() { return v.size() + p->size + std::find(v); /* find */ }  // size\nauto t = "find";'
        self.assertEqual(self.groups(own, source("", rest)), [0, 0])

    def test_local_declarations_of_a_helper_do_not_clash(self):
        self.assertEqual(self.groups(source("int f() { int inner = 1; return inner; }"), source("", "int g(int inner);")), [0, 0])

    def test_helpers_of_different_namespaces_do_not_clash(self):
        zone, aiv = (source("int helper;").replace("cosiva", f"cosiva::{name}") for name in ("zone", "aiv"))
        self.assertEqual(self.groups(zone, aiv), [0, 0])
        self.assertEqual(self.groups(zone, zone.replace("zone", "zone::lif")), [0, 1])
        self.assertEqual(self.groups(source("int helper;"), zone), [0, 1])

    def test_test_cases_are_in_one_unit(self):
        self.assertEqual(self.groups(source('TEST(A, b) { EXPECT_EQ(1, 1); }'), source('TEST(A, c) { EXPECT_EQ(1, 1); }')), [0, 0])

    def test_a_unit_has_a_maximum_size(self):
        self.assertEqual(self.groups(*["int x;"] * 5, most=2), [0, 0, 1, 1, 2])

    def test_a_source_with_slow_library_templates_counts_as_several(self):
        slow = "Eigen::Vector2d x;"
        self.assertEqual(self.groups(slow, slow, slow, slow, "int x;", most=13), [0, 0, 1, 1, 0])


class TidyTasks(unittest.TestCase):
    """The input of clang-tidy: sources a to f of the product, and the fuzz targets g and h."""

    def setUp(self):
        self.sources = [self.source(f"src/{name}.cpp") for name in "abcdef"] + [self.source(f"fuzz/{name}.cpp") for name in "gh"]
        self.read_text, tidy.read_text = tidy.read_text, lambda path: source(f"int {path.stem};")

    def tearDown(self):
        tidy.read_text = self.read_text

    @staticmethod
    def source(path, *flags):
        file = tidy.ROOT / path
        return tidy.Source(file, ["c++", *flags, "-o", f"{file.name}.o", "-c", str(file)], file.stem)

    def runs(self, changed="", known=()):
        files = {tidy.ROOT / f"src/{name}.cpp" for name in changed}
        return sorted(tuple(task.passes) for task in tidy.tasks_for(self.sources, files, lambda name: name in known))

    def test_without_cache_the_product_and_the_programs_beside_it_are_one_unit_each(self):
        self.assertEqual(self.runs(), [tuple(f"{name}.unit" for name in "abcdef"), ("g.unit", "h.unit")])

    def test_a_source_that_differs_from_main_is_checked_separately(self):
        known = {f"{name}.unit" for name in "abcdefgh"}
        self.assertEqual(self.runs("b", known), [("b",)])
        self.assertEqual(self.runs("b", known | {"b"}), [])

    def test_new_sources_are_one_unit(self):
        known = {f"{name}.unit" for name in "abcdgh"}
        self.assertEqual(self.runs("", known), [("e.unit", "f.unit")])

    def test_a_single_new_source_passes_as_itself(self):
        self.assertEqual(self.runs("", {f"{name}.unit" for name in "abcdegh"}), [("f",)])

    def test_sources_that_passed_separately_are_skipped(self):
        self.assertEqual(self.runs("", set("abcdefgh")), [])

    def test_sources_with_helpers_of_the_same_name_are_in_different_units(self):
        tidy.read_text = lambda path: source("int helper;")
        self.assertEqual(len(self.runs()), 8)

    def findings(self, error, *refused):
        """What a unit of all sources is found and passed to have, when those with all the sources `refused` do not pass."""
        passed = []

        def run_of(task):
            code = int(set(refused) <= set(task.passes))
            return subprocess.CompletedProcess([], code, stdout=f"error: {error}" if code else "")

        unit = tidy.Task(self.sources, list("abcdefgh"))
        found = tidy.findings_of(unit, run_of, passed.append)
        return ["".join(task.passes) for task, _ in found], "".join(passed)

    def test_a_unit_in_which_two_sources_mean_different_things_by_one_name_is_divided_until_it_compiles(self):
        self.assertEqual(self.findings("ambiguous [clang-diagnostic-error]", "a", "b"), ([], "abcdefgh"))

    def test_a_source_that_does_not_compile_is_found_in_its_unit(self):
        self.assertEqual(self.findings("ambiguous [clang-diagnostic-error]", "c"), (["c"], "abdefgh"))

    def test_a_unit_with_another_finding_is_not_divided(self):
        self.assertEqual(self.findings("[misc-const-correctness]", "c"), (["abcdefgh"], ""))

    def test_a_unit_has_the_folders_and_definitions_of_all_its_sources(self):
        sources = [self.source("src/a.cpp", "-Ia"), self.source("src/b.cpp", "-Ia", "-isystem", "eigen", "-DB=1")]
        words = tidy.unit_words(sources, "unit.cpp")
        self.assertEqual(sorted(words), sorted(["c++", "-Ia", "-isystem", "eigen", "-DB=1", "-o", "a.cpp.o", "-c", "unit.cpp"]))
        self.assertEqual(words[words.index("-isystem") + 1], "eigen")

    def test_entry_points_of_a_unit_have_different_names(self):
        text = tidy.unit_text(self.sources[6:])
        self.assertIn("#define main main_0  //", text)
        self.assertIn("#define LLVMFuzzerTestOneInput LLVMFuzzerTestOneInput_1  //", text)
        self.assertEqual(text.count("#include"), 2)
        self.assertNotIn("#define", tidy.unit_text(self.sources[:6]))


class SlowestUnits(unittest.TestCase):
    def test_units_are_listed_by_compile_time_since_a_given_time(self):
        with tempfile.TemporaryDirectory() as folder:
            build = pathlib.Path(folder) / "release"
            build.mkdir()
            for name, line, written in (("a", "0m1.5s 0m0.5s", 100), ("b", "1m2.00s 0m0.25s", 100), ("old", "9m0s 0m0s", 10)):
                file = build / f"{name}.cpp.o.cpu"
                file.write_text(f"0m0.00s 0m0.00s\n{line}\n")
                os.utime(file, (written, written))
            self.assertEqual(slowest_units.slowest([build], 50), [(62.25, "release/b.cpp"), (2.0, "release/a.cpp")])

    def test_a_unit_with_a_large_share_of_the_time_is_reported_whatever_the_machine(self):
        even = [(2.0, f"u{i}") for i in range(50)]
        self.assertEqual(slowest_units.over(even, len(even), 0.03), [])
        for slowness in (1.0, 40.0):
            units = [(seconds * slowness, name) for seconds, name in [(6.0, "heavy"), (2.5, "fair"), *even]]
            self.assertEqual(slowest_units.over(units, len(units), 0.03), ["heavy"])

    def test_the_share_is_not_judged_where_ccache_had_most_units(self):
        units = [(60.0, "heavy"), *[(0.02, f"u{i}") for i in range(50)]]
        self.assertEqual(slowest_units.over(units, len(units), 0.03), [])

    def test_the_share_is_not_judged_where_few_units_of_the_builds_were_compiled_again(self):
        self.assertEqual(slowest_units.over([(60.0, "heavy"), (2.0, "light")], 400, 0.03), [])


if __name__ == "__main__":
    unittest.main()
