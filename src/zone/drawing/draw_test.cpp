#include "cosiva/zone/drawing/draw.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "cosiva/base/json_value.h"
#include "cosiva/zone/drawing/svg.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// Distance from p to the chain of chords through `points`.
double distance_to_chords(const std::vector<Point2>& points, Point2 p) {
  double least_m = 1e9;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point2 a = points[i - 1];
    const Point2 ab{points[i].x_m - a.x_m, points[i].y_m - a.y_m};
    const double square = ab.x_m * ab.x_m + ab.y_m * ab.y_m;
    const double t = std::clamp(((p.x_m - a.x_m) * ab.x_m + (p.y_m - a.y_m) * ab.y_m) / square, 0.0, 1.0);
    least_m = std::min(least_m, distance(p, Point2{a.x_m + t * ab.x_m, a.y_m + t * ab.y_m}));
  }
  return least_m;
}

TEST(Draw, shows_all_elements_of_the_zone) {
  const TrafficZone zone = testing::lacet4();
  std::map<std::string, std::size_t> count;
  for (const Primitive& primitive : draw(zone)) ++count[primitive.layer];
  EXPECT_EQ(count["road"], 8U);
  EXPECT_EQ(count["line"], 8U);
  EXPECT_EQ(count["crossing"], 4U);
  EXPECT_EQ(count["tag"], 12U);
  EXPECT_EQ(count["beacon"], std::size_t{zone.beacons->columns} * zone.beacons->rows);
  EXPECT_EQ(count["station"], 2U);
  EXPECT_EQ(count["section"], 16U);  // a name and an arrow each
  EXPECT_EQ(count["label"], 6U);     // four crossings and two stations
  EXPECT_EQ(count.size(), 8U);
}

TEST(Draw, strays_at_most_half_a_millimetre_from_the_curves) {
  auto clothoid = Section::make({}, 3.0, -2.0, 2.0);
  ASSERT_TRUE(clothoid);
  const TrafficZone curly{"curly", testing::circuit({testing::part("c", *clothoid)}), {}, {}, {}, {}, {}, {}, {}, {}};
  for (const TrafficZone& zone : {testing::lacet4(), curly}) {
    const auto primitives = draw(zone);
    SectionId id = 0;
    for (const Primitive& primitive : primitives) {
      if (primitive.layer != "line") continue;
      const Section& section = zone.circuit.section(id++);
      for (double s = 0.0; s <= section.length_m(); s += 0.003)
        ASSERT_LE(distance_to_chords(primitive.points, position(section.pose_at(s))), 0.0005);
    }
    EXPECT_EQ(id, zone.circuit.size());
  }
}

TEST(Draw, bounds_hold_the_width_of_roads) {
  const TrafficZone zone{
      "line", testing::circuit({testing::part("a", testing::section({}, 2.0))}), {}, {}, {}, {}, {}, {}, {}, {}};
  const Bounds box = bounds(draw(zone));
  EXPECT_LE(box.low.y_m, -0.5 * zone.vehicle.width_m);
  EXPECT_GE(box.high.y_m, 0.5 * zone.vehicle.width_m);
  EXPECT_LE(box.low.x_m, 0.0);
  EXPECT_GE(box.high.x_m, 2.0);
  const Bounds nothing = bounds({});
  EXPECT_EQ(nothing.low, nothing.high);
}

TEST(Draw, leaves_out_a_haze_of_beacons) {
  TrafficZone zone{
      "line", testing::circuit({testing::part("a", testing::section({}, 2.0))}), {}, {}, {}, {}, {}, {}, {}, {}};
  zone.beacons = BeaconGrid{0.001, {}, 1000, 1000};
  for (const Primitive& primitive : draw(zone)) EXPECT_NE(primitive.layer, "beacon");
}

TEST(Draw, writes_the_json_that_the_page_reads) {
  const TrafficZone zone = testing::lacet4();
  const auto primitives = draw(zone);
  JsonWriter json;
  write_json(json, zone, primitives);
  ASSERT_TRUE(json.complete());
  const auto document = JsonValue::parse(json.text());
  ASSERT_TRUE(document) << to_string(document.error());
  EXPECT_EQ(document->text("name"), "lacet4");
  EXPECT_EQ(document->find("bounds")->array()->size(), 4U);
  EXPECT_EQ(document->find("vehicle")->number("length_m"), 0.20);
  const auto& written = *document->find("primitives")->array();
  ASSERT_EQ(written.size(), primitives.size());
  EXPECT_EQ(written[0].text("shape"), "polyline");
  EXPECT_EQ(written[0].text("layer"), "road");
  EXPECT_EQ(written[0].text("label"), "east");
  EXPECT_EQ(written[0].find("points")->array()->size(), 2U);
}

TEST(Draw, points_one_arrow_along_each_section) {
  const TrafficZone zone = testing::lacet4();
  std::vector<std::string> names;
  std::size_t arrows = 0;
  for (const Primitive& primitive : draw(zone)) {
    if (primitive.layer != "section") continue;
    if (primitive.shape == Primitive::Shape::text) {
      names.push_back(primitive.label);
      continue;
    }
    ++arrows;
    const Circuit::Located tip = zone.circuit.locate(primitive.points[0], primitive.heading_rad);
    const Circuit::Located notch = zone.circuit.locate(primitive.points[2], primitive.heading_rad);
    EXPECT_EQ(tip.position.section, notch.position.section);
    EXPECT_GT(tip.position.s_m, notch.position.s_m);
  }
  EXPECT_EQ(arrows, 8U);
  EXPECT_THAT(names,
              ::testing::ElementsAre("east", "loop_se", "north", "loop_ne", "west", "loop_nw", "south", "loop_sw"));
}

TEST(Draw, writes_the_metadata_that_the_page_edits) {
  TrafficZone zone = testing::lacet4();
  JsonWriter json;
  write_json(json, zone, {});
  const auto document = JsonValue::parse(json.text());
  ASSERT_TRUE(document) << to_string(document.error());
  const auto& sections = *document->find("sections")->array();
  ASSERT_EQ(sections.size(), 8U);
  EXPECT_EQ(sections[0].text("name"), "east");
  EXPECT_EQ(sections[0].number("length_m"), 1.5);
  const auto& tags = *document->find("tags")->array();
  ASSERT_EQ(tags.size(), 12U);
  EXPECT_EQ(tags[0].number("number"), 1.0);
  EXPECT_EQ(tags[0].text("section"), "east");
  EXPECT_EQ(tags[0].number("s"), 1.471);
  EXPECT_NEAR(tags[0].number("x").value(), -0.75 + 1.471, 1e-12);
  EXPECT_NEAR(tags[0].number("y").value(), -0.15, 1e-12);
  const JsonValue& beacons = *document->find("beacons");
  EXPECT_EQ(beacons.number("pitch_m"), 0.3);
  EXPECT_EQ(beacons.number("columns"), static_cast<double>(zone.beacons->columns));
  EXPECT_EQ(beacons.number("rows"), static_cast<double>(zone.beacons->rows));
  ASSERT_EQ(beacons.find("origin")->array()->size(), 2U);
  EXPECT_EQ(*(*beacons.find("origin")->array())[0].number(), zone.beacons->origin.x_m);
  EXPECT_EQ(*(*beacons.find("origin")->array())[1].number(), zone.beacons->origin.y_m);

  zone.beacons.reset();
  JsonWriter without;
  write_json(without, zone, {});
  EXPECT_TRUE(JsonValue::parse(without.text())->find("beacons")->is_null());
}

/// Everything that a drawing can show: a fork, a turn on the spot, every kind of section and station, a closed one.
TrafficZone motley() {
  auto read = testing::read_zone(R"(name = "motley"
format_version = 1
[[section]]
name = "in"
kind = "straight"
length_m = 2.0
[[section]]
name = "ease"
kind = "clothoid"
length_m = 0.5
curvature_start_per_m = 0
curvature_end_per_m = 2
[[section]]
name = "bend"
kind = "arc"
radius_m = 0.5
angle_deg = 120
next = []
[[section]]
name = "aside"
start = { x = 0, y = -2, heading_deg = 90 }
kind = "straight"
length_m = 4
next = []
[[section]]
name = "branch"
from = "in"
kind = "straight"
length_m = 1.5
[[station]]
name = "dock"
section = "branch"
s_m = 1.2
[[station]]
name = "plug"
kind = "charger"
section = "branch"
s_m = 0.7
[[tag]]
number = 1
section = "in"
s_m = 1.0
[closed]
sections = ["branch"]
[beacons]
pitch_m = 0.5
rotation_deg = 20
cover = "zone"
)");
  EXPECT_TRUE(read) << to_string(read.error());
  return std::move(*read);
}

TEST(Draw, distinguishes_kinds_of_sections_and_stations) {
  std::map<std::string, std::size_t> kinds;
  for (const Primitive& primitive : draw(motley()))
    if (primitive.layer == "line" || primitive.layer == "station") ++kinds[primitive.kind];
  EXPECT_EQ(kinds, (std::map<std::string, std::size_t>{
                       {"straight", 3}, {"clothoid", 1}, {"arc", 1}, {"stop", 1}, {"charger", 1}}));
}

TEST(Draw, flags_each_position_to_turn_on_the_spot_once) {
  Circuit::Part a = testing::part("a", testing::section({}, 1.0), {1, 2});
  Circuit::Part b = testing::part("b", testing::section({1.0, 0.0, pi / 2.0}, 1.0));
  Circuit::Part c = testing::part("c", testing::section({1.0, 0.0, pi}, 1.0));
  Circuit::Part d = testing::part("d", testing::section({1.0, -1.0, pi / 2.0}, 1.0), {2});
  a.pivots = d.pivots = true;
  const TrafficZone zone{"p", testing::circuit({a, b, c, d}), {}, {}, {}, {}, {}, {}, {}, {}};
  std::vector<Point2> positions;
  for (const Primitive& primitive : draw(zone))
    if (primitive.layer == "pivot") positions.push_back(primitive.points.front());
  EXPECT_THAT(positions, ::testing::ElementsAre(Point2{1.0, 0.0}));
}

TEST(Draw, of_a_vast_zone_stays_small) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 20'000; ++i)
    parts.push_back(testing::part("s" + std::to_string(i), testing::section({2.0 * i, 0.0, 0.0}, 6.0, 1.0)));
  const TrafficZone zone{"vast", testing::circuit(std::move(parts)), {}, {}, {}, {}, {}, {}, {}, {}};
  const auto primitives = draw(zone);
  std::size_t points = 0;
  for (const Primitive& primitive : primitives) {
    points += primitive.points.size();
    EXPECT_NE(primitive.layer, "section");
  }
  EXPECT_LT(points, 2 * 400'000U);
  const std::string svg = to_svg(zone, primitives);
  EXPECT_LT(svg.size(), 12U << 20U);
  EXPECT_EQ(svg.find("<polyline"), std::string::npos);
}

TEST(Draw, writes_stations_loops_and_diagnostics_for_the_page) {
  TrafficZone zone = testing::zone_file("indus8.toml");
  zone.diagnostics = {{Diagnostic::Kind::lost, "road 12", "its signals are not taken"}};
  JsonWriter json;
  write_json(json, zone, draw(zone));
  const auto document = JsonValue::parse(json.text());
  ASSERT_TRUE(document) << to_string(document.error());
  const auto& stations = *document->find("stations")->array();
  ASSERT_EQ(stations.size(), 6U);
  EXPECT_EQ(stations[5].text("name"), "charger");
  EXPECT_EQ(stations[5].text("kind"), "charger");
  EXPECT_EQ(stations[5].text("section"), "return");
  EXPECT_EQ(stations[5].number("s"), 1.3);
  EXPECT_NEAR(stations[5].number("x").value(), 0.96 - 1.3, 1e-9);
  EXPECT_NEAR(stations[5].number("y").value(), -1.33, 1e-9);
  ASSERT_EQ(document->find("loops")->array()->size(), 1U);
  EXPECT_EQ(*(*document->find("loops")->array())[0].text(), "round");
  const auto& diagnostics = *document->find("diagnostics")->array();
  ASSERT_EQ(diagnostics.size(), 1U);
  EXPECT_EQ(diagnostics[0].text("kind"), "lost");
  EXPECT_EQ(diagnostics[0].text("location"), "road 12");
  EXPECT_EQ(document->find("beacons")->number("rotation"), 0.0);
}

TEST(Svg, shows_kinds_chargers_pivots_and_closed_sections_and_names_them) {
  TrafficZone zone = motley();
  const std::string svg = to_svg(zone, draw(zone));
  for (const char* layer : {"line-straight", "line-arc", "line-clothoid", "station", "station-charger", "closed"})
    EXPECT_THAT(svg, HasSubstr("<g id=\"" + std::string(layer) + "\""));
  for (const char* name : {"straight", "arc", "clothoid", "station", "charger", "closed", "tag", "beacon"})
    EXPECT_THAT(svg, HasSubstr(">" + std::string(name) + "</text>"));
  EXPECT_THAT(svg, HasSubstr(">plug</text>"));
  zone.closed.clear();
  EXPECT_THAT(to_svg(zone, draw(zone)), Not(HasSubstr("closed")));
}

TEST(Svg, shows_the_sections_of_a_ground_of_a_kilometre) {
  std::vector<Circuit::Part> parts;
  parts.push_back({"long", *Section::make({}, 1000.0), std::nullopt, {}});
  const TrafficZone zone{
      "far", *Circuit::make("far", std::move(parts)), {}, testing::lacet4().profiles, {}, {}, {}, {}, {}, {}};
  const std::string svg = to_svg(zone, draw(zone));
  EXPECT_THAT(svg, HasSubstr(" stroke-width=\"4.5\" stroke-linecap=\"round\"><title>long</title>"));
  EXPECT_THAT(svg, HasSubstr(" stroke-width=\"1.4\""));
  // A name of a tenth of a pixel would only hide the section.
  EXPECT_THAT(svg, Not(HasSubstr(">long</text>")));
}

TEST(Svg, is_an_image_with_every_layer_a_legend_and_a_scale) {
  const TrafficZone zone = testing::lacet4();
  const std::string svg = to_svg(zone, draw(zone));
  EXPECT_THAT(svg, StartsWith("<svg xmlns=\"http://www.w3.org/2000/svg\""));
  for (const char* layer :
       {"road", "line-straight", "line-arc", "crossing", "tag", "beacon", "station", "section", "label"})
    EXPECT_THAT(svg, HasSubstr("<g id=\"" + std::string(layer) + "\""));
  EXPECT_THAT(svg, HasSubstr("0.5 m</text>"));
  EXPECT_THAT(svg, HasSubstr("17.31 m"));
  EXPECT_EQ(svg.find("=\"nan"), std::string::npos);
  EXPECT_EQ(svg.find(",nan"), std::string::npos);
  // no external resources: the file is self-contained
  EXPECT_THAT(svg, Not(HasSubstr("http://www.w3.org/1999/xlink")));
}

TEST(Svg, has_y_pointing_up) {
  const std::vector<Primitive> two{{Primitive::Shape::disc, "tag", {{0.0, 0.0}}, 0.1, "low", 0.0},
                                   {Primitive::Shape::disc, "tag", {{0.0, 1.0}}, 0.1, "high", 0.0}};
  const TrafficZone zone{
      "z", testing::circuit({testing::part("a", testing::section({}, 1.0))}), {}, {}, {}, {}, {}, {}, {}, {}};
  const std::string svg = to_svg(zone, two);
  const auto y_of = [&](std::string_view label) {
    const auto at = svg.rfind("cy=\"", svg.find("<title>" + std::string(label)));
    return std::stod(svg.substr(at + 4));
  };
  EXPECT_LT(y_of("high"), y_of("low"));
}

TEST(Svg, escapes_what_names_may_hold) {
  const TrafficZone zone{
      "<&\">", testing::circuit({testing::part("a<b", testing::section({}, 1.0))}), {}, {}, {}, {}, {}, {}, {}, {}};
  const std::string svg = to_svg(zone, draw(zone));
  EXPECT_THAT(svg, HasSubstr("&lt;&amp;&quot;&gt;"));
  EXPECT_THAT(svg, HasSubstr("a&lt;b"));
  EXPECT_THAT(svg, Not(HasSubstr("a<b")));
}

}  // namespace
}  // namespace cosiva::zone
