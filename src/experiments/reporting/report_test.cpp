#include "cosiva/experiments/reporting/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

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

TEST(Report, has_a_style_for_each_class_of_its_elements) {
  Report report{"t"};
  report.metadata({{"3", "deadlocks", true}}).table({"a", "b"}, {{"1", "2"}}).figure("<svg></svg>", "f").page_break();
  const std::string html = report.html();
  const std::size_t body = html.find("<body");
  ASSERT_NE(body, std::string::npos);
  const std::string styles = html.substr(0, body);
  std::size_t classes = 0;
  const std::string attribute = "class=\"";
  for (std::size_t at = html.find(attribute, body); at != std::string::npos; at = html.find(attribute, at + 1)) {
    const std::size_t begin = at + attribute.size();
    const std::string name = html.substr(begin, html.find('"', begin) - begin);
    EXPECT_THAT(styles, HasSubstr("." + name)) << name;
    ++classes;
  }
  EXPECT_GE(classes, 3U);
}

TEST(Report, with_a_row_that_is_too_short_is_a_programming_error) {
  Report report{"t"};
  EXPECT_DEATH(report.table({"a", "b"}, {{"1"}}), "");
}

}  // namespace
}  // namespace cosiva::experiments
