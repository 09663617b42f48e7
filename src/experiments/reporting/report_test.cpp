#include "cosiva/experiments/reporting/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Report, is_one_self_contained_page) {
  Report report{"Traffic on <lacet4>", "12 AIVs"};
  report.heading("Jobs & waits")
      .paragraph("All jobs.")
      .metadata({{"0", "collisions"}, {"3", "deadlocks", true}})
      .table({"crossing", "wait [s]"}, {{"X1", "1.5"}})
      .figure("<svg></svg>", "heat")
      .verbatim("cosiva traffic --seed 1");
  const std::string html = report.html();
  EXPECT_THAT(html, HasSubstr("<title>Traffic on &lt;lacet4&gt;</title>"));
  EXPECT_THAT(html, HasSubstr("<h2>Jobs &amp; waits</h2>"));
  EXPECT_THAT(html, HasSubstr("<div class=\"alarming\"><b>3</b><span>deadlocks</span>"));
  EXPECT_THAT(html, HasSubstr("<tr><td>X1</td><td>1.5</td></tr>"));
  EXPECT_THAT(html, HasSubstr("<figure><svg></svg><figcaption>heat"));
  for (const char* outside : {"src=", "href=", "http://", "https://", "url("})
    EXPECT_THAT(html, Not(HasSubstr(outside)));
}

TEST(Report, with_a_row_that_is_too_short_is_a_programming_error) {
  Report report{"t"};
  EXPECT_DEATH(report.table({"a", "b"}, {{"1"}}), "");
}

}  // namespace
}  // namespace cosiva::experiments
