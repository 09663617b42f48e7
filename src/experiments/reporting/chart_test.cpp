#include "cosiva/experiments/reporting/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

namespace cosiva::experiments {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(const std::string& text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(Ticks, are_round_and_enclose_the_values) {
  EXPECT_THAT(ticks(0.0, 10.0, 5), ElementsAre(0.0, 2.0, 4.0, 6.0, 8.0, 10.0));
  EXPECT_THAT(ticks(-0.3, 0.9, 4), ElementsAre(-0.5, 0.0, 0.5, 1.0));
  EXPECT_TRUE(rc::check("any distance", [] {
    const double from = *rc::gen::inRange(-100000, 100000) * 1e-3;
    const double to = from + *rc::gen::inRange(1, 1000000) * 1e-4;
    const int wanted = *rc::gen::inRange(1, 12);
    const auto at = ticks(from, to, wanted);
    RC_ASSERT(at.front() <= from + 1e-6 && at.back() >= to - 1e-6);
    RC_ASSERT(at.size() >= 2U && at.size() <= static_cast<std::size_t>(wanted) + 3U);
  }));
}

TEST(LogTicks, are_round_and_enclose_the_values) {
  EXPECT_THAT(log_ticks(0.1, 4.0), ElementsAre(DoubleEq(0.1), 0.2, 0.5, 1.0, 2.0, 5.0));
  EXPECT_THAT(log_ticks(3.0, 4.0), ElementsAre(2.0, 5.0));
  EXPECT_THAT(log_ticks(0.02, 3000.0), ElementsAre(DoubleEq(0.01), DoubleEq(0.1), 1.0, 10.0, 100.0, 1000.0, 10000.0));
  EXPECT_TRUE(rc::check("any distance", [] {
    const double from = *rc::gen::inRange(1, 100000) * 1e-4;
    const double to = from * (1.0 + *rc::gen::inRange(1, 1000000) * 1e-3);
    const auto at = log_ticks(from, to);
    RC_ASSERT(at.size() >= 2U && at.size() <= 24U);
    RC_ASSERT(at.front() <= from * (1.0 + 1e-9) && at.back() >= to * (1.0 - 1e-9));
  }));
}

TEST(Chart, that_is_a_map_has_equal_units_along_both_axes) {
  // A square of a metre, four points: equal distances in the drawing along x and along y.
  Chart map{{"x [m]", {}, {}}, {"y [m]", {}, {}}, {{"", {0.0, 1.0}, {0.0, 1.0}, Series::Form::points}}};
  map.equal_scale = true;
  const auto sides = [](const std::string& svg) {
    std::vector<double> at;
    for (const char* key : {"cx=\"", "cy=\""}) {
      std::vector<double> ends;
      for (std::size_t found = svg.find(key); found != std::string::npos; found = svg.find(key, found + 1))
        ends.push_back(std::stod(svg.substr(found + 4)));
      at.push_back(std::fabs(ends.at(1) - ends.at(0)));
    }
    return at;
  };
  const auto equal = sides(to_svg(map));
  EXPECT_NEAR(equal[0], equal[1], 0.11);
  EXPECT_GT(equal[1], 200.0);  // and as large as the space allows
  map.equal_scale = false;
  EXPECT_GT(sides(to_svg(map))[0], 2.0 * equal[0]);
}

TEST(Chart, draws_each_series_in_a_separate_colour_and_names_it) {
  const std::string svg =
      to_svg(Chart{{"t [s]", {}, {}},
                   {"speed [m/s]", 0.0, {}},
                   {{"one", {0, 1, 2}, {0.1, 0.4, 0.2}}, {"t<wo", {0, 2}, {0.3, 0.3}, Series::Form::points}}});
  EXPECT_EQ(count(svg, "class=\"line c0\""), 1U);
  EXPECT_EQ(count(svg, "<circle class=\"point c1\""), 2U);
  EXPECT_THAT(svg, HasSubstr("t&lt;wo"));
  EXPECT_THAT(svg, HasSubstr("speed [m/s]"));
}

TEST(Chart, draws_the_ground_completely_beneath_all_series_without_a_name) {
  Chart map{{"x [m]", {}, {}}, {"y [m]", {}, {}}, {{"way", {0, 1}, {0, 1}}}};
  map.equal_scale = true;
  const std::string open = to_svg(map);
  EXPECT_EQ(count(open, "ground"), 0U);
  map.ground = {{"", {0, 10}, {0, 0}}, {"", {10, 10}, {0, 10}}};
  const std::string svg = to_svg(map);
  EXPECT_EQ(count(svg, "class=\"line ground\""), 2U);
  EXPECT_LT(svg.find("class=\"line ground\""), svg.find("class=\"line c0\""));
  EXPECT_EQ(count(svg, "<rect class=\"bar"), 1U);
  EXPECT_THAT(svg, HasSubstr(">10</text>"));  // on the axes, where the path alone ends at 1
  EXPECT_THAT(open, Not(HasSubstr(">10</text>")));
}

TEST(Chart, draws_a_band_around_its_line_and_dashes_on_request) {
  Series curve{"error", {1, 10, 100}, {2, 3, 4}};
  curve.low = {1, 2, 3};
  curve.high = {3, 4, 5};
  Series limit{"limit", {1, 10, 100}, {1, 1, 1}};
  limit.dashed = true;
  Chart chart{{"pitch [m]", {}, {}, true}, {"error [mm]", 0.0, {}}, {curve, limit}};
  const std::string svg = to_svg(chart);
  EXPECT_EQ(count(svg, "opacity=\"0.18\""), 1U);
  EXPECT_EQ(count(svg, "stroke-dasharray"), 1U);
  // All decades have the same width.
  const std::string path = svg.substr(svg.find("class=\"line c0\" d=\"M72 "));
  EXPECT_THAT(path, HasSubstr("L388 "));
  EXPECT_THAT(path, HasSubstr("L704 "));
}

TEST(Chart, leaves_out_of_a_logarithmic_axis_values_not_over_zero) {
  const std::string svg =
      to_svg(Chart{{"x", {}, {}, true}, {"y", {}, {}, true}, {{"", {0, 1, 10}, {1, 2, 3}}, {"", {1, 10}, {0, -1}}}});
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(Chart, leaves_out_non_finite_values_and_breaks_its_line_there) {
  const std::string svg = to_svg(Chart{{"x", {}, {}}, {"y", {}, {}}, {{"", {0, 1, 2, 3}, {1, std::nan(""), 2, 3}}}});
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  const std::string path = svg.substr(svg.find("class=\"line"));
  EXPECT_EQ(count(path.substr(0, path.find("/>")), "M"), 2U);
}

TEST(Chart, of_no_value_or_one_value_is_a_valid_image) {
  for (const auto& values : {std::vector<double>{}, {5.0}, {5.0, 5.0}}) {
    const std::string svg = to_svg(Chart{{"x", {}, {}}, {"y", {}, {}}, {{"", values, values}}});
    EXPECT_THAT(svg, HasSubstr("</svg>"));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
    EXPECT_THAT(to_svg(Histogram{{"x", {}, {}}, "n", values, 10}), Not(HasSubstr("nan")));
  }
}

TEST(Chart, of_a_million_points_keeps_only_their_peaks) {
  Series series{"", {}, {}};
  for (int i = 0; i < 1'000'000; ++i) {
    series.x.push_back(i);
    series.y.push_back(i == 654'321 ? 7.0 : 0.0);
  }
  const std::string svg = to_svg(Chart{{"x", {}, {}}, {"y", 0.0, 7.0}, {series}});
  EXPECT_LT(svg.size(), 100'000U);
  const std::string top = " 16L";  // the upper edge of the frame
  EXPECT_THAT(svg, HasSubstr(top));
}

TEST(Histogram, counts_every_value_once_including_the_ends) {
  const std::string svg = to_svg(Histogram{{"x", 0.0, 4.0}, "n", {0.0, 0.5, 1.0, 3.9, 4.0, 9.0}, 4});
  EXPECT_THAT(svg, HasSubstr("0 … 1: 2"));
  EXPECT_THAT(svg, HasSubstr("1 … 2: 1"));
  EXPECT_THAT(svg, HasSubstr("3 … 4: 2"));
}

TEST(Bars, are_proportional_to_their_values) {
  const std::string svg = to_svg(Bars{"wait [s]", {{"X1", 10.0}, {"X2", 5.0}}});
  EXPECT_THAT(svg, HasSubstr("width=\"470\""));
  EXPECT_THAT(svg, HasSubstr("width=\"235\""));
}

}  // namespace
}  // namespace cosiva::experiments
