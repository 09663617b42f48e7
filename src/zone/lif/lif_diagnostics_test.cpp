#include "cosiva/zone/lif/lif_diagnostics.h"

#include <gtest/gtest.h>

#include <string>

namespace cosiva::zone::lif {
namespace {

TEST(JsonLocation, is_readable_from_the_outermost_object_inwards) {
  const JsonLocation root{};
  EXPECT_EQ(root.text(), "");
  const JsonLocation layouts{&root, "layouts", 0};
  EXPECT_EQ(layouts.text(), "layouts");
  const JsonLocation first{&layouts, {}, 7};
  EXPECT_EQ(first.text(), "layouts[7]");
  const JsonLocation id{&first, "layoutId", 0};
  EXPECT_EQ(id.text(), "layouts[7].layoutId");
  const JsonLocation named{nullptr, "zone", 0};
  EXPECT_EQ((JsonLocation{&named, "x", 0}.text()), "zone.x");
}

TEST(LifDiagnostics, are_in_the_order_of_their_first_appearance) {
  LifDiagnostics diagnostics;
  EXPECT_TRUE(diagnostics.take().empty());
  diagnostics.add(Diagnostic::Kind::lost, "b", "two");
  diagnostics.add(Diagnostic::Kind::mended, "a", "one");
  diagnostics.add(Diagnostic::Kind::lost, "c", "two");
  const auto all = diagnostics.take();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].kind, Diagnostic::Kind::lost);
  EXPECT_EQ(all[0].location, "b");
  EXPECT_EQ(all[0].text, "two (2 times, also at c)");
  EXPECT_EQ(all[1].kind, Diagnostic::Kind::mended);
  EXPECT_EQ(all[1].location, "a");
  EXPECT_EQ(all[1].text, "one");
}

TEST(LifDiagnostics, name_three_locations_and_count_all) {
  LifDiagnostics diagnostics;
  for (const char* location : {"a", "b", "c"}) diagnostics.add(Diagnostic::Kind::lost, location, "text");
  EXPECT_EQ(diagnostics.take()[0].text, "text (3 times, also at b, c)");
  diagnostics.add(Diagnostic::Kind::lost, "d", "text");
  EXPECT_EQ(diagnostics.take()[0].text, "text (4 times, also at b, c, …)");
}

TEST(LifDiagnostics, do_not_repeat_the_first_location) {
  LifDiagnostics diagnostics;
  diagnostics.add(Diagnostic::Kind::lost, "a", "text");
  diagnostics.add(Diagnostic::Kind::lost, "a", "text");
  EXPECT_EQ(diagnostics.take()[0].text, "text (2 times)");
}

TEST(LifDiagnostics, of_one_sort_are_one_whatever_their_texts) {
  LifDiagnostics diagnostics;
  diagnostics.add(Diagnostic::Kind::lost, "a", "first text", "sort");
  diagnostics.add(Diagnostic::Kind::lost, "b", "other text", "sort");
  ASSERT_EQ(diagnostics.take().size(), 1U);
  EXPECT_EQ(diagnostics.take()[0].text, "first text (2 times, also at b)");
}

TEST(LifDiagnostics, beyond_two_hundred_sorts_are_one_that_counts_them) {
  LifDiagnostics diagnostics;
  for (int i = 0; i < 200; ++i)
    diagnostics.add(Diagnostic::Kind::lost, "at" + std::to_string(i), "text " + std::to_string(i));
  ASSERT_EQ(diagnostics.take().size(), 200U);
  EXPECT_EQ(diagnostics.take().back().text, "text 199");
  diagnostics.add(Diagnostic::Kind::lost, "x", "further");
  auto all = diagnostics.take();
  ASSERT_EQ(all.size(), 201U);
  EXPECT_EQ(all.back().kind, Diagnostic::Kind::notice);
  EXPECT_EQ(all.back().location, "x");
  EXPECT_EQ(all.back().text, "the further diagnostics of this file do not fit here");
  diagnostics.add(Diagnostic::Kind::lost, "y", "still further");
  diagnostics.add(Diagnostic::Kind::lost, "z", "and further");
  all = diagnostics.take();
  ASSERT_EQ(all.size(), 201U);
  EXPECT_EQ(all.back().text, "the further diagnostics of this file do not fit here (3 times)");
  // Those known before are still counted where they are.
  diagnostics.add(Diagnostic::Kind::lost, "late", "text 0");
  EXPECT_EQ(diagnostics.take()[0].text, "text 0 (2 times, also at late)");
}

}  // namespace
}  // namespace cosiva::zone::lif
