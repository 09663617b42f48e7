#include "cosiva/zone/drawing/draw.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

// Sizes and positions
// ------------------------------------------------------------------------------------------------------

std::vector<Primitive> of_layer(const std::vector<Primitive>& all, std::string_view layer) {
  std::vector<Primitive> found;
  for (const Primitive& primitive : all)
    if (primitive.layer == layer) found.push_back(primitive);
  return found;
}

void expect_points(const std::vector<Point2>& points, const std::vector<Point2>& wanted) {
  ASSERT_EQ(points.size(), wanted.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT(distance(points[i], wanted[i]), 1e-12) << i;
}

TEST(Draw, follows_the_vehicle_with_all_its_sizes) {
  for (const double width_m : {0.12, 2.5}) {
    TrafficZone zone{"sizes",
                     testing::circuit({testing::part("a", testing::section({0.0, 0.0, pi / 2.0}, 40.0 * width_m))}),
                     {2.0 * width_m, width_m},
                     {},
                     {},
                     {},
                     {},
                     {},
                     {},
                     {}};
    zone.tags = {{4, {0, 10.0 * width_m}}};
    zone.beacons = BeaconGrid{1.0, {3.0, 4.0}, 3, 2, 700};
    zone.stations = {{"dock", {0, 20.0 * width_m}}, {"plug", {0, 30.0 * width_m}, StationKind::charger}};
    zone.crossings = {{"X1", {1.0, 2.0}, {{0, 0.0, 0.1}}}};
    const auto all = draw(zone);

    const double road_m = 1.5 * width_m;
    EXPECT_DOUBLE_EQ(of_layer(all, "road")[0].size_m, road_m);
    EXPECT_EQ(of_layer(all, "road")[0].label, "a");
    EXPECT_DOUBLE_EQ(of_layer(all, "line")[0].size_m, width_m / 12.0);
    const auto tags = of_layer(all, "tag");
    ASSERT_EQ(tags.size(), 1U);
    EXPECT_DOUBLE_EQ(tags[0].size_m, width_m / 6.0);
    EXPECT_EQ(tags[0].label, "tag 4");
    expect_points(tags[0].points, {{0.0, 10.0 * width_m}});

    const auto beacons = of_layer(all, "beacon");
    ASSERT_EQ(beacons.size(), 6U);
    EXPECT_DOUBLE_EQ(beacons[0].size_m, width_m / 12.0);
    EXPECT_EQ(beacons[0].label, "beacon 700");
    EXPECT_EQ(beacons[5].label, "beacon 705");
    expect_points(beacons[4].points, {{4.0, 5.0}});
    EXPECT_EQ(beacons[4].label, "beacon 704");

    // A stop is a square of 0.6 widths, a charger is on its corner and 1.4 times as wide across its corners.
    const double half_m = 0.3 * width_m;
    const auto stations = of_layer(all, "station");
    ASSERT_EQ(stations.size(), 2U);
    const double dock_m = 20.0 * width_m;
    expect_points(
        stations[0].points,
        {{half_m, dock_m - half_m}, {half_m, dock_m + half_m}, {-half_m, dock_m + half_m}, {-half_m, dock_m - half_m}});
    const double plug_m = 30.0 * width_m;
    const double corner_m = 1.4 * half_m;
    expect_points(stations[1].points,
                  {{0.0, plug_m + corner_m}, {-corner_m, plug_m}, {0.0, plug_m - corner_m}, {corner_m, plug_m}});

    // A crossing is a square as wide as a road about its centre.
    const auto crossings = of_layer(all, "crossing");
    ASSERT_EQ(crossings.size(), 1U);
    const double side_m = 0.5 * road_m;
    expect_points(crossings[0].points, {{1.0 + side_m, 2.0 - side_m},
                                        {1.0 + side_m, 2.0 + side_m},
                                        {1.0 - side_m, 2.0 + side_m},
                                        {1.0 - side_m, 2.0 - side_m}});

    // The outline is drawn, and no other size.
    for (const Primitive& primitive : all) {
      if (primitive.shape == Primitive::Shape::polygon) {
        EXPECT_EQ(primitive.size_m, 0.0) << primitive.layer;
      }
    }

    const auto labels = of_layer(all, "label");
    ASSERT_EQ(labels.size(), 3U);
    for (const Primitive& label : labels) EXPECT_DOUBLE_EQ(label.size_m, 0.45 * width_m);
    EXPECT_EQ(labels[0].label, "dock");
    expect_points(labels[0].points, {{-road_m, dock_m}});
    EXPECT_EQ(labels[2].label, "X1");
    expect_points(labels[2].points, {{1.0 + 0.28 * road_m, 2.0 + 0.28 * road_m}});
  }
}

TEST(Draw, turns_a_crossing_s_box_like_its_first_section_at_the_span_s_centre) {
  TrafficZone zone{
      "turned", testing::circuit({testing::part("a", testing::section({}, 0.5 * pi, 1.0))}), {}, {}, {}, {}, {}, {}, {},
      {}};
  // From π/8 to 3π/8 on a circle of 1 m: turned by π/4 at its centre.
  zone.crossings = {{"X1", {5.0, 6.0}, {{0, pi / 8.0, 3.0 * pi / 8.0}}}};
  const double half_m = 0.5 * 1.5 * zone.vehicle.width_m;
  const double reach_m = half_m * std::sqrt(2.0);
  expect_points(of_layer(draw(zone), "crossing")[0].points,
                {{5.0, 6.0 - reach_m}, {5.0 + reach_m, 6.0}, {5.0, 6.0 + reach_m}, {5.0 - reach_m, 6.0}});
}

TEST(Draw, puts_arrow_and_name_next_to_each_section_that_has_room) {
  // Arrows are 0.35 widths, 0.042 m: a section needs six of them, 0.252 m.
  const TrafficZone zone{"arrows",
                         testing::circuit({testing::part("short", testing::section({}, 0.251)),
                                           testing::part("long", testing::section({0.0, 5.0, 0.0}, 0.8)),
                                           testing::part("left", testing::section({0.0, 9.0, 0.0}, 0.8, 1e-9)),
                                           testing::part("enough", testing::section({0.0, 12.0, 0.0}, 0.253))}),
                         {},
                         {},
                         {},
                         {},
                         {},
                         {},
                         {},
                         {}};
  const auto drawn = of_layer(draw(zone), "section");
  ASSERT_EQ(drawn.size(), 6U);
  const double arrow_m = 0.35 * 0.12;
  expect_points(drawn[0].points, {{0.2 + arrow_m, 5.0},
                                  {0.2 - 0.6 * arrow_m, 5.0 + 0.6 * arrow_m},
                                  {0.2 - 0.2 * arrow_m, 5.0},
                                  {0.2 - 0.6 * arrow_m, 5.0 - 0.6 * arrow_m}});
  // Off the road, with 1.6 text heights of space: at the right of a straight, inside a bend to the left.
  const double offset_m = 0.5 * 1.5 * 0.12 + 1.6 * 0.45 * 0.12;
  EXPECT_EQ(drawn[1].label, "long");
  EXPECT_DOUBLE_EQ(drawn[1].size_m, 0.45 * 0.12);
  expect_points(drawn[1].points, {{0.1, 5.0 - offset_m}});
  EXPECT_EQ(drawn[3].label, "left");
  EXPECT_NEAR(drawn[3].points[0].y_m, 9.0 + offset_m, 1e-6);
  EXPECT_EQ(drawn[5].label, "enough");
}

TEST(Draw, cuts_bends_no_finer_than_half_a_millimetre_needs) {
  const auto points = [](double length_m, double curvature_per_m) {
    const TrafficZone zone{
        "bend", testing::circuit({testing::part("a", testing::section({}, length_m, curvature_per_m))}),
        {},     {},
        {},     {},
        {},     {},
        {},     {}};
    return of_layer(draw(zone), "line")[0].points.size();
  };
  EXPECT_EQ(points(100.0, 0.0), 2U);
  // A chord c strays c²/8R: 0.0632 m on a radius of 1 m, 31.6 of them on 2 m.
  EXPECT_EQ(points(2.0, 1.0), 33U);
  EXPECT_EQ(points(2.0, -0.25), 17U);
  // On a radius of 5 mm half a radius is the limit: 2.5 mm.
  EXPECT_EQ(points(0.01, 200.0), 5U);
}

TEST(Draw, is_coarser_where_the_curves_would_take_more_than_three_hundred_thousand_points) {
  const auto points = [](int sections) {
    std::vector<Circuit::Part> parts;
    // 32 parts each: 33 points.
    for (int i = 0; i < sections; ++i)
      parts.push_back(testing::part("s" + std::to_string(i), testing::section({2.0 * i, 0.0, 0.0}, 2.0, 1.0)));
    const TrafficZone zone{"many", testing::circuit(std::move(parts)), {}, {}, {}, {}, {}, {}, {}, {}};
    return of_layer(draw(zone), "line")[0].points.size();
  };
  EXPECT_EQ(points(9'090), 33U);  // 299 970 points
  // Half as many points allow chords twice as long.
  EXPECT_EQ(points(18'182), 17U);
}

TEST(Draw, leaves_names_out_of_zones_with_more_than_three_thousand) {
  const auto labels = [](std::size_t number) {
    std::vector<Circuit::Part> parts;
    for (std::size_t i = 0; i < number; ++i)
      parts.push_back(
          testing::part("s" + std::to_string(i), testing::section({0.0, 1.0 * static_cast<double>(i), 0.0}, 1.0)));
    TrafficZone zone{"names", testing::circuit(std::move(parts)), {}, {}, {}, {}, {}, {}, {}, {}};
    std::vector<Crossing> crossings;
    for (std::size_t i = 0; i < number; ++i) {
      zone.stations.push_back({"dock", {0, 0.5}});
      crossings.push_back({"X", {}, {{0, 0.0, 0.1}}});
    }
    zone.crossings = crossings;
    const auto all = draw(zone);
    EXPECT_EQ(of_layer(all, "station").size(), number);
    EXPECT_EQ(of_layer(all, "crossing").size(), number);
    return std::pair{of_layer(all, "label").size(), of_layer(all, "section").size()};
  };
  EXPECT_EQ(labels(3000), (std::pair<std::size_t, std::size_t>{6000, 6000}));
  EXPECT_EQ(labels(3001), (std::pair<std::size_t, std::size_t>{0, 0}));
}

TEST(Draw, shows_at_most_ten_thousand_beacons) {
  TrafficZone zone{
      "line", testing::circuit({testing::part("a", testing::section({}, 2.0))}), {}, {}, {}, {}, {}, {}, {}, {}};
  zone.beacons = BeaconGrid{0.01, {}, 100, 100};
  EXPECT_EQ(of_layer(draw(zone), "beacon").size(), 10'000U);
  zone.beacons = BeaconGrid{0.01, {}, 73, 137};  // 10 001
  EXPECT_EQ(of_layer(draw(zone), "beacon").size(), 0U);
}

TEST(Draw, bounds_hold_strokes_and_discs_but_not_texts) {
  using Shape = Primitive::Shape;
  const auto box = [](Shape shape) {
    return bounds(
        {{shape, "road", {{1.0, 5.0}, {2.0, 4.0}}, 0.5, {}}, {Shape::polygon, "station", {{1.5, 4.5}}, 9.0, {}}});
  };
  const auto expect_box = [](const Bounds& found, Point2 low, Point2 high) {
    EXPECT_EQ(found.low, low);
    EXPECT_EQ(found.high, high);
  };
  expect_box(box(Shape::polyline), {0.75, 3.75}, {2.25, 5.25});
  expect_box(box(Shape::disc), {0.5, 3.5}, {2.5, 5.5});
  expect_box(box(Shape::polygon), {1.0, 4.0}, {2.0, 5.0});
  expect_box(box(Shape::text), {1.0, 4.0}, {2.0, 5.0});
}

TEST(Draw, writes_every_field_of_a_primitive) {
  using Shape = Primitive::Shape;
  TrafficZone zone{
      "json", testing::circuit({testing::part("a", testing::section({}, 2.0))}), {0.7, 0.4}, {}, {}, {}, {}, {}, {},
      {}};
  zone.beacons = BeaconGrid{0.5, {1.0, 2.0}, 3, 4};
  zone.beacons->rotation_rad = 0.25;
  JsonWriter json;
  write_json(json, zone,
             {{Shape::polyline, "road", {{0.123456, -0.000004}, {1.0, 2.0}}, 0.25, "a", 0.5},
              {Shape::polygon, "station", {{0.0, 0.0}}, 0.0, "dock", 0.0, "charger"},
              {Shape::disc, "tag", {{-3.0, 8.0}}, 0.125, "tag 1"},
              {Shape::text, "label", {{0.0, 0.0}}, 0.5, "X1"}});
  const auto document = JsonValue::parse(json.text());
  ASSERT_TRUE(document) << to_string(document.error());
  const auto& edges = *document->find("bounds")->array();
  const double wanted[] = {-3.125, -0.125004, 1.125, 8.125};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(*edges.at(i).number(), wanted[i], 1e-12);
  EXPECT_EQ(document->find("vehicle")->number("length_m"), 0.7);
  EXPECT_EQ(document->find("vehicle")->number("width_m"), 0.4);
  const auto& written = *document->find("primitives")->array();
  ASSERT_EQ(written.size(), 4U);
  const char* shapes[] = {"polyline", "polygon", "disc", "text"};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(written[i].text("shape"), shapes[i]);
  EXPECT_EQ(written[0].number("size_m"), 0.25);
  EXPECT_EQ(written[0].number("heading"), 0.5);
  EXPECT_EQ(written[0].find("kind"), nullptr);
  EXPECT_EQ(written[1].text("kind"), "charger");
  // To a hundredth of a millimetre.
  const auto& first = *(*written[0].find("points")->array())[0].array();
  EXPECT_EQ(*first[0].number(), 0.12346);
  EXPECT_EQ(*first[1].number(), 0.0);
  EXPECT_EQ(document->find("beacons")->number("rotation"), 0.25);
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
