#include "virtual/vehicle/virtual_aiv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "virtual/vehicle/virtual_bench.h"

namespace cosiva::virtual_side {
namespace {

using test::at;
using test::lacet4;
using test::VirtualBench;
using ::testing::IsEmpty;

const std::vector<std::string> to_1131{"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"};

TEST(VirtualAiv, announces_itself_as_a_vehicle_of_its_own_manufacturer) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.2);
  EXPECT_EQ(bench.aiv.id(), (wire::VehicleId{"CoSiVA.virtual", "V1"}));
  ASSERT_EQ(bench.connections.size(), 1U);
  EXPECT_EQ(bench.connections[0].state, wire::ConnectionState::online);
  EXPECT_FALSE(bench.factsheets.empty());
  ASSERT_FALSE(bench.states.empty());
  ASSERT_TRUE(bench.state().position);
  EXPECT_LT(distance(bench.state().position->pose, lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.0))), 1e-6);
  // Somebody who looks at it as it comes is not alarmed.
  EXPECT_THAT(bench.states.front().errors, IsEmpty());
  EXPECT_EQ(bench.states.front().battery.charge_percent, 100.0);
  EXPECT_THAT(bench.strange, IsEmpty());
}

TEST(VirtualAiv, stands_while_nobody_tells_it_to_drive) {
  VirtualBench bench{"loop_se", 0.3};
  bench.run(3.0);
  EXPECT_EQ(bench.aiv.place().s_m, 0.3);
  EXPECT_EQ(bench.aiv.speed_mps(), 0.0);
}

TEST(VirtualAiv, drives_its_order_and_reports_the_nodes) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.2);
  bench.order(to_1131);
  double fastest_mps = 0.0;
  for (int i = 0; i < 500; ++i) {
    const double before_mps = bench.aiv.speed_mps();
    bench.step();
    const double change_mps2 = (bench.aiv.speed_mps() - before_mps) / 0.02;
    EXPECT_LE(change_mps2, lacet4().profiles.medium.acceleration_mps2 + 1e-6);
    fastest_mps = std::max(fastest_mps, bench.aiv.speed_mps());
  }
  EXPECT_NEAR(fastest_mps, lacet4().profiles.medium.speed_mps, 1e-6);
  EXPECT_EQ(bench.aiv.speed_mps(), 0.0);
  EXPECT_NEAR(bench.aiv.place().s_m, 1.131, 0.01);
  EXPECT_EQ(bench.state().last_node_id, "loop_se@1131");
  EXPECT_THAT(bench.state().node_states, IsEmpty());
  EXPECT_THAT(bench.strange, IsEmpty());
}

TEST(VirtualAiv, reads_the_tags_it_passes_and_knows_where_it_is) {
  VirtualBench bench{"east", 1.12};
  bench.run(0.2);
  bench.order({"east@1120", "east@1310", "loop_se@0", "loop_se@283", "loop_se@565"});
  ASSERT_TRUE(bench.run_until([&] { return bench.state().last_node_id == "loop_se@565"; }, 8.0));
  bench.run(1.0);
  ASSERT_FALSE(bench.state().information.empty());
  EXPECT_EQ(bench.state().information[0].type, "lastTag");
  EXPECT_EQ(bench.state().information[0].references[0].value, "1");
  EXPECT_LT(bench.belief_error_m(), 0.002);
}

TEST(VirtualAiv, believes_what_is_true_all_round_the_circuit) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.2);
  bench.order({"loop_se@0", "loop_se@2545"});
  double worst_m = 0.0;
  for (int i = 0; i < 400; ++i) {
    bench.step();
    // A position is up to a period of visualization old.
    if (bench.aiv.speed_mps() == 0.0) worst_m = std::max(worst_m, bench.belief_error_m());
  }
  EXPECT_LT(worst_m, 0.003);
}

TEST(VirtualAiv, stops_within_half_a_second_when_its_host_beats_no_more) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.5);
  bench.order({"loop_se@0", "loop_se@2545"});
  bench.run(1.5);
  EXPECT_GT(bench.aiv.speed_mps(), 0.2);
  bench.server_beats = false;
  bench.run(1.5);
  EXPECT_EQ(bench.aiv.speed_mps(), 0.0);
  bench.server_beats = true;
  bench.run(1.5);
  EXPECT_GT(bench.aiv.speed_mps(), 0.2);
}

TEST(VirtualAiv, does_not_leap_when_its_host_slept) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.5);
  bench.order(to_1131);
  bench.run(1.5);
  const double before_m = bench.aiv.place().s_m;
  bench.now += std::chrono::seconds{10};
  bench.step();
  EXPECT_LT(bench.aiv.place().s_m - before_m, 0.05);
}

TEST(VirtualAiv, obeys_pause_and_speed_like_any_vehicle) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.5);
  bench.order({"loop_se@0", "loop_se@2545"});
  bench.run(1.5);
  const auto act = [&](std::string type, std::string id, std::vector<wire::Parameter> parameters) {
    wire::InstantActions message;
    message.header = {1, bench.now, "2.1.0", bench.aiv.id().manufacturer, bench.aiv.id().serial_number};
    message.actions.push_back({std::move(type), std::move(id), "", wire::BlockingType::hard, std::move(parameters)});
    bench.hear(wire::vda_topic(bench.aiv.id(), "instantActions"), wire::vda5050::encode(message));
  };
  act("startPause", "a1", {});
  bench.run(1.0);
  EXPECT_EQ(bench.aiv.speed_mps(), 0.0);
  EXPECT_TRUE(bench.state().paused);
  act("setSpeedLimit", "a2", {{"profile", std::string("slow")}});
  act("stopPause", "a3", {});
  bench.run(1.5);
  EXPECT_NEAR(bench.aiv.speed_mps(), lacet4().profiles.slow.speed_mps, 1e-6);
}

TEST(VirtualAiv, stops_before_what_its_server_says_stands_ahead_and_goes_on) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.2);
  bench.order({"loop_se@0", "loop_se@2545"});
  bench.run(1.0);
  const Point2 p = position(lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.9)));
  const wire::Body person{"P1", "person", p.x_m, p.y_m, 0.0, 0.0, 0.06, 0.0, 0.0};
  for (int i = 0; i < 40; ++i) {
    bench.ahead({person});
    bench.run(0.1);
  }
  EXPECT_EQ(bench.aiv.speed_mps(), 0.0);
  EXPECT_NEAR(0.9 - 0.06 - 0.1 - bench.aiv.place().s_m, 0.12, 0.02) << "the stand-off of any vehicle";
  ASSERT_FALSE(bench.felts.empty());
  EXPECT_TRUE(bench.felts.back().braking);
  EXPECT_EQ(bench.felts.back().body, "P1");
  EXPECT_TRUE(bench.state().field_violation);
  bench.ahead({});
  bench.run(1.0);
  EXPECT_GT(bench.aiv.speed_mps(), 0.2);
  EXPECT_THAT(bench.strange, IsEmpty());
}

TEST(VirtualAiv, tells_of_healthy_boards_that_see_nothing) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(2.0);
  ASSERT_FALSE(bench.reports.empty());
  for (const auto& line : bench.reports.back().boards) {
    EXPECT_EQ(line.health, "ok");
    EXPECT_NE(line.firmware_hash, 0U);
    EXPECT_EQ(line.frames_bad + line.frames_missed, 0U);
    EXPECT_GT(line.frames, 4U);
  }
  for (const std::uint16_t range_mm : bench.reports.back().ranges->range_mm) EXPECT_EQ(range_mm, wire::no_echo);
  EXPECT_EQ(bench.reports.back().power->charge_permille, 1000);
}

// --- edits of the zone
// ------------------------------------------------------------------------------------------------

zone::ZoneConfiguration edited(std::string_view from, std::string_view to) {
  zone::ZoneConfiguration configuration = test::lacet4_configuration();
  const std::size_t found = configuration.text.find(from);
  EXPECT_NE(found, std::string::npos) << from;
  configuration.text.replace(found, from.size(), to);
  return configuration;
}

TEST(VirtualAiv, reads_a_tag_that_was_moved_at_its_new_place_and_drives_on) {
  VirtualBench bench{"loop_se", 1.0};
  bench.run(0.2);
  bench.order({"loop_se@848", "loop_se@2545"});
  bench.run(0.5);
  bench.zone(edited("s_m = 1.4137", "s_m = 1.9000"));
  ASSERT_TRUE(bench.run_until([&] { return bench.aiv.place().s_m > 1.6; }, 5.0));
  EXPECT_GT(bench.aiv.speed_mps(), 0.2);
  for (const auto& information : bench.state().information) EXPECT_NE(information.type, "lastTag");
  bench.run(3.0);
  EXPECT_EQ(bench.state().information[0].type, "lastTag");
  EXPECT_EQ(bench.state().information[0].references[0].value, "2");
  EXPECT_LT(bench.belief_error_m(), 0.003);
}

TEST(VirtualAiv, stands_without_a_line_when_its_ways_are_gone_and_goes_on_when_they_are_back) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.2);
  bench.order({"loop_se@0", "loop_se@2545"});
  bench.run(1.0);
  bench.zone(edited("radius_m = 0.6", "radius_m = 0.61"));
  bench.run(1.5);
  EXPECT_GT(bench.aiv.speed_mps(), 0.0) << "that text is no zone: the ways do not join, so nothing changed";
  bench.zone(edited("length_m = 0.20", "length_m = 0.22"));
  bench.run(1.5);
  EXPECT_EQ(bench.aiv.speed_mps(), 0.0);
  ASSERT_FALSE(bench.state().errors.empty());
  EXPECT_EQ(bench.state().errors[0].type, "lineLost");
  bench.zone(test::lacet4_configuration());
  bench.run(1.5);
  EXPECT_GT(bench.aiv.speed_mps(), 0.2);
}

TEST(VirtualAiv, runs_the_same_way_every_time) {
  const auto run = [] {
    VirtualBench bench{"east", 1.12};
    bench.run(0.2);
    bench.order({"east@1120", "east@1310", "loop_se@0", "loop_se@283"});
    bench.run(5.0);
    return bench.digest();
  };
  const std::string digest = run();
  EXPECT_EQ(digest, run());
  VirtualBench other{"east", 1.12};
  other.run(5.2);
  EXPECT_NE(digest, other.digest());
}

TEST(VirtualAiv, says_goodbye_when_it_is_taken_away) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.5);
  bench.farewell();
  EXPECT_EQ(bench.connections.back().state, wire::ConnectionState::offline);
  EXPECT_THAT(bench.strange, IsEmpty());
}

TEST(VirtualAiv, publishes_nothing_while_its_host_has_no_broker) {
  VirtualBench bench{"loop_se", 0.0};
  bench.run(0.5);
  wire::Effects effects;
  bench.aiv.link(bench.now, false, effects);
  const std::size_t before = bench.states.size();
  bench.run(3.0);
  EXPECT_EQ(bench.states.size(), before);
}

}  // namespace
}  // namespace cosiva::virtual_side
