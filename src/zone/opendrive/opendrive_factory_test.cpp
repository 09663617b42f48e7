#include "cosiva/zone/opendrive/opendrive_factory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "cosiva/base/test_paths.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/opendrive/test_files.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

const std::string samples_folder = source_dir() + "/src/zone/opendrive/testdata/";
constexpr const char* samples[] = {"esmini/fabriksgatan",
                                   "esmini/velodrome",
                                   "maliput/Crossing8Course",
                                   "maliput/LoopRoadPedestrianCrosswalk",
                                   "maliput/ParametricCubicCurveComplexRoad",
                                   "maliput/ParametricCubicCurveRoad",
                                   "maliput/Roundabout",
                                   "maliput/SpiralRoad",
                                   "maliput/TShapeRoad"};

class Sample : public ::testing::TestWithParam<const char*> {
 protected:
  Sample() : text_{read_file(samples_folder + GetParam() + ".xodr")}, zone_{zone_of(text_)} {
    EXPECT_TRUE(tree_.load_string(text_.c_str()));
  }
  std::string text_;
  TrafficZone zone_;
  pugi::xml_document tree_;
};

TEST_P(Sample, joins_within_a_millimetre_and_a_milliradian) {
  for (SectionId id = 0; id < zone_.circuit.size(); ++id) {
    const Pose2& end = zone_.circuit.section(id).end();
    for (const SectionId after : zone_.circuit.next(id)) {
      const Pose2& start = zone_.circuit.section(after).start();
      EXPECT_LT(distance(end, start), 1e-3);
      EXPECT_LT(std::fabs(wrap_angle(end.heading_rad - start.heading_rad)), 1e-3);
    }
  }
}

TEST_P(Sample, has_a_section_for_every_driving_lane) {
  std::size_t lanes = 0;
  for (const auto road : tree_.document_element().children("road")) {
    int index = 0;
    for (const auto section : road.child("lanes").children("laneSection")) {
      for (const char* side : {"left", "right"}) {
        for (const auto lane : section.child(side).children("lane")) {
          if (std::string(lane.attribute("type").value()) != "driving") continue;
          std::string name = road.attribute("id").value();
          name += '.' + std::to_string(index) + '.' + lane.attribute("id").value();
          EXPECT_TRUE(zone_.circuit.find(name)) << name;
          ++lanes;
        }
      }
      ++index;
    }
  }
  EXPECT_GT(lanes, 0U);
}

/// A lane at an offset from a line of length L that turns Δθ in all is L − t·Δθ long, t to the left, whatever its
/// shape. Only for constant t; from the file's own numbers alone.
double expected_length(const pugi::xml_document& tree) {
  double total = 0.0;
  for (const auto road : tree.document_element().children("road")) {
    double length = 0.0;
    double turn = 0.0;
    for (const auto g : road.child("planView").children("geometry")) {
      const double l = g.attribute("length").as_double();
      length += l;
      if (const auto arc = g.child("arc")) turn += l * arc.attribute("curvature").as_double();
      if (const auto spiral = g.child("spiral"))
        turn += 0.5 * l * (spiral.attribute("curvStart").as_double() + spiral.attribute("curvEnd").as_double());
      if (const auto cubic = g.child("paramPoly3")) {
        const double p = std::string(cubic.attribute("pRange").value()) == "normalized" ? 1.0 : l;
        const auto slope = [&](const char* b, const char* c, const char* d, double at) {
          return cubic.attribute(b).as_double() + 2.0 * at * cubic.attribute(c).as_double() +
                 3.0 * at * at * cubic.attribute(d).as_double();
        };
        turn += std::remainder(std::atan2(slope("bV", "cV", "dV", p), slope("bU", "cU", "dU", p)) -
                                   std::atan2(slope("bV", "cV", "dV", 0.0), slope("bU", "cU", "dU", 0.0)),
                               2.0 * pi);
      }
    }
    const auto lanes = road.child("lanes");
    const double offset = lanes.child("laneOffset").attribute("a").as_double();
    double s_before = 0.0;
    for (auto section = lanes.child("laneSection"); section; section = section.next_sibling("laneSection")) {
      const auto after = section.next_sibling("laneSection");
      const double until = after ? after.attribute("s").as_double() : length;
      const double ratio = (until - s_before) / length;
      for (const int sign : {1, -1}) {
        std::map<int, pugi::xml_node> by_id;
        for (const auto lane : section.child(sign > 0 ? "left" : "right").children("lane"))
          by_id[std::abs(lane.attribute("id").as_int())] = lane;
        double t = offset;
        for (const auto& [id, lane] : by_id) {
          const double width = lane.child("width").attribute("a").as_double();
          const double centre = t + 0.5 * sign * width;
          t += sign * width;
          if (std::string(lane.attribute("type").value()) == "driving") total += ratio * (length - centre * turn);
        }
      }
      s_before = until;
    }
  }
  return total;
}

TEST_P(Sample, has_the_lengths_given_in_the_file) {
  // Widths vary in one of them; there the mean lane keeps its distance only nearly.
  const bool varies = std::string(GetParam()).find("Complex") != std::string::npos;
  // The parts of bends differ between the lane sections of one road; over all of them they add up again.
  const double expected = expected_length(tree_);
  EXPECT_NEAR(zone_.circuit.total_length_m() / expected, 1.0, varies ? 2e-3 : 1e-4);
}

TEST_P(Sample, reports_its_fit) {
  bool reported = false;
  for (const Diagnostic& diagnostic : zone_.diagnostics)
    reported = reported || (diagnostic.location == "lanes" && diagnostic.kind == Diagnostic::Kind::notice);
  EXPECT_TRUE(reported);
}

INSTANTIATE_TEST_SUITE_P(Official, Sample, ::testing::ValuesIn(samples), [](const auto& sample) {
  const std::string name = sample.param;
  return name.substr(name.find('/') + 1);
});

TEST(OpenDrive, loops_of_the_samples_close) {
  for (const char* sample :
       {"esmini/velodrome", "maliput/Roundabout", "maliput/LoopRoadPedestrianCrosswalk", "maliput/Crossing8Course"}) {
    const TrafficZone zone = zone_of(read_file(samples_folder + sample + ".xodr"));
    for (SectionId id = 0; id < zone.circuit.size(); ++id) {
      EXPECT_FALSE(zone.circuit.next(id).empty()) << sample << ' ' << zone.circuit.part(id).name;
      EXPECT_FALSE(zone.circuit.previous(id).empty()) << sample << ' ' << zone.circuit.part(id).name;
    }
  }
}

TEST(OpenDrive, a_three_way_junction_leads_from_each_arm_to_the_two_others) {
  const TrafficZone zone = zone_of(read_file(samples_folder + "maliput/TShapeRoad.xodr"));
  // Connecting roads by arm, from the file: contact point "end" means that the road is driven against its s.
  const std::map<std::string, std::set<std::string>> tracks{
      {"0.0.-1", {"5.0.-1", "9.0.-1"}}, {"1.0.1", {"4.0.1", "6.0.-1"}}, {"2.0.-1", {"7.0.-1", "8.0.-1"}}};
  for (const auto& [from, expected] : tracks) {
    SectionId id = *zone.circuit.find(from);
    while (zone.circuit.next(id).size() == 1) id = zone.circuit.next(id).front();
    std::set<std::string> found;
    for (const SectionId after : zone.circuit.next(id)) found.insert(zone.circuit.part(after).name);
    EXPECT_EQ(found, expected) << from;
  }
  // Straight on is the default.
  SectionId id = *zone.circuit.find("0.0.-1");
  while (zone.circuit.next(id).size() == 1) id = zone.circuit.next(id).front();
  EXPECT_EQ(zone.circuit.part(zone.circuit.next(id).front()).name, "5.0.-1");
}

TEST(OpenDrive, lanes_lie_at_their_offset_from_the_reference_line_and_run_with_the_traffic) {
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 20.0);
  const std::string lanes = "<laneOffset a=\"0.5\"/>" + section(0.0, lane(1) + lane(2, R"(<width a="2"/>)"), lane(-1));
  const TrafficZone right = zone_of(file(road("7", 20.0, plan, lanes)));
  EXPECT_NEAR(section_of(right, "7.0.-1").start().y_m, -1.0, 1e-12);
  EXPECT_NEAR(section_of(right, "7.0.-1").start().x_m, 0.0, 1e-12);
  EXPECT_NEAR(section_of(right, "7.0.1").start().y_m, 2.0, 1e-12);
  EXPECT_NEAR(section_of(right, "7.0.1").start().x_m, 20.0, 1e-12);
  EXPECT_NEAR(section_of(right, "7.0.2").start().y_m, 4.5, 1e-12);
  EXPECT_EQ(section_of(right, "7.0.2").kind(), SectionKind::straight);
  const TrafficZone left = zone_of(file(road("7", 20.0, plan, lanes, "", "junction=\"-1\" rule=\"LHT\"")));
  EXPECT_NEAR(section_of(left, "7.0.-1").start().x_m, 20.0, 1e-12);
  EXPECT_NEAR(section_of(left, "7.0.1").start().x_m, 0.0, 1e-12);
}

TEST(OpenDrive, an_arc_next_to_an_arc_is_an_arc) {
  const TrafficZone zone = zone_of(file(
      road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0, "<arc curvature=\"0.1\"/>"), section(0.0, lane(1), lane(-1)))));
  EXPECT_EQ(section_of(zone, "1.0.-1").kind(), SectionKind::arc);
  EXPECT_NEAR(section_of(zone, "1.0.-1").curvature_at(0.0), 1.0 / 11.5, 1e-9);
  EXPECT_NEAR(section_of(zone, "1.0.1").curvature_at(0.0), -1.0 / 8.5, 1e-9);
}

TEST(OpenDrive, widths_and_borders_move_the_centre_line) {
  // A lane that widens from 2 m to 4 m over 40 m, and the same by its border.
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 40.0);
  for (const char* inside :
       {R"(<width a="2" c="0.00375" d="-0.0000625"/>)", R"(<border a="2" c="0.00375" d="-0.0000625"/>)",
        R"(<border a="-2" c="-0.00375" d="0.0000625"/>)"}) {
    const TrafficZone zone = zone_of(file(road("1", 40.0, plan, section(0.0, "", lane(-1, inside)))));
    EXPECT_NEAR(section_of(zone, "1.0.-1").start().y_m, -1.0, 1e-9);
    SectionId last = 0;
    while (!zone.circuit.next(last).empty()) last = zone.circuit.next(last).front();
    EXPECT_NEAR(zone.circuit.section(last).end().y_m, -2.0, 1e-5);
  }
}

TEST(OpenDrive, a_lane_that_begins_without_width_leaves_its_neighbour_smoothly) {
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 100.0);
  const std::string lanes =
      section(0.0, "", lane(-1, R"(<link><successor id="-1"/></link><width a="3"/>)")) +
      section(40.0, "",
              lane(-1, R"(<link><predecessor id="-1"/></link><width a="3"/>)") +
                  lane(-2, R"(<link><predecessor id="-1"/></link><width a="0" c="0.0025" d="-0.000027"/>)"));
  const TrafficZone zone = zone_of(file(road("1", 100.0, plan, lanes)));
  EXPECT_TRUE(leads(zone, "1.0.-1", "1.1.-1"));
  EXPECT_TRUE(leads(zone, "1.0.-1", "1.1.-2"));
  // The through lane stays where it is.
  EXPECT_EQ(section_of(zone, "1.0.-1").kind(), SectionKind::straight);
  EXPECT_EQ(section_of(zone, "1.1.-1").kind(), SectionKind::straight);
  EXPECT_NEAR(section_of(zone, "1.1.-2").start().y_m, -1.5, 1e-6);
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::mended, "lane '1.1.-2'", "1.50 m"));
}

TEST(OpenDrive, lanes_too_far_apart_are_not_joined_and_are_reported) {
  const std::string lanes = section(0.0, "", lane(-1, R"(<link><successor id="-2"/></link><width a="3"/>)")) +
                            section(40.0, "", lane(-1) + lane(-2));
  const TrafficZone zone = zone_of(file(road("1", 100.0, line(0.0, 0.0, 0.0, 0.0, 100.0), lanes)));
  EXPECT_FALSE(leads(zone, "1.0.-1", "1.1.-2"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "lane '1.0.-1'", "too much to bend"));
}

TEST(OpenDrive, a_tiny_lane_section_is_removed_and_links_lead_through_it) {
  const std::string both = R"(<link><predecessor id="-1"/><successor id="-1"/></link><width a="3"/>)";
  const std::string lanes =
      section(0.0, "", lane(-1, both)) + section(50.0, "", lane(-1, both)) + section(50.003, "", lane(-1, both));
  const TrafficZone zone = zone_of(file(road("1", 100.0, line(0.0, 0.0, 0.0, 0.0, 100.0), lanes)));
  EXPECT_TRUE(leads(zone, "1.0.-1", "1.1.-1"));
  EXPECT_EQ(zone.circuit.size(), 2U);
  EXPECT_NEAR(zone.circuit.total_length_m(), 100.0, 1e-9);
}

TEST(OpenDrive, roads_that_meet_without_a_link_are_joined_with_a_diagnostic) {
  const TrafficZone zone = zone_of(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), section(0.0, "", lane(-1))) +
                                        road("2", 20.0, line(0.0, 20.0, 0.0, 0.0, 20.0), section(0.0, "", lane(-1)))));
  EXPECT_TRUE(leads(zone, "1.0.-1", "2.0.-1"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::mended, "1.0.-1", "the file has no such link"));
}

TEST(OpenDrive, contact_points_define_which_ends_meet) {
  // Road 2 runs towards road 1, so that its left lane continues road 1's right one.
  const std::string one = road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0),
                               section(0.0, "", lane(-1, R"(<link><successor id="1"/></link><width a="3"/>)")),
                               R"(<link><successor elementType="road" elementId="2" contactPoint="end"/></link>)");
  const std::string two = road("2", 20.0, line(0.0, 40.0, 0.0, pi, 20.0), section(0.0, lane(1), ""));
  const TrafficZone zone = zone_of(file(one + two));
  EXPECT_TRUE(leads(zone, "1.0.-1", "2.0.1"));
  EXPECT_NEAR(section_of(zone, "2.0.1").end().x_m, 40.0, 1e-9);
}

TEST(OpenDrive, limits_hold_from_their_position_in_any_unit) {
  const std::string speeds = R"(<speed sOffset="0" max="36" unit="km/h"/><speed sOffset="8" max="10" unit="mph"/>)";
  const TrafficZone zone = zone_of(
      file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), section(0.0, lane(1), lane(-1, "<width a=\"3\"/>" + speeds)),
                R"(<type s="0" type="town"><speed max="5"/></type>)")),
      "[import]\nscale = 0.1\n");
  const auto limit = [&](const char* name) { return *zone.circuit.part(*zone.circuit.find(name)).speed_mps_max; };
  EXPECT_NEAR(limit("1.0.-1"), 1.0, 1e-12);
  EXPECT_NEAR(section_of(zone, "1.0.-1").length_m(), 0.8, 1e-9);
  EXPECT_NEAR(limit("1.0.-1.2"), 0.44704, 1e-12);
  EXPECT_NEAR(limit("1.0.1"), 0.5, 1e-12);
}

TEST(OpenDrive, the_sidecar_scales_names_and_chooses_lanes) {
  const std::string text = file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0),
                                     section(0.0, "", lane(-1) + lane(-2, R"(<width a="2"/>)", "biking"))));
  const TrafficZone zone = zone_of(text,
                                   "name = \"lab\"\n[import]\nscale = 0.05\nlane_types = [\"biking\"]\n"
                                   "[[station]]\nname = \"dock\"\nsection = \"1.0.-2\"\ns_m = 0.5\n");
  EXPECT_EQ(zone.name, "lab");
  EXPECT_EQ(zone.circuit.size(), 1U);
  EXPECT_NEAR(section_of(zone, "1.0.-2").start().y_m, -0.05 * 4.0, 1e-12);
  EXPECT_NEAR(zone.circuit.total_length_m(), 1.0, 1e-12);
  EXPECT_TRUE(zone.find_station("dock"));
  const auto bad = read(text, "[import]\nscale = -1\n");
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().location, HasSubstr("test.zone.toml"));
}

TEST(OpenDrive, ignored_elements_are_reported) {
  const std::string more =
      R"(<elevationProfile><elevation s="0" a="3" b="0.1"/></elevationProfile><signals><signal id="1"/><signal id="2"/></signals>)"
      R"(<objects><object id="1"/></objects>)";
  const TrafficZone zone = zone_of(
      file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0),
                section(0.0, lane(1, R"(<width a="2"/>)", "sidewalk"), lane(-1, R"(<width a="2"/>)", "bidirectional")),
                more) +
           R"(<controller id="1"/>)"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::notice, "file", "1 records of elevation"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "file", "2 signals"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "file", "1 objects"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "file", "1 controllers"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::notice, "file", "1 sidewalk"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "lane -1", "both ways"));
}

TEST(OpenDrive, dangling_links_are_lost_with_their_location) {
  const std::string lanes = section(0.0, "", lane(-1, R"(<link><successor id="-4"/></link><width a="3"/>)"));
  const TrafficZone zone = zone_of(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), lanes,
                                             R"(<link><successor elementType="road" elementId="1" contactPoint="start"/>
                                             <predecessor elementType="road" elementId="9" contactPoint="end"/></link>)") +
                                        R"(<junction id="3"><connection id="0" incomingRoad="1" connectingRoad="8"
                                             contactPoint="start"><laneLink from="-1" to="-1"/></connection></junction>)"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "road 1", "lane -4 of road '1'"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "road 1, link/predecessor", "road '9'"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "junction 3, connection[1]", "road '8'"));
}

TEST(OpenDrive, a_network_far_from_its_origin_is_moved_near) {
  const TrafficZone zone = zone_of(file(
      road("1", 20.0, line(0.0, 691000.25, 5334100.5, 0.0, 20.0), section(0.0, "", lane(-1, R"(<width a="2"/>)")))));
  EXPECT_NEAR(section_of(zone, "1.0.-1").start().x_m, 0.25, 1e-9);
  EXPECT_NEAR(section_of(zone, "1.0.-1").start().y_m, 99.5, 1e-9);
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::notice, "file", "moved by (-691000"));
}

struct Bad {
  const char* what;
  std::string text;
  const char* code;
  const char* message;  ///< in the whole message, with its location
};

TEST(OpenDrive, bad_files_are_refused_with_their_location) {
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 20.0);
  const std::string lanes = section(0.0, "", lane(-1));
  const auto with_plan = [&](const std::string& geometry) { return file(road("12", 20.0, geometry, lanes)); };
  const std::vector<Bad> all{
      {"empty", "", "zone.syntax", "test.xodr"},
      {"no XML", "OpenDRIVE", "zone.syntax", "test.xodr:1"},
      {"cut off", file(road("1", 20.0, plan, lanes)).substr(0, 200), "zone.syntax", "test.xodr:3"},
      {"another root", "<a/>", "zone.format", "OpenDRIVE, found a"},
      {"another version", "<OpenDRIVE><header revMajor=\"2\"/></OpenDRIVE>", "zone.version", "header/@revMajor"},
      {"no roads", file(""), "circuit.empty", "at least one road"},
      {"no lanes", file(road("1", 20.0, plan, "")), "circuit.empty", "no lane that can be driven on; road 1 has no"},
      {"no lanes to drive on", file(road("1", 20.0, plan, section(0.0, "", lane(-1, "<width a=\"2\"/>", "rail")))),
       "circuit.empty", "1 rail"},
      {"negative length", with_plan(plan + line(20.0, 20.0, 0.0, 0.0, -3.0)), "zone.field",
       "test.xodr:3: road 12, planView/geometry[2]/@length: expected a length from 0"},
      {"not a number", with_plan(line(0.0, std::nan(""), 0.0, 0.0, 20.0)), "zone.field", "geometry/@x"},
      {"infinite", with_plan(line(0.0, 0.0, HUGE_VAL, 0.0, 20.0)), "zone.field", "geometry/@y"},
      {"text", with_plan(line(0.0, 0.0, 0.0, 0.0, 20.0, "<arc curvature=\"tight\"/>")), "zone.field",
       "road 12, planView/geometry/arc/@curvature"},
      {"missing", with_plan("<geometry s=\"0\" x=\"0\" y=\"0\" length=\"3\"><line/></geometry>"), "zone.missing",
       "@hdg"},
      {"no shape", with_plan(line(0.0, 0.0, 0.0, 0.0, 20.0, "<vector/>")), "zone.missing", "paramPoly3"},
      {"wrong pRange", with_plan(line(0.0, 0.0, 0.0, 0.0, 20.0, "<paramPoly3 bU=\"1\" pRange=\"p\"/>")), "zone.field",
       "@pRange"},
      {"a width that runs away",
       file(road("5", 30.0, line(0.0, 0.0, 0.0, 0.0, 30.0), section(0.0, "", lane(-1, R"(<width a="3" d="100"/>)")))),
       "zone.size", "300 km of lanes, found more up to lane '5.0.-1'"},
      {"two of an id", file(road("5", 20.0, plan, lanes) + road("5", 20.0, plan, lanes)), "zone.duplicate", "'5'"},
      {"two lanes of an id", file(road("5", 20.0, plan, section(0.0, "", lane(-1) + lane(-1)))), "zone.duplicate",
       "-1"},
      {"lane without an id", file(road("5", 20.0, plan, section(0.0, "<lane type=\"driving\"/>", ""))), "zone.missing",
       "lanes/laneSection/left/lane/@id"},
      {"comma as point", with_plan("<geometry s=\"0\" x=\"1,5\" y=\"0\" hdg=\"0\" length=\"3\"><line/></geometry>"),
       "zone.field", "\"1,5\""},
  };
  for (const Bad& bad : all) {
    const auto zone = read(bad.text);
    ASSERT_FALSE(zone) << bad.what;
    EXPECT_EQ(zone.error().code, bad.code) << bad.what << ": " << to_string(zone.error());
    EXPECT_THAT(to_string(zone.error()), HasSubstr(bad.message)) << bad.what;
  }
}

TEST(OpenDrive, hostile_files_cost_little) {
  // Entities are not expanded: a "billion laughs" file stays small.
  std::string laughs = "<?xml version=\"1.0\"?>\n<!DOCTYPE x [<!ENTITY a \"ha\">";
  for (char c = 'b'; c < 'k'; ++c) {
    laughs += std::string("<!ENTITY ") + c + " \"";
    for (int i = 0; i < 10; ++i) laughs += std::string("&") + static_cast<char>(c - 1) + ';';
    laughs += "\">";
  }
  laughs += "]>\n";
  const std::string good = road("&j;", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), section(0.0, "", lane(-1)));
  const auto zone = read(laughs + "<OpenDRIVE>" + good + "</OpenDRIVE>");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->circuit.part(0).name, "&j;.0.-1");

  std::string deep;
  for (int i = 0; i < 500000; ++i) deep += "<a>";
  EXPECT_FALSE(read(deep));
  for (int i = 0; i < 500000; ++i) deep += "</a>";
  EXPECT_EQ(read("<OpenDRIVE>" + deep + "</OpenDRIVE>").error().code, "circuit.empty");
  EXPECT_EQ(read(std::string((std::size_t{64} << 20U) + 1, ' ')).error().code, "zone.size");
  std::string many = "<OpenDRIVE>";
  for (int i = 0; i < 2'000'001; ++i) many += "<a/>";
  EXPECT_EQ(read(many + "</OpenDRIVE>").error().code, "zone.size");
  std::string wide;
  for (int i = 1; i <= 101; ++i) wide += lane(-i);
  EXPECT_EQ(read(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), section(0.0, "", wide)))).error().code,
            "zone.size");
}

TEST(OpenDrive, edits_are_written_into_the_sidecar_and_the_file_stays) {
  const ZoneConfiguration before{"opendrive", "test.xodr",
                                 file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), section(0.0, "", lane(-1)))), ""};
  ZoneEdit edit;
  edit.set_tags.push_back({7, {0, 12.5}});
  const auto after = OpenDriveCircuitFactory{}.edited(before, edit);
  ASSERT_TRUE(after) << to_string(after.error());
  EXPECT_EQ(after->text, before.text);
  const auto zone = OpenDriveCircuitFactory{}.make_zone(*after);
  ASSERT_TRUE(zone) << to_string(zone.error());
  ASSERT_NE(zone->find_tag(7), nullptr);
  EXPECT_NEAR(zone->find_tag(7)->position.s_m, 12.5, 1e-4);
}

TEST(OpenDrive, is_only_read) {
  EXPECT_THAT(OpenDriveCircuitFactory{}.file_endings(), ::testing::ElementsAre(".xodr"));
  std::vector<Diagnostic> lost;
  const TrafficZone zone = zone_of(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), section(0.0, "", lane(-1)))));
  const auto written = OpenDriveCircuitFactory{}.written(zone, lost);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, "zone.write");
}

}  // namespace
}  // namespace cosiva::zone
