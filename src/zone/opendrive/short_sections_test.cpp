#include "cosiva/zone/opendrive/short_sections.h"

#include <gmock/gmock.h>

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

Lane lane_with(int id, std::vector<int> predecessors, std::vector<int> successors) {
  Lane lane;
  lane.id = id;
  lane.type = "driving";
  lane.widths = {{0.0, 3.0}};
  lane.borders = {{0.0, 1.0}};
  lane.speeds = {{0.0, 10.0}};
  lane.predecessors = std::move(predecessors);
  lane.successors = std::move(successors);
  return lane;
}

/// A road of 100 m with these lane sections.
Network network_of(std::vector<LaneSection> sections) {
  Road road;
  road.id = "1";
  road.location = "road 1";
  road.length = 100.0;
  road.plan = {{0.0, {}, 60.0, Clothoid{}, ""}, {60.0, {60.0, 0.0, 0.0}, 40.0, Clothoid{}, ""}};
  road.sections = std::move(sections);
  Network network;
  network.roads.push_back(std::move(road));
  return network;
}

TEST(ShortSections, of_six_centimetres_stay) {
  Report report;
  Network network = network_of({{0.0, {}, {lane_with(-1, {}, {-1})}},
                                {50.0, {}, {lane_with(-1, {-1}, {-1})}},
                                {50.06, {}, {lane_with(-1, {-1}, {})}}});
  drop_short_sections(network, report);
  EXPECT_THAT(network.roads[0].sections, SizeIs(3));
  EXPECT_THAT(report.diagnostics(), IsEmpty());
}

TEST(ShortSections, are_shorter_than_five_centimetres) {
  for (const double length_m : {0.05, 0.0499}) {
    Report report;
    Network network = network_of({{0.0, {}, {lane_with(-1, {}, {-1})}}, {length_m, {}, {lane_with(-1, {-1}, {})}}});
    drop_short_sections(network, report);
    EXPECT_THAT(network.roads[0].sections, SizeIs(length_m < 0.05 ? 1 : 2)) << length_m;
  }
}

TEST(ShortSections, between_others_are_left_out_and_links_lead_through_them) {
  Report report;
  // −1 leads over −2 and 1 over itself, without a link of its own.
  Network network = network_of({{0.0, {lane_with(1, {}, {1})}, {lane_with(-1, {}, {-2}), lane_with(-2, {}, {-9})}},
                                {50.0, {lane_with(1, {}, {})}, {lane_with(-2, {-1}, {-3, -1})}},
                                {50.04, {lane_with(1, {1}, {})}, {lane_with(-1, {-2}, {}), lane_with(-3, {-2}, {})}}});
  drop_short_sections(network, report);
  const Road& road = network.roads[0];
  ASSERT_THAT(road.sections, SizeIs(2));
  EXPECT_DOUBLE_EQ(road.sections[1].s, 50.04);
  EXPECT_THAT(road.sections[0].right[0].successors, ElementsAre(-3, -1));
  EXPECT_THAT(road.sections[0].right[1].successors, IsEmpty());  // led to no lane
  EXPECT_THAT(road.sections[0].left[0].successors, ElementsAre(1));
  EXPECT_THAT(road.sections[1].right[0].predecessors, ElementsAre(-1));
  EXPECT_THAT(road.sections[1].left[0].predecessors, ElementsAre(1));
  EXPECT_DOUBLE_EQ(road.sections[1].right[0].widths[0].s, 0.0);  // begins where it began
  EXPECT_THAT(road.first_names, IsEmpty());
  EXPECT_THAT(road.last_names, IsEmpty());
  ASSERT_THAT(report.diagnostics(), SizeIs(1));
  EXPECT_EQ(report.diagnostics()[0].kind, Diagnostic::Kind::mended);
  EXPECT_EQ(report.diagnostics()[0].location, "road 1");
}

TEST(ShortSections, at_the_begin_are_replaced_by_the_next_from_the_same_position) {
  Report report;
  Network network = network_of({{0.0, {lane_with(1, {}, {})}, {lane_with(-1, {}, {-2})}},
                                {0.03, {lane_with(1, {1}, {})}, {lane_with(-2, {-1}, {})}}});
  drop_short_sections(network, report);
  const Road& road = network.roads[0];
  ASSERT_THAT(road.sections, SizeIs(1));
  EXPECT_DOUBLE_EQ(road.sections[0].s, 0.0);
  const Lane& lane = road.sections[0].right[0];
  EXPECT_DOUBLE_EQ(lane.widths[0].s, 0.03);
  EXPECT_DOUBLE_EQ(lane.borders[0].s, 0.03);
  EXPECT_DOUBLE_EQ(lane.speeds[0].s, 0.03);
  // Other roads name the lanes of the section that is left out.
  EXPECT_THAT(road.first_names, ElementsAre(Pair(1, 1), Pair(-1, -2)));
  EXPECT_THAT(road.last_names, IsEmpty());
  EXPECT_EQ(road.lane_at(true, -1), -2);
  EXPECT_EQ(road.lane_at(true, -5), -5);
  EXPECT_EQ(road.lane_at(false, -1), -1);
}

TEST(ShortSections, at_the_end_are_replaced_by_the_one_before) {
  Report report;
  Network network = network_of({{0.0, {}, {lane_with(-1, {}, {-2})}},
                                {99.95001, {}, {lane_with(-2, {-1}, {-4})}},
                                {99.97, {}, {lane_with(-4, {-2}, {})}}});
  drop_short_sections(network, report);
  const Road& road = network.roads[0];
  ASSERT_THAT(road.sections, SizeIs(1));
  EXPECT_THAT(road.first_names, IsEmpty());
  EXPECT_THAT(road.last_names, ElementsAre(Pair(-4, -1)));
}

TEST(ShortSections, one_always_stays) {
  Report report;
  Network network = network_of({{99.99, {}, {lane_with(-1, {}, {})}}});
  drop_short_sections(network, report);
  EXPECT_THAT(network.roads[0].sections, SizeIs(1));
  EXPECT_THAT(report.diagnostics(), IsEmpty());
}

}  // namespace
}  // namespace cosiva::zone::opendrive
