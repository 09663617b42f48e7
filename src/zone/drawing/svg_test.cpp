#include "cosiva/zone/drawing/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Shape = Primitive::Shape;

TrafficZone zone_of(std::vector<Circuit::Part> parts) {
  return {"z", testing::circuit(std::move(parts)), {}, {}, {}, {}, {}, {}, {}, {}};
}
TrafficZone plain_zone() { return zone_of({testing::part("a", testing::section({}, 2.0))}); }

/// Fixes the drawing's edges: the longer side is 960 px.
Primitive frame(double width_m, double height_m) {
  return {Shape::polygon, "crossing", {{0.0, 0.0}, {width_m, 0.0}, {width_m, height_m}, {0.0, height_m}}, 0.0, {}};
}

std::string svg_of(std::vector<Primitive> primitives) { return to_svg(plain_zone(), primitives); }

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(Svg, fits_the_longer_side_of_the_map_into_960_pixels_between_its_margins) {
  // 2 m by 1 m: 480 px a metre; margins of 36 px all round, 56 px of head and 64 px of foot.
  const std::string wide = svg_of({frame(2.0, 1.0)});
  EXPECT_THAT(wide, HasSubstr("viewBox=\"0 0 1032 672\" width=\"1032\" height=\"672\""));
  EXPECT_THAT(wide, HasSubstr("points=\"36,572 996,572 996,92 36,92\""));
  const std::string high = svg_of({frame(1.0, 2.0)});
  EXPECT_THAT(high, HasSubstr("viewBox=\"0 0 760 1152\""));
  // The map is at the centre of a drawing that is as wide as its legend needs: 480 px in 760 px.
  EXPECT_THAT(high, HasSubstr("points=\"140,1052 620,1052 620,92 140,92\""));
}

TEST(Svg, has_the_zone_s_name_and_its_numbers_in_the_head) {
  TrafficZone zone = plain_zone();
  const std::string one = to_svg(zone, {frame(2.0, 1.0)});
  EXPECT_THAT(one, HasSubstr("<text x=\"36\" y=\"40\" font-size=\"24\""));
  EXPECT_THAT(one, HasSubstr("<text x=\"996\" y=\"40\" font-size=\"14\""));
  EXPECT_THAT(one, HasSubstr(">1 section, 2 m, 0 crossings, 0 tags</text>"));
  TrafficZone two =
      zone_of({testing::part("a", testing::section({}, 2.0)), testing::part("b", testing::section({}, 0.5))});
  two.crossings = {{"X1", {}, {{0, 0.0, 0.1}}}};
  two.tags = {{1, {0, 0.5}}};
  EXPECT_THAT(to_svg(two, {frame(2.0, 1.0)}), HasSubstr(">2 sections, 2.5 m, 1 crossing, 1 tag</text>"));
}

TEST(Svg, draws_sizes_to_scale) {
  const std::string svg = svg_of({frame(2.0, 1.0),
                                  {Shape::disc, "tag", {{1.0, 0.5}}, 0.05, "tag 1"},
                                  {Shape::polyline, "road", {{0.5, 0.5}, {1.5, 0.5}}, 0.1, "a"},
                                  {Shape::polyline, "line", {{0.5, 0.5}, {1.5, 0.5}}, 0.02, {}, 0.0, "straight"}});
  EXPECT_THAT(svg, HasSubstr("<circle cx=\"516\" cy=\"332\" r=\"24\"><title>tag 1</title></circle>"));
  EXPECT_THAT(svg, HasSubstr("stroke-width=\"48\" stroke-linecap=\"round\"><title>a</title>"));
  // The dash is four strokes long with three of space.
  EXPECT_THAT(svg, HasSubstr("stroke-width=\"9.6\" stroke-dasharray=\"38.4 28.8\""));
}

TEST(Svg, keeps_what_would_be_too_thin_to_see_visible) {
  const auto thin = [](Shape shape, const char* layer) {
    return svg_of({frame(2.0, 1.0), {shape, layer, {{0.0, 0.5}, {2.0, 0.5}}, 1e-5, "thin"}});
  };
  EXPECT_THAT(thin(Shape::polyline, "road"), HasSubstr("stroke-width=\"4.5\" stroke-linecap=\"round\""));
  EXPECT_THAT(thin(Shape::polyline, "line"), HasSubstr("stroke-width=\"1.4\" stroke-linecap=\"round\""));
  EXPECT_THAT(thin(Shape::disc, "tag"), HasSubstr("r=\"2.5\""));
  EXPECT_THAT(thin(Shape::disc, "station"), HasSubstr("r=\"2.5\""));
  EXPECT_THAT(thin(Shape::disc, "beacon"), HasSubstr("r=\"0\""));
}

TEST(Svg, hatches_the_roads_of_closed_sections) {
  TrafficZone zone = zone_of({testing::part("a", testing::section({}, 2.0)),
                              testing::part("b", testing::section({0.0, 1.0, 0.0}, 2.0)),
                              testing::part("c", testing::section({0.0, 2.0, 0.0}, 2.0))});
  zone.closed = {0, 2};
  const auto svg_with = [&](double road_m) {
    return to_svg(zone, {frame(2.0, 1.0),
                         {Shape::polyline, "road", {{0.5, 0.25}, {1.5, 0.25}}, road_m, "a"},
                         {Shape::polyline, "road", {{0.5, 0.5}, {1.5, 0.5}}, road_m, "b"},
                         {Shape::polyline, "road", {{0.5, 0.75}, {1.5, 0.75}}, road_m, "c"},
                         {Shape::polyline, "line", {{0.5, 0.5}, {1.5, 0.5}}, road_m, "a"}});
  };
  const std::string svg = svg_with(0.1);
  EXPECT_EQ(count(svg, "stroke-opacity=\"0.6\" stroke-dasharray=\"5.76 14.4\""), 2U) << "0.12 and 0.3 of 48 px";
  EXPECT_EQ(count(svg, "<title>a</title>"), 3U) << "the road, the hatching, the line";
  EXPECT_EQ(count(svg, "<title>b</title>"), 1U);
  EXPECT_EQ(count(svg, "<title>c</title>"), 2U);
  EXPECT_EQ(count(svg_with(1e-5), "stroke-width=\"4\""), 2U);
}

TEST(Svg, writes_names_where_they_are_legible_and_inside_the_drawing) {
  const auto named = [](double x_m, double size_m, const std::string& name) {
    return svg_of({frame(2.0, 1.0), {Shape::text, "label", {{x_m, 0.5}}, size_m, name}});
  };
  EXPECT_THAT(named(1.0, 0.05, "X1"), HasSubstr("<text x=\"516\" y=\"332\" font-size=\"24\""));
  EXPECT_THAT(named(1.0, 0.05, "X1"), HasSubstr("stroke-width=\"3\" paint-order=\"stroke\">X1</text>"));
  EXPECT_THAT(named(1.0, 0.00834, "X1"), HasSubstr(">X1</text>"));       // 4.003 px
  EXPECT_THAT(named(1.0, 0.00832, "X1"), Not(HasSubstr(">X1</text>")));  // 3.994 px
  // A letter is 0.56 of the size wide: 20 letters of 24 px are 268.8 px, half of it to each side.
  const std::string long_name(20, 'n');
  EXPECT_THAT(named(0.0, 0.05, long_name), HasSubstr("<text x=\"134.4\" y=\"332\""));
  EXPECT_THAT(named(2.0, 0.05, long_name), HasSubstr("<text x=\"897.6\" y=\"332\""));
  EXPECT_THAT(named(0.0, 0.05, std::string(100, 'n')), HasSubstr("<text x=\"672\" y=\"332\"")) << "wider than all";
}

TEST(Svg, explains_its_layers_in_a_legend_of_as_many_rows_as_necessary) {
  const auto disc = [](const char* layer, const char* kind = "") {
    return Primitive{Shape::disc, layer, {{1.0, 0.5}}, 0.0, {}, 0.0, kind};
  };
  const auto line = [](const char* kind) {
    return Primitive{Shape::polyline, "line", {{0.0, 0.5}, {2.0, 0.5}}, 0.0, {}, 0.0, kind};
  };
  const std::string one = svg_of({frame(2.0, 1.0), disc("tag")});
  // "crossing" takes 52 px and 7.5 px for each of its 8 letters; the row is 34 px above the lower edge.
  EXPECT_THAT(one, HasSubstr("<rect x=\"38\" y=\"631\" width=\"16\" height=\"14\" rx=\"2\""));
  EXPECT_THAT(one, HasSubstr("<text x=\"62\" y=\"643\" font-size=\"14\" fill=\"#44525f\">crossing</text>"));
  EXPECT_THAT(one, HasSubstr("<circle cx=\"158\" cy=\"638\" r=\"6\" fill=\"#2563c9\""));
  EXPECT_THAT(one, HasSubstr("<text x=\"174\" y=\"643\" font-size=\"14\" fill=\"#44525f\">tag</text>"));

  const std::string all = svg_of({frame(2.0, 1.0), line("straight"), line("arc"), line("clothoid"), disc("beacon"),
                                  disc("pivot"), disc("tag"), disc("station", "charger"), disc("station", "stop")});
  // Crossing, straight, arc, clothoid, beacon and "turn on the spot" end at 715.5 px; "tag" would end at 790 px, beyond
  // the 756 px that the scale bar leaves.
  EXPECT_THAT(all, HasSubstr("viewBox=\"0 0 1032 696\""));
  EXPECT_THAT(all, HasSubstr("<path d=\"M148 638h20\" stroke=\"#5b6b7d\" stroke-width=\"3\""));
  EXPECT_THAT(all, HasSubstr("<text x=\"286\" y=\"643\" font-size=\"14\" fill=\"#44525f\">arc</text>"));
  EXPECT_THAT(all, HasSubstr("<circle cx=\"456.5\" cy=\"638\" r=\"6\" fill=\"#6d7b89\""));
  EXPECT_THAT(all, HasSubstr("<circle cx=\"553.5\" cy=\"638\" r=\"6\" fill=\"#fbfcfd\""));
  // The second row begins at the left again.
  EXPECT_THAT(all, HasSubstr("<circle cx=\"46\" cy=\"662\" r=\"6\" fill=\"#2563c9\""));
  EXPECT_THAT(all, HasSubstr("<text x=\"136.5\" y=\"667\" font-size=\"14\" fill=\"#44525f\">charger</text>"));
  EXPECT_THAT(all, HasSubstr("<text x=\"241\" y=\"667\" font-size=\"14\" fill=\"#44525f\">station</text>"));
}

TEST(Svg, shows_closed_sections_in_the_legend_as_a_fence) {
  TrafficZone zone = plain_zone();
  zone.closed = {0};
  const std::string svg =
      to_svg(zone, {frame(2.0, 1.0), {Shape::polyline, "road", {{0.0, 0.0}, {2.0, 0.0}}, 0.1, "a"}});
  EXPECT_THAT(svg, HasSubstr("h20\" stroke=\"#b42318\" stroke-width=\"14\" stroke-opacity=\"0.6\" "
                             "stroke-dasharray=\"2 4\""));
}

TEST(Svg, has_the_longest_round_scale_bar_that_has_room) {
  for (const double width_m : {0.003, 0.01, 0.05, 0.3, 1.0, 2.0, 960.0 / 180.0, 6.0, 20.0, 50.0, 300.0, 4000.0}) {
    const double px_per_m = 960.0 / width_m;
    double bar_m = 0.0;
    for (int power = -6; power <= 4; ++power) {
      for (const double digit : {1.0, 2.0, 5.0}) {
        const double length_m = digit * std::pow(10.0, power);
        if (length_m * px_per_m <= 180.0 * (1.0 + 1e-12)) bar_m = std::max(bar_m, length_m);
      }
    }
    const std::string svg = svg_of({frame(width_m, 0.5 * width_m)});
    // Between two strokes of 10 px: "M<left> 633v10M<left> 638H<right>M<right> 633v10".
    const auto at = svg.find(" 633v10M");
    ASSERT_NE(at, std::string::npos);
    const double left_px = std::stod(svg.substr(at + 8));
    EXPECT_NEAR(996.0 - left_px, bar_m * px_per_m, 0.02) << width_m;
    EXPECT_THAT(svg, HasSubstr(" 638H996M996 633v10\""));
    const auto end = svg.rfind(" m</text>");
    EXPECT_NEAR(std::stod(svg.substr(svg.rfind('>', end) + 1)), bar_m, 1e-3 * bar_m) << width_m;
  }
  // 0.2 m at 480 px a metre; its text ends 10 px before it.
  EXPECT_THAT(svg_of({frame(2.0, 1.0)}), HasSubstr("<text x=\"890\" y=\"643\" font-size=\"14\""));
}

TEST(Svg, merges_the_lines_of_a_zone_with_more_than_five_thousand) {
  const auto lines = [](int number) {
    std::vector<Primitive> primitives{frame(2.0, 1.0)};
    for (int i = 0; i < number; ++i)
      primitives.push_back({Shape::polyline, "line", {{0.5, 0.5}, {1.0, 0.5}, {1.5, 0.75}}, 0.02, {}});
    return svg_of(primitives);
  };
  EXPECT_EQ(count(lines(5000), "<polyline"), 5000U);
  const std::string merged = lines(5001);
  EXPECT_EQ(count(merged, "<polyline"), 0U);
  EXPECT_EQ(count(merged, "M276,332L516,332L756,212"), 5001U);
  EXPECT_THAT(merged, HasSubstr("<path stroke-width=\"9.6\" stroke-linecap=\"round\""));
}

TEST(Svg, leaves_out_what_it_does_not_know) {
  EXPECT_EQ(count(svg_of({frame(2.0, 1.0), {Shape::disc, "star", {{1.0, 0.5}}, 0.1, {}}}), "<circle"), 0U);
  EXPECT_EQ(count(svg_of({frame(2.0, 1.0), {Shape::disc, "tag", {}, 0.1, {}}}), "<circle"), 0U);
}

TEST(Svg, keeps_merged_lines_visible) {
  const auto merged = [](const char* layer) {
    std::vector<Primitive> primitives{frame(2.0, 1.0)};
    for (int i = 0; i < 5001; ++i) primitives.push_back({Shape::polyline, layer, {{0.5, 0.5}, {1.0, 0.5}}, 1e-6, {}});
    return svg_of(primitives);
  };
  EXPECT_THAT(merged("road"), HasSubstr("<path stroke-width=\"4.5\" stroke-linecap=\"round\""));
  EXPECT_THAT(merged("line"), HasSubstr("<path stroke-width=\"1.4\" stroke-linecap=\"round\""));
  EXPECT_THAT(merged("section"), HasSubstr("<path stroke-width=\"0.05\" stroke-linecap=\"round\""));
}

TEST(Svg, of_nothing_has_a_head_and_a_foot) {
  // 72 px of margins, 56 px of head and 64 px of foot.
  const std::string svg = svg_of({});
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 760 192\" width=\"760\" height=\"192\""));
  EXPECT_EQ(count(svg, "<g "), 0U);
  EXPECT_EQ(count(svg, "<title>"), 1U);
}

TEST(Svg, titles_a_shape_only_where_it_has_a_name) {
  const auto titles = [](const char* label) {
    return count(svg_of({frame(2.0, 1.0), {Shape::disc, "tag", {{1.0, 0.5}}, 0.05, label}}), "<title>");
  };
  EXPECT_EQ(titles("tag 1"), 2U) << "and the zone's own";
  EXPECT_EQ(titles(""), 1U);
}

}  // namespace
}  // namespace cosiva::zone
