#include "cosiva/zone/opendrive/links.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "cosiva/zone/opendrive/test_tracks.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::string to_successor = R"(<successor id="-1"/>)";

TEST(LinkTracks, follow_the_direction_of_travel_through_the_lane_sections_of_a_road) {
  for (const bool by_successor : {true, false}) {
    const auto lanes = [&](double s, const char* link, bool linked_here) {
      const auto with = [&](int id) {
        return linked_here ? lane_to(id, "<" + std::string(link) + " id=\"" + std::to_string(id) + "\"/>") : lane(id);
      };
      return section(s, with(1), with(-1));
    };
    const FoundTracks found =
        linked(file(road("1", 100.0, line(0.0, 0.0, 0.0, 0.0, 100.0),
                         lanes(0.0, "successor", by_successor) + lanes(40.0, "predecessor", !by_successor))));
    EXPECT_THAT(found.next("1.0.-1"), ElementsAre("1.1.-1"));
    EXPECT_THAT(found.next("1.1.-1"), IsEmpty());
    EXPECT_THAT(found.next("1.1.1"), ElementsAre("1.0.1"));
    EXPECT_THAT(found.next("1.0.1"), IsEmpty());
    EXPECT_THAT(found.diagnostics(), IsEmpty());
  }
}

// Both ends of a road, each to either end of another one. To the left of a road lanes run against its
// s: lane 1 of a road that points back continues lane −1.
TEST(LinkTracks, lead_from_either_end_of_a_road_to_either_end_of_another) {
  const auto road_1 = [](const std::string& which, const std::string& contact, const std::string& own, int to) {
    const std::string id = std::to_string(to);
    const std::string back = std::to_string(-to);
    return straight("1", 0.0, 0.0, 0.0, 20.0, lane_to(1, "<" + which + " id=\"" + back + "\"/>"),
                    lane_to(-1, "<" + which + " id=\"" + id + "\"/>"), road_link(which, "2", contact) + own);
  };
  const FoundTracks onward =
      linked(file(road_1("successor", "start", "", -1) + straight("2", 20.0, 0.0, 0.0, 20.0, lane(1), lane(-1))));
  EXPECT_THAT(onward.next("1.0.-1"), ElementsAre("2.0.-1"));
  EXPECT_THAT(onward.next("2.0.1"), ElementsAre("1.0.1"));
  EXPECT_THAT(onward.diagnostics(), IsEmpty());
  const FoundTracks facing =
      linked(file(road_1("successor", "end", "", 1) + straight("2", 40.0, 0.0, pi, 20.0, lane(1), lane(-1))));
  EXPECT_THAT(facing.next("1.0.-1"), ElementsAre("2.0.1"));
  EXPECT_THAT(facing.next("2.0.-1"), ElementsAre("1.0.1"));
  EXPECT_THAT(facing.diagnostics(), IsEmpty());
  const FoundTracks behind =
      linked(file(road_1("predecessor", "end", "", -1) + straight("2", -20.0, 0.0, 0.0, 20.0, lane(1), lane(-1))));
  EXPECT_THAT(behind.next("2.0.-1"), ElementsAre("1.0.-1"));
  EXPECT_THAT(behind.next("1.0.1"), ElementsAre("2.0.1"));
  EXPECT_THAT(behind.diagnostics(), IsEmpty());
  const FoundTracks back =
      linked(file(road_1("predecessor", "start", "", 1) + straight("2", 0.0, 0.0, pi, 20.0, lane(1), lane(-1))));
  EXPECT_THAT(back.next("2.0.1"), ElementsAre("1.0.-1"));
  EXPECT_THAT(back.next("1.0.1"), ElementsAre("2.0.-1"));
  EXPECT_THAT(back.diagnostics(), IsEmpty());
}

TEST(LinkTracks, join_the_last_lane_section_to_the_first_and_the_first_to_the_last) {
  const std::string through = R"(<predecessor id="-1"/><successor id="-1"/>)";
  const auto lanes = [&](double second_s) {
    return section(0.0, "", lane_to(-1, through)) + section(second_s, "", lane_to(-1, through));
  };
  // The third road's first lane section is too short to stay; its lane −1 is called −2 after that.
  const std::string third = section(0.0, "", lane_to(-1, R"(<successor id="-2"/>)")) +
                            section(0.03, "", lane(-1, R"(<width a="0"/>)", "none") + lane_to(-2, ""));
  const FoundTracks found =
      linked(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), lanes(8.0), road_link("successor", "2", "start")) +
                  road("2", 30.0, line(0.0, 20.0, 0.0, 0.0, 30.0), lanes(9.0),
                       R"(<link><predecessor elementType="road" elementId="1" contactPoint="end"/>)"
                       R"(<successor elementType="road" elementId="3" contactPoint="start"/></link>)") +
                  road("3", 30.0, line(0.0, 50.0, 0.0, 0.0, 30.0), third)));
  EXPECT_THAT(found.next("1.0.-1"), ElementsAre("1.1.-1"));
  EXPECT_THAT(found.next("1.1.-1"), ElementsAre("2.0.-1"));
  EXPECT_THAT(found.next("2.0.-1"), ElementsAre("2.1.-1"));
  EXPECT_THAT(found.next("2.1.-1"), ElementsAre("3.0.-2"));
  EXPECT_THAT(found.diagnostics(), ElementsAre("mended|road 3|has lane sections of less than 5 cm; their neighbours "
                                               "replace them"));
}

TEST(LinkTracks, take_the_other_end_of_a_road_if_the_named_one_is_far_and_that_one_near) {
  const auto found = [](double begin, double length, const char* contact, double heading = pi) {
    // Road 2 begins beyond road 1 and leads back to it, or away from it.
    const int to = heading != 0.0 ? 1 : -1;
    return linked(
        file(straight("1", 0.0, 0.0, 0.0, 20.0, "", lane_to(-1, "<successor id=\"" + std::to_string(to) + "\"/>"),
                      road_link("successor", "2", contact)) +
             straight("2", begin, 0.0, heading, length, lane(1), lane(-1))));
  };
  const FoundTracks far = found(22.02, 2.02, "start");
  EXPECT_THAT(far.next("1.0.-1"), ElementsAre("2.0.1"));
  EXPECT_THAT(far.diagnostics(),
              ElementsAre("mended|road 1, link/successor|leads to the start of road '2', which is 2.02 m away; its "
                          "other end is only 0.0000 mm away and is taken"));
  const FoundTracks near = found(21.98, 1.98, "start");
  EXPECT_THAT(
      near.diagnostics(),
      ElementsAre("lost|road 1|links '1.0.-1' to '2.0.1', which run against each other",
                  "mended|lane '1.0.-1'|ends where '2.0.1' begins, although the file has no such link; joined"));
  const FoundTracks half = found(40.48, 20.0, "start");
  EXPECT_THAT(half.next("1.0.-1"), ElementsAre("2.0.1"));
  EXPECT_THAT(half.diagnostics(),
              ElementsAre("mended|road 1, link/successor|leads to the start of road '2', which is 20.48 m away; its "
                          "other end is only 0.48 m away and is taken"));
  EXPECT_THAT(found(40.52, 20.0, "start").diagnostics(),
              ElementsAre("lost|road 1|links '1.0.-1' to '2.0.1', which run against each other"));
  const FoundTracks end = found(20.25, 5.0, "end", 0.0);
  EXPECT_THAT(end.next("1.0.-1"), ElementsAre("2.0.-1"));
  EXPECT_THAT(end.diagnostics(),
              ElementsAre("mended|road 1, link/successor|leads to the end of road '2', which is 5.25 m away; its other "
                          "end is only 0.25 m away and is taken"));
}

TEST(LinkTracks, report_links_that_cannot_be_followed) {
  const std::string second =
      straight("2", 20.0, 0.0, 0.0, 20.0, lane(1), lane(-1) + lane(-2, "<width a=\"2\"/>", "rail"));
  const auto found = [&](const std::string& link, const std::string& type = "driving") {
    return linked(
        file(straight("1", 0.0, 5.0, 0.0, 20.0, "", lane(-1, "<link>" + link + "</link><width a=\"3\"/>", type),
                      road_link("successor", "2", "start")) +
             second));
  };
  EXPECT_THAT(found(R"(<successor id="-3"/>)").diagnostics(),
              ElementsAre("lost|road 1|leads to lane -3 of road '2', which is not there"));
  EXPECT_THAT(found(R"(<successor id="2"/>)").diagnostics(),
              ElementsAre("lost|road 1|leads to lane 2 of road '2', which is not there"));
  EXPECT_THAT(found(R"(<successor id="1"/>)").diagnostics(),
              ElementsAre("lost|road 1|links '1.0.-1' to '2.0.1', which run against each other"));
  const auto not_driven = [](const FoundTracks& tracks) {
    EXPECT_THAT(tracks.diagnostics(), IsEmpty());
    return tracks.report.counted("links to lanes not driven on");
  };
  EXPECT_EQ(not_driven(found(R"(<successor id="-2"/>)")), 1U);
  EXPECT_EQ(not_driven(found(R"(<successor id="0"/>)")), 1U);
  EXPECT_EQ(not_driven(found(R"(<successor id="-1"/>)", "rail")), 1U);
  EXPECT_EQ(not_driven(found(R"(<successor id="-2"/>)", "rail")), 0U);
  EXPECT_EQ(not_driven(found(R"(<successor id="-1"/>)")), 0U);
  EXPECT_THAT(found(R"(<successor id="-1"/>)").next("1.0.-1"), ElementsAre("2.0.-1"));
}

TEST(LinkTracks, to_and_from_a_road_that_cannot_be_followed_are_none) {
  const std::string corner = line(0.0, 20.0, 0.0, 0.0, 10.0) + line(10.0, 30.0, 0.0, 1.7, 10.0);
  const FoundTracks found = linked(
      file(straight("1", 0.0, 0.0, 0.0, 20.0, "", lane_to(-1, to_successor), road_link("successor", "2", "start")) +
           road("2", 20.0, corner, section(0.0, "", lane_to(-1, to_successor)), road_link("successor", "3", "start")) +
           straight("3", 60.0, 0.0, 0.0, 20.0, "", lane(-1)) +
           road("4", 20.0, line(0.0, 60.0, 9.0, 0.0, 20.0), "", road_link("predecessor", "1", "end")) +
           straight("5", 90.0, 0.0, 0.0, 20.0, "", lane_to(-1, to_successor), road_link("successor", "4", "start"))));
  EXPECT_EQ(found.tracks.tracks.size(), 3U);
  EXPECT_THAT(found.next("1.0.-1"), IsEmpty());
  EXPECT_EQ(found.report.counted("links to lanes not driven on"), 2U);
}

std::string junction(const std::string& connection) { return "<junction id=\"9\">" + connection + "</junction>"; }
const std::string leads_to_junction = R"(<link><successor elementType="junction" elementId="9"/></link>)";
const std::string begins_at_junction = R"(<link><predecessor elementType="junction" elementId="9"/></link>)";

TEST(LinkTracks, of_a_junction_lead_from_the_incoming_road_s_end_there_to_the_connecting_road) {
  const std::string connection =
      R"(<connection incomingRoad="1" connectingRoad="2" contactPoint="start"><laneLink from="-1" to="-1"/></connection>)";
  const std::string out = straight("2", 20.0, 0.5, 0.0, 20.0, "", lane(-1));
  // By its link to the junction, or by the end that is nearer.
  for (const std::string& link : {leads_to_junction, std::string()}) {
    const FoundTracks found =
        linked(file(straight("1", 0.0, 0.0, 0.0, 20.0, "", lane(-1), link) + out + junction(connection)));
    EXPECT_THAT(found.next("1.0.-1"), ElementsAre("2.0.-1"));
    EXPECT_THAT(found.diagnostics(), IsEmpty());
  }
  // The incoming road begins at the junction, and its left lane runs into it.
  const std::string from_start =
      R"(<connection incomingRoad="1" connectingRoad="2" contactPoint="start"><laneLink from="1" to="-1"/></connection>)";
  const std::string both_ends =
      R"(<link><predecessor elementType="junction" elementId="9"/><successor elementType="junction" elementId="9"/></link>)";
  const std::string other_junction =
      R"(<link><predecessor elementType="junction" elementId="8"/><successor elementType="road" elementId="7" contactPoint="end"/></link>)";
  for (const std::string& link : {begins_at_junction, std::string(), both_ends}) {
    const FoundTracks found =
        linked(file(straight("1", 20.0, 0.0, pi, 20.0, lane(1), "", link) + out + junction(from_start)));
    EXPECT_THAT(found.next("1.0.1"), ElementsAre("2.0.-1"));
    EXPECT_THAT(found.diagnostics(), IsEmpty());
  }
  const FoundTracks other =
      linked(file(straight("1", 20.0, 0.0, pi, 20.0, lane(1), "", other_junction) + out + junction(from_start)));
  EXPECT_THAT(other.next("1.0.1"), ElementsAre("2.0.-1"));
  // The link decides, not the distance: here the other end is nearer, and the lane runs away from there.
  const FoundTracks against =
      linked(file(straight("1", 22.0, 0.0, 0.0, 20.0, "", lane(-1), begins_at_junction) + out + junction(connection)));
  EXPECT_THAT(against.diagnostics(), ElementsAre("lost|junction 9, connection[1]|links '1.0.-1' to '2.0.-1', which run "
                                                 "against each other"));
}

TEST(LinkTracks, of_a_junction_lead_to_the_connecting_road_s_named_end) {
  const std::string connection =
      R"(<connection incomingRoad="1" connectingRoad="2" contactPoint="end"><laneLink from="-1" to="1"/><laneLink from="-1" to="2"/></connection>)";
  const std::string through = R"(<successor id="1"/>)";
  const std::string incoming = road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0),
                                    section(0.0, "", lane_to(-1, to_successor)) + section(9.0, "", lane(-1)));
  const std::string out = road("2", 20.0, line(0.0, 40.0, 0.5, pi, 20.0),
                               section(0.0, lane_to(1, through), "") + section(9.0, lane(1) + lane(2), ""));
  const FoundTracks found = linked(file(incoming + out + junction(connection)));
  EXPECT_THAT(found.next("1.1.-1"), ElementsAre("2.1.1", "2.1.2"));
  EXPECT_THAT(found.diagnostics(), IsEmpty());
  // The named end is far, the other one is near.
  const FoundTracks facing =
      linked(file(straight("1", 0.0, 0.0, 0.0, 20.0, "", lane(-1), leads_to_junction) +
                  straight("2", 20.0, 0.25, 0.0, 20.0, "", lane(-1)) +
                  junction(R"(<connection incomingRoad="1" connectingRoad="2" contactPoint="end">)"
                           R"(<laneLink from="-1" to="-1"/></connection>)")));
  EXPECT_THAT(facing.next("1.0.-1"), ElementsAre("2.0.-1"));
  EXPECT_THAT(facing.diagnostics(), ElementsAre("mended|junction 9, connection[1]|leads to the end of road '2', which "
                                                "is 20.00 m away; its other end is only 0.25 m away and is taken"));
}

TEST(LinkTracks, of_an_incomplete_connection_are_none) {
  const std::string roads = straight("1", 0.0, 0.0, 0.0, 20.0, "", lane(-1)) +
                            straight("2", 20.0, 0.5, 0.0, 20.0, "", lane(-1)) +
                            road("3", 20.0, line(0.0, 60.0, 9.0, 0.0, 20.0), "");
  const auto found = [&](const std::string& attributes) {
    return linked(
        file(roads + junction("<connection " + attributes + "><laneLink from=\"-1\" to=\"-1\"/></connection>")));
  };
  const std::string no_lanes = "lost|road 3|has no lane section";
  EXPECT_THAT(found(R"(incomingRoad="1")").diagnostics(), ElementsAre(no_lanes));
  EXPECT_THAT(found(R"(connectingRoad="1")").diagnostics(), ElementsAre(no_lanes));
  EXPECT_THAT(found(R"(incomingRoad="1" connectingRoad="3")").diagnostics(), ElementsAre(no_lanes));
  EXPECT_THAT(found(R"(incomingRoad="3" connectingRoad="1")").diagnostics(), ElementsAre(no_lanes));
  const std::string missing = "lost|junction 9, connection[1]|leads to road '7', which is not there";
  EXPECT_THAT(found(R"(incomingRoad="7" connectingRoad="1")").diagnostics(), ElementsAre(no_lanes, missing));
  EXPECT_THAT(found(R"(incomingRoad="1" connectingRoad="7")").diagnostics(), ElementsAre(no_lanes, missing));
}

TEST(LinkTracks, join_ends_without_a_link_that_meet_within_a_centimetre_and_a_hundredth_of_a_radian) {
  const auto joined = [](double dx, double dy, double turn, double length = 20.0) {
    // The lane's centre is its road's reference line, so that the turn does not move it.
    const std::string lanes = "<laneOffset a=\"1.5\"/>" + section(0.0, "", lane(-1));
    const FoundTracks found = linked(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), lanes) +
                                          road("2", length, line(0.0, 20.0 + dx, dy, turn, length), lanes)));
    const bool is_joined = !found.next("1.0.-1").empty();
    if (is_joined) {
      EXPECT_THAT(found.next("1.0.-1"), ElementsAre("2.0.-1"));
      EXPECT_THAT(
          found.diagnostics(),
          ElementsAre("mended|lane '1.0.-1'|ends where '2.0.-1' begins, although the file has no such link; joined"));
    } else {
      EXPECT_THAT(found.diagnostics(), IsEmpty());
    }
    return is_joined;
  };
  EXPECT_TRUE(joined(0.0, 0.0, 0.0));
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(joined(sign * 0.009, 0.0, 0.0));
    EXPECT_FALSE(joined(sign * 0.011, 0.0, 0.0));
    EXPECT_TRUE(joined(0.0, sign * 0.009, 0.0));
    EXPECT_FALSE(joined(0.0, sign * 0.011, 0.0));
    EXPECT_TRUE(joined(0.0, 0.0, sign * 0.009));
    EXPECT_FALSE(joined(0.0, 0.0, sign * 0.011));
  }
  // A road hardly longer than the tolerance would meet itself.
  EXPECT_FALSE(joined(0.0, 0.0, 0.0, 0.045));
  EXPECT_TRUE(joined(0.0, 0.0, 0.0, 0.055));
}

TEST(LinkTracks, join_a_third_lane_to_two_that_are_linked) {
  const std::string lanes = "<laneOffset a=\"1.5\"/>" + section(0.0, "", lane(-1));
  const std::string linked_lanes = "<laneOffset a=\"1.5\"/>" + section(0.0, "", lane_to(-1, to_successor));
  // Road 3 ends where road 2 begins, and road 4 begins where road 1 ends.
  const FoundTracks found =
      linked(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), linked_lanes, road_link("successor", "2", "start")) +
                  road("2", 20.0, line(0.0, 20.0, 0.0, 0.0, 20.0), lanes) +
                  road("3", 10.0, line(0.0, 10.0, 0.0, 0.0, 10.0), lanes) +
                  road("4", 10.0, line(0.0, 20.0, 0.0, 0.0, 10.0), lanes)));
  EXPECT_THAT(found.next("1.0.-1"), ElementsAre("2.0.-1", "4.0.-1"));
  EXPECT_THAT(found.next("3.0.-1"), ElementsAre("2.0.-1", "4.0.-1"));
  EXPECT_EQ(found.diagnostics().size(), 3U);
}

// Roads side by side: the lanes of each begin and end at the same x as those of every other one.
TEST(LinkTracks, are_searched_among_at_most_two_million_pairs_of_ends) {
  const auto diagnostics = [](int roads) {
    Network network;
    for (int i = 0; i < roads; ++i) {
      Road road;
      road.id = std::to_string(i);
      road.length = 0.04;  // too short to be joined
      road.plan = {{0.0, {0.0, 9.0 * i, 0.5 * pi}, 0.04, Clothoid{}, ""}};
      Lane only;
      only.id = -1;
      only.type = "driving";
      only.widths = {{0.0, 3.0}};
      road.sections = {{0.0, {}, {only}}};
      network.roads.push_back(std::move(road));
    }
    Report report;
    Tracks tracks = find_tracks(network, {"driving"}, report);
    link_tracks(network, tracks, report);
    return report.diagnostics();
  };
  EXPECT_THAT(diagnostics(1'414), IsEmpty());  // 1 999 396 pairs
  const auto found = diagnostics(1'415);       // 2 002 225 pairs
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, Diagnostic::Kind::lost);
  EXPECT_EQ(found[0].location, "file");
}

}  // namespace
}  // namespace cosiva::zone::opendrive
