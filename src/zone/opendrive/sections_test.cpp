#include "cosiva/zone/opendrive/sections.h"

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "cosiva/zone/opendrive/test_tracks.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::StartsWith;

std::vector<Circuit::Part> laid(FoundTracks& found, double scale = 1.0) {
  auto parts = lay_sections(found.network, found.tracks, scale, {}, found.report);
  EXPECT_TRUE(parts) << to_string(parts.error());
  return std::move(*parts);
}

// A straight of 20 m and a quarter to the left round 10 m, with limits of 10 m/s, from 8 m on of 5 m/s, and from the
// bend on none.
TEST(LaySections, follow_each_lane_from_limit_to_limit_in_its_direction) {
  const double quarter_m = 5.0 * pi;
  const std::string plan =
      line(0.0, 0.0, 0.0, 0.0, 20.0) + line(20.0, 20.0, 0.0, 0.0, quarter_m, R"(<arc curvature="0.1"/>)");
  const std::string types = R"(<type s="0"><speed max="10"/></type><type s="8"><speed max="5"/></type>
                               <type s="20"><speed max="no limit"/></type>)";
  FoundTracks found = tracks_of(file(road(
      "1", 20.0 + quarter_m, plan, section(0.0, lane(1, R"(<width a="2"/>)"), lane(-1, R"(<width a="4"/>)")), types)));
  const auto parts = laid(found, 0.5);
  const struct {
    const char* name;
    double length_m;
    Pose2 start;
    std::optional<double> limit_mps;
    std::vector<SectionId> next;
  } all[] = {{"1.0.-1", 4.0, {0.0, -1.0, 0.0}, 5.0, {1}},
             {"1.0.-1.2", 6.0, {4.0, -1.0, 0.0}, 2.5, {2}},
             {"1.0.-1.3", 6.0 * 0.5 * pi, {10.0, -1.0, 0.0}, std::nullopt, {}},
             {"1.0.1", 4.5 * 0.5 * pi, {14.5, 5.0, -0.5 * pi}, std::nullopt, {4}},
             {"1.0.1.2", 6.0, {10.0, 0.5, pi}, 2.5, {5}},
             {"1.0.1.3", 4.0, {4.0, 0.5, pi}, 5.0, {}}};
  ASSERT_EQ(parts.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(parts[i].name, all[i].name);
    EXPECT_NEAR(parts[i].section.length_m(), all[i].length_m, 1e-6) << all[i].name;
    EXPECT_NEAR(distance(parts[i].section.start(), all[i].start), 0.0, 1e-6) << all[i].name;
    EXPECT_NEAR(wrap_angle(parts[i].section.start().heading_rad - all[i].start.heading_rad), 0.0, 1e-6);
    EXPECT_EQ(parts[i].speed_mps_max, all[i].limit_mps) << all[i].name;
    EXPECT_EQ(parts[i].next, all[i].next) << all[i].name;
  }
  ASSERT_EQ(found.diagnostics().size(), 1U);
  EXPECT_THAT(found.diagnostics()[0],
              StartsWith("notice|lanes|their centre lines are followed by 6 sections, at worst "));
}

// The road's two lanes continue in a left bend, straight on, and in a right bend, written in this order.
TEST(LaySections, lead_straight_on_by_default_then_by_the_turn) {
  const auto branch = [](const char* id, double bend) {
    return road(id, 20.0, line(0.0, 20.0, 0.0, 0.0, 20.0, "<arc curvature=\"" + std::to_string(bend) + "\"/>"),
                "<laneOffset a=\"1.5\"/>" + section(0.0, "", lane_to(-1, R"(<predecessor id="-1"/>)")),
                road_link("predecessor", "1", "end"));
  };
  FoundTracks found = linked(
      file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), "<laneOffset a=\"1.5\"/>" + section(0.0, "", lane(-1))) +
           branch("2", 0.05) + branch("3", 0.0) + branch("4", -0.03)));
  const auto parts = laid(found);
  ASSERT_EQ(parts.size(), 4U);
  EXPECT_THAT(parts[0].next, ElementsAre(2U, 3U, 1U));
  EXPECT_EQ(found.diagnostics().size(), 1U);
}

TEST(LaySections, accept_more_than_a_thousand_lanes) {
  std::string roads;
  for (int i = 0; i < 1002; ++i) roads += straight(std::to_string(i), 0.0, 9.0 * i, 0.0, 20.0, "", lane(-1));
  FoundTracks found = tracks_of(file(roads));
  EXPECT_EQ(laid(found).size(), 1002U);
}

TEST(LaySections, refuse_more_than_300_km) {
  const auto long_road = [](double length) {
    // As a file in kilometres.
    FoundTracks found = tracks_of(
        file(road("7", length, line(0.0, 0.0, 0.0, 0.0, length), section(0.0, "", lane(-1, R"(<width a="0.1"/>)")))));
    return lay_sections(found.network, found.tracks, 1000.0, {}, found.report);
  };
  EXPECT_TRUE(long_road(299.9));
  const auto refused = long_road(300.1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "zone.size");
  EXPECT_EQ(refused.error().message,
            "expected at most 300 km of lanes, found more up to lane '7.0.-1'; [import] scale in the sidecar file "
            "makes a large network small");
}

TEST(LaySections, of_no_lanes_name_what_is_there_instead) {
  const auto message = [](const std::string& roads) {
    FoundTracks found = tracks_of(file(roads));
    const auto refused = lay_sections(found.network, found.tracks, 1.0, {}, found.report);
    EXPECT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "circuit.empty");
    return refused.error().message;
  };
  const std::string begin = "there is no lane that can be driven on";
  EXPECT_EQ(message(straight("1", 0.0, 0.0, 0.0, 20.0, "", "")), begin + "; its roads have none but their centre line");
  EXPECT_EQ(message(straight("1", 0.0, 0.0, 0.0, 20.0, lane(1, R"(<width a="1"/>)", "rail"),
                             lane(-1, R"(<width a="1"/>)", "biking") + lane(-2, R"(<width a="1"/>)", "rail"))),
            begin + "; lanes of other types: 1 biking, 2 rail ([import] lane_types in the sidecar file chooses)");
  EXPECT_EQ(message(road("1", 20.0, "", section(0.0, "", lane(-1)))),
            begin + "; road 1 has no plan view of any length");
  EXPECT_EQ(message(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), "") +
                    straight("2", 0.0, 0.0, 0.0, 20.0, "", lane(-1, R"(<width a="1"/>)", "rail"))),
            begin +
                "; lanes of other types: 1 rail ([import] lane_types in the sidecar file chooses); road 1 has no "
                "lane section");
}

TEST(LaySections, report_how_closely_they_follow) {
  FoundTracks found = tracks_of(file(straight("1", 0.0, 0.0, 0.0, 20.0, "", lane(-1))));
  EXPECT_EQ(laid(found).size(), 1U);
  EXPECT_THAT(found.diagnostics(), ElementsAre("notice|lanes|their centre lines are followed by 1 sections, at worst "
                                               "0.0000 mm and 0.000000 mrad off"));
}

}  // namespace
}  // namespace cosiva::zone::opendrive
