#include "cosiva/zone/opendrive/report.h"

#include <gmock/gmock.h>

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

TEST(Report, keeps_twenty_of_a_topic_and_counts_the_others) {
  Report report;
  EXPECT_THAT(report.diagnostics(), IsEmpty());
  EXPECT_FALSE(report.full("lanes that kink"));
  for (int i = 0; i < 19; ++i) report.add(Diagnostic::Kind::mended, "lanes that kink", std::to_string(i), "kinks");
  EXPECT_FALSE(report.full("lanes that kink"));
  report.add(Diagnostic::Kind::mended, "lanes that kink", "19", "kinks");
  EXPECT_TRUE(report.full("lanes that kink"));
  EXPECT_FALSE(report.full("other lanes"));
  ASSERT_EQ(report.diagnostics().size(), 20U);
  EXPECT_EQ(report.diagnostics().back().location, "19");

  report.add(Diagnostic::Kind::mended, "lanes that kink", "20", "kinks");
  report.add(Diagnostic::Kind::lost, "roads without a plan view", "road 1", "has none");
  report.add(Diagnostic::Kind::mended, "lanes that kink", "21", "kinks");
  const auto all = report.diagnostics();
  ASSERT_EQ(all.size(), 22U);
  EXPECT_EQ(all[20].location, "road 1");
  EXPECT_EQ(all[20].kind, Diagnostic::Kind::lost);
  EXPECT_EQ(all[21].kind, Diagnostic::Kind::mended);
  EXPECT_EQ(all[21].location, "file");
  EXPECT_EQ(all[21].text, "2 more lanes that kink");
}

TEST(Report, counts_by_topic_and_by_the_begin_of_the_topic) {
  Report report;
  report.count("signals");
  report.count("signals", 4);
  report.count("lane type rail");
  report.count("lane type biking", 3);
  EXPECT_EQ(report.counted("signals"), 5U);
  EXPECT_EQ(report.counted("objects"), 0U);
  EXPECT_THAT(report.counted_under("lane type "), ElementsAre(Pair("biking", 3U), Pair("rail", 1U)));
  EXPECT_THAT(report.counted_under("road type "), IsEmpty());
}

TEST(Metres, are_in_millimetres_below_a_decimetre) {
  EXPECT_EQ(metres(1.5), "1.50 m");
  EXPECT_EQ(metres(-12.345), "-12.35 m");
  EXPECT_EQ(metres(0.1), "0.10 m");
  EXPECT_EQ(metres(0.05), "50.00 mm");
  EXPECT_EQ(metres(-0.0125), "-12.50 mm");
  EXPECT_EQ(metres(1e-4), "0.10 mm");
  EXPECT_EQ(metres(5e-5), "0.0500 mm");
  EXPECT_EQ(metres(0.0), "0.0000 mm");
}

}  // namespace
}  // namespace cosiva::zone::opendrive
