#include "cosiva/zone/opendrive/reader.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "cosiva/zone/opendrive/test_files.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

struct ReadFile {
  Result<Network> network;
  Report report;
};
ReadFile read_text(const std::string& text) {
  auto file = XmlFile::parse("a.xodr", text);
  EXPECT_TRUE(file) << to_string(file.error());
  Report report;
  auto network = read_network(**file, report);
  return {std::move(network), std::move(report)};
}

void expect_polynomial(const Polynomial& found, const Polynomial& expected) {
  EXPECT_EQ(found.s, expected.s);
  EXPECT_EQ(found.a, expected.a);
  EXPECT_EQ(found.b, expected.b);
  EXPECT_EQ(found.c, expected.c);
  EXPECT_EQ(found.d, expected.d);
}

constexpr const char* complete = R"(<OpenDRIVE>
<header revMajor="1" name="yard"/>
<road id="7" length="100.5" junction="-1" rule="LHT">
  <link><predecessor elementType="road" elementId="8" contactPoint="end"/>
        <successor elementType="junction" elementId="3"/></link>
  <type s="0"><speed max="36" unit="km/h"/></type>
  <type s="50"><speed max="no limit"/></type>
  <planView>
    <geometry s="0" x="1" y="2" hdg="0.5" length="10"><line/></geometry>
    <geometry s="10" x="3" y="4" hdg="-0.5" length="20"><arc curvature="0.25"/></geometry>
    <geometry s="30" x="5" y="6" hdg="1" length="21"><spiral curvStart="0.125" curvEnd="-0.5"/></geometry>
    <geometry s="51" x="7" y="8" hdg="2" length="22"><poly3 a="0.1" b="0.2" c="0.3" d="0.4"/></geometry>
    <geometry s="73" x="9" y="10" hdg="3" length="27.5">
      <paramPoly3 aU="1" bU="2" cU="3" dU="4" aV="5" bV="6" cV="7" dV="8" pRange="arcLength"/></geometry>
    <geometry s="80" x="0" y="0" hdg="0" length="1"><paramPoly3 bU="1" pRange="normalized"/></geometry>
  </planView>
  <lanes>
    <laneOffset s="0" a="0.5" b="0.25" c="0.125" d="0.0625"/><laneOffset s="40" a="1"/>
    <laneSection s="0">
      <left><lane id="2" type="sidewalk"/><lane id="1"/></left>
      <center><lane id="0" type="none"/></center>
      <right>
        <lane id="-1" type="driving" direction="reversed">
          <link><predecessor id="-2"/><predecessor id="-3"/><successor id="1"/></link>
          <width sOffset="4" a="3" b="0.5" c="0.25" d="0.125"/>
          <border sOffset="5" a="-3"/>
          <speed sOffset="6" max="10" unit="mph"/><speed sOffset="7" max="2.5"/><speed sOffset="8" max="undefined"/>
        </lane>
        <lane id="-2" type="driving" direction="both"/>
      </right>
    </laneSection>
    <laneSection s="60"/>
  </lanes>
</road>
<road id="8"/>
<road id="9" length="3" junction="3" rule="RHT"><link>
  <predecessor elementType="road" elementId="7" contactPoint="start"/></link></road>
<junction id="3">
  <connection id="0" incomingRoad="7" connectingRoad="9" contactPoint="end">
    <laneLink from="-1" to="-2"/><laneLink from="1" to="2"/><laneLink from="4"/><laneLink to="4"/></connection>
  <connection id="1" incomingRoad="8" linkedRoad="7"/>
</junction>
<junction id="4" type="virtual"><connection connectingRoad="9" contactPoint="start"/></junction>
</OpenDRIVE>)";

TEST(ReadNetwork, takes_every_field_of_a_complete_file) {
  const ReadFile read = read_text(complete);
  ASSERT_TRUE(read.network) << to_string(read.network.error());
  const Network& network = *read.network;
  EXPECT_EQ(network.name, "yard");
  ASSERT_THAT(network.roads, SizeIs(3));
  const Road& road = network.roads[0];
  EXPECT_EQ(road.id, "7");
  EXPECT_EQ(road.location, "road 7");
  EXPECT_EQ(road.length, 100.5);
  EXPECT_EQ(road.junction, "");
  EXPECT_TRUE(road.left_hand);
  ASSERT_TRUE(road.predecessor && road.successor);
  EXPECT_FALSE(road.predecessor->junction);
  EXPECT_EQ(road.predecessor->id, "8");
  EXPECT_FALSE(road.predecessor->at_start);
  EXPECT_TRUE(road.successor->junction);
  EXPECT_EQ(road.successor->id, "3");
  ASSERT_THAT(road.speeds, SizeIs(2));
  EXPECT_EQ(road.speeds[0].s, 0.0);
  EXPECT_DOUBLE_EQ(*road.speeds[0].mps, 10.0);  // 36 km/h
  EXPECT_EQ(road.speeds[1].s, 50.0);
  EXPECT_FALSE(road.speeds[1].mps);

  ASSERT_THAT(road.plan, SizeIs(6));
  const double s[] = {0.0, 10.0, 30.0, 51.0, 73.0, 80.0};
  const Pose2 starts[] = {{1.0, 2.0, 0.5}, {3.0, 4.0, -0.5}, {5.0, 6.0, 1.0}, {7.0, 8.0, 2.0}, {9.0, 10.0, 3.0}, {}};
  const double lengths[] = {10.0, 20.0, 21.0, 22.0, 27.5, 1.0};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(road.plan[i].s, s[i]);
    EXPECT_EQ(road.plan[i].start, starts[i]);
    EXPECT_EQ(road.plan[i].length, lengths[i]);
    EXPECT_EQ(road.plan[i].location, "road 7, planView/geometry[" + std::to_string(i + 1) + "]");
  }
  const double bends[][2] = {{0.0, 0.0}, {0.25, 0.25}, {0.125, -0.5}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& clothoid = std::get<Clothoid>(road.plan[i].shape);
    EXPECT_EQ(clothoid.curvature_start, bends[i][0]) << i;
    EXPECT_EQ(clothoid.curvature_end, bends[i][1]) << i;
  }
  const auto& poly3 = std::get<Cubics>(road.plan[3].shape);
  expect_polynomial(poly3.u, {0.0, 0.0, 1.0, 0.0, 0.0});
  expect_polynomial(poly3.v, {0.0, 0.1, 0.2, 0.3, 0.4});
  EXPECT_EQ(poly3.range, Cubics::Range::along_u);
  const auto& param = std::get<Cubics>(road.plan[4].shape);
  expect_polynomial(param.u, {0.0, 1.0, 2.0, 3.0, 4.0});
  expect_polynomial(param.v, {0.0, 5.0, 6.0, 7.0, 8.0});
  EXPECT_EQ(param.range, Cubics::Range::arc_length);
  const auto& normalized = std::get<Cubics>(road.plan[5].shape);
  expect_polynomial(normalized.u, {0.0, 0.0, 1.0, 0.0, 0.0});
  expect_polynomial(normalized.v, {});
  EXPECT_EQ(normalized.range, Cubics::Range::normalized);

  ASSERT_THAT(road.offsets, SizeIs(2));
  expect_polynomial(road.offsets[0], {0.0, 0.5, 0.25, 0.125, 0.0625});
  expect_polynomial(road.offsets[1], {40.0, 1.0});
  ASSERT_THAT(road.sections, SizeIs(2));
  EXPECT_EQ(road.sections[1].s, 60.0);
  const LaneSection& section = road.sections[0];
  ASSERT_THAT(section.left, SizeIs(2));  // outwards, whatever their order in the file
  EXPECT_EQ(section.left[0].id, 1);
  EXPECT_EQ(section.left[0].type, "none");
  EXPECT_FALSE(section.left[0].reversed);
  EXPECT_EQ(section.left[1].id, 2);
  EXPECT_EQ(section.left[1].type, "sidewalk");
  ASSERT_THAT(section.right, SizeIs(2));
  const Lane& lane = section.right[0];
  EXPECT_EQ(lane.id, -1);
  EXPECT_EQ(lane.type, "driving");
  EXPECT_TRUE(lane.reversed);
  EXPECT_THAT(lane.predecessors, ElementsAre(-2, -3));
  EXPECT_THAT(lane.successors, ElementsAre(1));
  ASSERT_THAT(lane.widths, SizeIs(1));
  expect_polynomial(lane.widths[0], {4.0, 3.0, 0.5, 0.25, 0.125});
  ASSERT_THAT(lane.borders, SizeIs(1));
  expect_polynomial(lane.borders[0], {5.0, -3.0});
  ASSERT_THAT(lane.speeds, SizeIs(3));
  EXPECT_EQ(lane.speeds[0].s, 6.0);
  EXPECT_DOUBLE_EQ(*lane.speeds[0].mps, 4.4704);  // a mile is 1609.344 m
  EXPECT_EQ(lane.speeds[1].s, 7.0);
  EXPECT_DOUBLE_EQ(*lane.speeds[1].mps, 2.5);
  EXPECT_FALSE(lane.speeds[2].mps);
  EXPECT_EQ(section.right[1].id, -2);
  EXPECT_FALSE(section.right[1].reversed);

  EXPECT_EQ(network.roads[1].id, "8");
  EXPECT_EQ(network.roads[1].length, 0.0);
  EXPECT_FALSE(network.roads[1].left_hand);
  EXPECT_FALSE(network.roads[1].predecessor || network.roads[1].successor);
  EXPECT_EQ(network.roads[2].junction, "3");
  EXPECT_FALSE(network.roads[2].left_hand);
  EXPECT_TRUE(network.roads[2].predecessor->at_start);

  ASSERT_THAT(network.junctions, SizeIs(2));
  const Junction& junction = network.junctions[0];
  EXPECT_EQ(junction.id, "3");
  ASSERT_THAT(junction.connections, SizeIs(2));
  EXPECT_EQ(junction.connections[0].incoming, "7");
  EXPECT_EQ(junction.connections[0].connecting, "9");
  EXPECT_FALSE(junction.connections[0].at_start);
  EXPECT_THAT(junction.connections[0].lanes, ElementsAre(Pair(-1, -2), Pair(1, 2)));
  EXPECT_EQ(junction.connections[0].location, "junction 3, connection[1]");
  EXPECT_EQ(junction.connections[1].incoming, "8");
  EXPECT_EQ(junction.connections[1].connecting, "7");
  EXPECT_TRUE(junction.connections[1].at_start);
  EXPECT_EQ(junction.connections[1].location, "junction 3, connection[2]");
  EXPECT_EQ(network.junctions[1].connections[0].incoming, "");
  EXPECT_TRUE(network.junctions[1].connections[0].at_start);

  EXPECT_EQ(read.report.counted("direction both"), 1U);
  ASSERT_THAT(read.report.diagnostics(), SizeIs(1));
  EXPECT_EQ(read.report.diagnostics()[0].kind, Diagnostic::Kind::lost);
  EXPECT_EQ(read.report.diagnostics()[0].location, "junction 4");
}

std::string with_geometry(const std::string& attributes, const std::string& shape = "<line/>") {
  return file("<road id=\"1\"><planView><geometry " + attributes + ">" + shape + "</geometry></planView></road>");
}
std::string with_lane(const std::string& inside) {
  return file("<road id=\"1\"><lanes><laneSection s=\"0\"><left><lane id=\"1\">" + inside +
              "</lane></left></laneSection></lanes></road>");
}
std::string put(std::string text, const std::string& value) { return text.replace(text.find('#'), 1, value); }

TEST(ReadNetwork, accepts_numbers_up_to_their_limits_and_none_beyond) {
  const struct {
    std::string text;  ///< with # for the number
    const char* low;
    const char* below;
    const char* high;
    const char* above;
    const char* expected;
  } all[] = {
      {with_geometry(R"(s="0" x="#" y="0" hdg="0" length="1")"), "-1e8", "-1.001e8", "1e8", "1.001e8",
       "metres within ±100000000"},
      {with_geometry(R"(s="0" x="0" y="#" hdg="0" length="1")"), "-1e8", "-1.001e8", "1e8", "1.001e8",
       "metres within ±100000000"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="#" length="1")"), "-1e5", "-1.001e5", "1e5", "1.001e5",
       "a heading in radians within ±100000"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="0" length="#")"), "0", "-1e-9", "1e5", "1.001e5",
       "a length from 0 to 100000 metres"},
      {with_geometry(R"(s="#" x="0" y="0" hdg="0" length="1")"), "0", "-1e-9", "1e6", "1.001e6",
       "metres along the road, 0 to 1000000"},
      {file(R"(<road id="1" length="#"/>)"), "0", "-1e-9", "1e5", "1.001e5", "a length from 0 to 100000 metres"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="0" length="1")", R"(<arc curvature="#"/>)"), "-1e4", "-1.001e4", "1e4",
       "1.001e4", "a curvature per metre within ±10000"},
      {with_lane(R"(<width a="#"/>)"), "-1e30", "-1.001e30", "1e30", "1.001e30", "a number within ±1e30"},
      {with_lane(R"(<width sOffset="#"/>)"), "0", "-1e-9", "1e6", "1.001e6", "metres along the road, 0 to 1000000"},
      {with_lane(R"(<speed max="#"/>)"), "-1e6", "-1.001e6", "1e6", "1.001e6", "a speed"},
      {with_lane(R"(<speed max="1" sOffset="#"/>)"), "0", "-1e-9", "1e6", "1.001e6",
       "metres along the road, 0 to 1000000"},
      {file(R"(<road id="1"><type s="#"/></road>)"), "0", "-1e-9", "1e6", "1.001e6",
       "metres along the road, 0 to 1000000"}};
  for (const auto& of : all) {
    for (const char* good : {of.low, of.high}) {
      const auto read = read_text(put(of.text, good));
      EXPECT_TRUE(read.network) << of.text << good << to_string(read.network.error());
    }
    for (const std::string bad : {of.below, of.above}) {
      const auto read = read_text(put(of.text, bad));
      ASSERT_FALSE(read.network) << of.text << bad;
      EXPECT_EQ(read.network.error().code, "zone.field");
      EXPECT_EQ(read.network.error().message, std::string("expected ") + of.expected + ", found \"" + bad + "\"");
    }
  }
}

TEST(ReadNetwork, requires_what_has_no_default) {
  const std::pair<std::string, const char*> all[] = {
      {with_geometry(R"(x="0" y="0" hdg="0" length="1")"), "@s"},
      {with_geometry(R"(s="0" y="0" hdg="0" length="1")"), "@x"},
      {with_geometry(R"(s="0" x="0" hdg="0" length="1")"), "@y"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="0")"), "@length"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="0" length="1")", "<arc/>"), "arc/@curvature"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="0" length="1")", R"(<spiral curvEnd="1"/>)"), "spiral/@curvStart"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="0" length="1")", R"(<spiral curvStart="1"/>)"), "spiral/@curvEnd"},
      {file(R"(<road id="1"><lanes><laneSection/></lanes></road>)"), "laneSection/@s"},
      {file(R"(<road id="1"><link><successor elementType="road" contactPoint="end"/></link></road>)"), "@elementId"},
      {file(R"(<road id="1"/><junction id="1"><connection incomingRoad=""/></junction>)"), "@incomingRoad"},
      {file(R"(<road id="1"/><junction id="1"><connection connectingRoad=""/></junction>)"), "@connectingRoad"},
  };
  for (const auto& [text, where] : all) {
    const auto read = read_text(text);
    ASSERT_FALSE(read.network) << text;
    EXPECT_EQ(read.network.error().code, "zone.missing") << where;
    EXPECT_THAT(read.network.error().location, HasSubstr(where));
  }
}

TEST(ReadNetwork, refuses_what_contradicts_the_standard_with_its_location) {
  const std::string lanes101 = [] {
    std::string lanes;
    for (int i = 1; i <= 101; ++i) lanes += "<lane id=\"" + std::to_string(i) + "\"/>";
    return lanes;
  }();
  const struct {
    std::string text;
    const char* code;
    const char* message;
    const char* location;
  } all[] = {
      {"<OpenDrive/>", "zone.format", "expected the root element OpenDRIVE, found OpenDrive", "a.xodr:1"},
      {"<OpenDRIVE><header revMajor=\"2\"/><road id=\"1\"/></OpenDRIVE>", "zone.version", "1.1 to 1.8",
       "header/@revMajor"},
      {file(R"(<road id="1"/><road id="1"/>)"), "zone.duplicate", "two elements \"road\" have the id '1'", "@id"},
      {file(R"(<road id="1"/><junction id="2"/><junction id="2"/>)"), "zone.duplicate",
       "two elements \"junction\" have the id '2'", "@id"},
      {file(R"(<road id="1"/><junction id="2"><connection contactPoint="both"/></junction>)"), "zone.field",
       "expected \"start\" or \"end\"", "connection/@contactPoint"},
      {file(R"(<road id="1"><lanes><laneSection s="0"><left>)" + lanes101 + "</left></laneSection></lanes></road>"),
       "zone.size", "expected at most 100 lanes on one side", "lane[101]"},
      {file("<road id=\"1\"><lanes><laneSection s=\"0\"><left><lane id=\"1\"/><lane id=\"2\"/><lane id=\"2\"/></left>"
            "</laneSection></lanes></road>"),
       "zone.duplicate", "two lanes of this section have the id 2", "laneSection"},
      {file(R"(<station/>)"), "circuit.empty", "expected at least one road, found none", "a.xodr"},
  };
  for (const auto& bad : all) {
    const auto read = read_text(bad.text);
    ASSERT_FALSE(read.network) << bad.text;
    EXPECT_EQ(read.network.error().code, bad.code) << bad.text;
    EXPECT_THAT(read.network.error().message, HasSubstr(bad.message));
    EXPECT_THAT(read.network.error().location, HasSubstr(bad.location));
  }
  const std::string name(60, 'n');
  EXPECT_EQ(read_text("<" + name + "/>").network.error().message,
            "expected the root element OpenDRIVE, found " + name.substr(0, 40));
  // A hundred lanes are accepted.
  EXPECT_TRUE(
      read_text(file(R"(<road id="1"><lanes><laneSection s="0"><left>)" +
                     lanes101.substr(0, lanes101.find("<lane id=\"101\"")) + "</left></laneSection></lanes></road>"))
          .network);
}

struct Mended {
  std::string text;
  Diagnostic::Kind kind;
  const char* location;
  const char* message;
};

TEST(ReadNetwork, reports_what_it_mends_or_leaves_out) {
  using enum Diagnostic::Kind;
  const Mended all[] = {
      {file("<road/>"), mended, "road", "it is called 'unnamed1' here"},
      {file("<road id=\"\"/>"), mended, "road", "it is called 'unnamed1' here"},
      {file(R"(<road id="1"/><road id="2"/><road/>)"), mended, "road[3]", "it is called 'unnamed3' here"},
      {file(R"(<road id="1"><link><predecessor elementType="road" elementId="2"/></link></road>)"), mended,
       "road 1, link/predecessor", "does not state the end of the road"},
      {with_geometry(R"(s="0" x="0" y="0" hdg="0" length="1")", R"(<paramPoly3 bU="1"/>)"), mended,
       "road 1, planView/geometry/paramPoly3", "taken as normalized"},
      {with_lane(R"(<speed max="0"/>)"), mended, "lane[1]/speed", "is no limit"},
      {with_lane(R"(<speed max="-3" unit="km/h"/>)"), mended, "lane[1]/speed", "is no limit"},
      {"<OpenDRIVE><header><geoReference/></header><road id=\"1\"/></OpenDRIVE>", notice, "header/geoReference",
       "where on earth this lies is not taken"},
      {file(R"(<road id="1"><lanes><laneSection s="0"><left><lane id="-1"/></left></laneSection></lanes></road>)"),
       mended, "left/lane[-1]", "lies right of the reference line by its id"},
      {file(R"(<road id="1"><lanes><laneSection s="0"><right><lane id="1"/></right></laneSection></lanes></road>)"),
       mended, "right/lane[1]", "lies left of the reference line by its id"},
      {file(R"(<road id="1"><lanes><laneSection s="0"><right><lane id="0"/></right></laneSection></lanes></road>)"),
       lost, "right/lane[0]", "is the centre line"},
  };
  for (const Mended& each : all) {
    const auto read = read_text(each.text);
    ASSERT_TRUE(read.network) << each.text << to_string(read.network.error());
    ASSERT_THAT(read.report.diagnostics(), SizeIs(1)) << each.text;
    const Diagnostic diagnostic = read.report.diagnostics()[0];
    EXPECT_EQ(diagnostic.kind, each.kind) << each.text;
    EXPECT_THAT(diagnostic.location, HasSubstr(each.location));
    EXPECT_THAT(diagnostic.text, HasSubstr(each.message));
  }
  // A link without a contact point is none; one to a junction needs none.
  const auto links = read_text(file(
      R"(<road id="1"><link><predecessor elementType="road" elementId="2"/><successor elementType="junction" elementId="3"/></link></road>)"));
  EXPECT_FALSE(links.network->roads[0].predecessor);
  EXPECT_TRUE(links.network->roads[0].successor);
  EXPECT_FALSE(read_text(with_lane(R"(<speed max="0"/>)")).network->roads[0].sections[0].left[0].speeds[0].mps);
  EXPECT_EQ(read_text(with_lane(R"(<speed max=""/>)")).report.diagnostics().size(), 0U);
  // A type is cut after forty bytes.
  const auto typed = read_text(file("<road id=\"1\"><lanes><laneSection s=\"0\"><left><lane id=\"1\" type=\"" +
                                    std::string(50, 't') + "\"/></left></laneSection></lanes></road>"));
  EXPECT_EQ(typed.network->roads[0].sections[0].left[0].type, std::string(40, 't'));
}

TEST(ReadNetwork, locates_only_as_many_alike_as_are_kept) {
  std::string roads;
  for (int i = 0; i < 22; ++i) roads += "<road/>";
  const auto read = read_text(file(roads));
  ASSERT_THAT(read.report.diagnostics(), SizeIs(21));
  for (std::size_t i = 0; i < 20; ++i)
    EXPECT_EQ(read.report.diagnostics()[i].location, "road[" + std::to_string(i + 1) + "]");
  EXPECT_EQ(read.report.diagnostics()[20].text, "2 more elements without an id");
}

TEST(ReadNetwork, counts_what_is_not_taken) {
  const auto read = read_text(file(R"(<road id="1">
      <elevationProfile><elevation s="0"/><elevation s="1" a="1"/><elevation s="2" b="1"/><elevation s="3" c="1"/>
        <elevation s="4" d="1"/></elevationProfile>
      <lateralProfile><superelevation a="0"/><superelevation a="1"/><crossfall b="1"/><crossfall b="2"/><shape/>
        <shape c="1"/></lateralProfile>
      <signals><signal/><signal/><signal/><other/></signals>
      <objects><object/><bridge/>text</objects>
      <railroad/></road>
    <controller/><controller/><station/><junctionGroup/><junctionGroup/><junctionGroup/>)"));
  ASSERT_TRUE(read.network);
  const std::pair<const char*, std::size_t> all[] = {
      {"elevation", 4U}, {"superelevation", 1U}, {"crossfall", 2U},  {"shape", 1U},   {"signals", 3U},
      {"objects", 2U},   {"railroad", 1U},       {"controller", 2U}, {"station", 1U}, {"junctionGroup", 3U}};
  for (const auto& [what, count] : all) EXPECT_EQ(read.report.counted(what), count) << what;
  const auto none = read_text(file(R"(<road id="1"/>)"));
  for (const auto& [what, count] : all) EXPECT_EQ(none.report.counted(what), 0U) << what;
  EXPECT_THAT(none.report.diagnostics(), IsEmpty());
}

}  // namespace
}  // namespace cosiva::zone::opendrive
