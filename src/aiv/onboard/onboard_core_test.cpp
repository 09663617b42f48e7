#include "cosiva/aiv/onboard/onboard_core.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/localisation/persisted_position.h"
#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/onboard_fixture.h"
#include "cosiva/wire/own/battery_exchange.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::at;
using test::lacet4;
using test::OnboardFixture;
using test::order;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using wire::ActionStatus;

constexpr double edge_m = 0.282743338823;

test::OrderText to_1131() {
  return order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"});
}

// --- messages of the vehicle --------------------------------------------------------------------------------------

TEST(Onboard, announces_itself_when_the_broker_is_connected) {
  OnboardFixture fixture;
  ASSERT_THAT(fixture.connections, SizeIs(1));
  EXPECT_EQ(fixture.connections[0].state, wire::ConnectionState::online);
  EXPECT_EQ(fixture.published[0].topic, "uagv/v2/CoSiVA/AIV1/connection");
  EXPECT_TRUE(fixture.published[0].retained);
  EXPECT_EQ(fixture.published[0].qos, 1);
  ASSERT_THAT(fixture.factsheets, SizeIs(1));
  EXPECT_TRUE(fixture.published[1].retained);
  EXPECT_EQ(fixture.published[1].qos, 0);
  EXPECT_EQ(fixture.factsheets[0].speed_max_mps, 0.5);
  EXPECT_THAT(fixture.factsheets[0].actions, SizeIs(12 + usual_actions().types.size() + 1)) << "the last is trigger";
}

TEST(Onboard, publishes_its_first_state_when_its_boards_have_responded) {
  OnboardFixture fixture;
  EXPECT_THAT(fixture.states, IsEmpty());
  ASSERT_TRUE(fixture.run_until([&] { return !fixture.states.empty(); }, 0.65));
  EXPECT_THAT(fixture.error_types(), IsEmpty());
  EXPECT_EQ(fixture.state().battery.charge_percent, 90.0);
}

TEST(Onboard, reports_a_board_that_never_responds_after_700_ms) {
  OnboardFixture::Setup setup;
  setup.boards_up = false;
  OnboardFixture fixture{setup};
  for (const wire::Board board : {wire::Board::PILS, wire::Board::PRAV, wire::Board::RALI}) fixture.plug(board);
  fixture.run(0.69);
  EXPECT_THAT(fixture.states, IsEmpty());
  EXPECT_THAT(fixture.boards_reports, IsEmpty());
  fixture.run(0.6);
  ASSERT_FALSE(fixture.states.empty());
  EXPECT_THAT(fixture.error_types(), ElementsAre("boardLost"));
  EXPECT_FALSE(fixture.boards_reports.empty());
}

TEST(Onboard, leaves_a_will_that_reports_a_broken_connection) {
  OnboardFixture fixture;
  const auto will = fixture.core->will();
  ASSERT_TRUE(will);
  EXPECT_TRUE(will->message.retained);
  EXPECT_EQ(will->message.qos, 1);
  EXPECT_EQ(will->message.topic, "uagv/v2/CoSiVA/AIV1/connection");
  EXPECT_EQ(wire::vda5050::decode_connection(will->message.payload)->state, wire::ConnectionState::connection_broken);
}

TEST(Onboard, publishes_offline_at_a_clean_end) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.farewell();
  EXPECT_EQ(fixture.connections.back().state, wire::ConnectionState::offline);
  EXPECT_TRUE(fixture.published.back().retained);
}

TEST(Onboard, sends_a_state_every_second_and_its_position_every_100_ms) {
  OnboardFixture fixture;
  fixture.run(2.0);
  const auto states = fixture.states.size();
  const auto visualizations = fixture.visualizations.size();
  fixture.run(10.0);
  EXPECT_EQ(fixture.states.size() - states, 10U);
  EXPECT_EQ(fixture.visualizations.size() - visualizations, 100U);
}

TEST(Onboard, counts_headers_per_topic_without_gap) {
  OnboardFixture fixture;
  fixture.order(to_1131());
  fixture.run(5.0);
  for (std::size_t i = 0; i < fixture.states.size(); ++i) EXPECT_EQ(fixture.states[i].header.header_id, i);
  for (std::size_t i = 0; i < fixture.visualizations.size(); ++i)
    EXPECT_EQ(fixture.visualizations[i].header.header_id, i);
}

TEST(Onboard, publishes_nothing_while_the_broker_is_away_and_restarts_when_it_is_back) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.link(false);
  const auto count = fixture.published.size();
  fixture.run(3.0);
  EXPECT_EQ(fixture.published.size(), count);
  fixture.link(true);
  EXPECT_EQ(fixture.connections.back().state, wire::ConnectionState::online);
  EXPECT_THAT(fixture.factsheets, SizeIs(2));
}

TEST(Onboard, subscribes_to_its_topics) {
  EXPECT_THAT(OnboardFixture{}.core->subscriptions(),
              ElementsAre("cosiva/v1/owner/CoSiVA/AIV1", "uagv/v2/CoSiVA/AIV1/order",
                          "uagv/v2/CoSiVA/AIV1/instantActions", "cosiva/v1/virtual_obstacles/CoSiVA/AIV1",
                          "cosiva/v1/estimate/request/CoSiVA/AIV1", "cosiva/v1/battery/change/CoSiVA/AIV1",
                          "cosiva/v1/battery/fitted/CoSiVA/AIV1", "cosiva/v1/link_check/CoSiVA/AIV1",
                          "cosiva/v1/server/heartbeat", "cosiva/v1/server/connection", "cosiva/v1/zone/+"));
}

TEST(Onboard, reports_battery_boards_and_last_tag) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.send_from_board(wire::Board::PRAV, wire::TagRead{0, 1, 0});
  fixture.run(0.1);
  EXPECT_EQ(fixture.state().battery.charge_percent, 90.0);
  EXPECT_EQ(fixture.state().battery.voltage_v, 7.4);
  ASSERT_THAT(fixture.state().information, SizeIs(2));
  EXPECT_EQ(fixture.state().information[0].type, "lastTag");
  EXPECT_EQ(fixture.state().information[0].references[0], (wire::Reference{"tag", "1"}));
  EXPECT_EQ(fixture.state().information[0].references[1].key, "distance_m");
  EXPECT_EQ(fixture.state().information[1].type, "boards");
  EXPECT_THAT(fixture.state().information[1].references, Contains(wire::Reference{"DOBS", "ok"}));
}

TEST(Onboard, reports_the_uncertainty_of_a_gauge_that_has_one) {
  OnboardFixture fixture;
  fixture.run(1.55);
  const auto reported = [&](std::uint32_t charge_ppm, std::uint16_t sd) {
    const auto permille = static_cast<std::uint16_t>(charge_ppm / 1000);
    fixture.send_from_board(wire::Board::RALI,
                            wire::Power{7400, 300, 250, permille, wire::Power::Gauge{charge_ppm, sd}});
    fixture.run(0.15);  // another whole percent causes a state
    return fixture.state();
  };
  const wire::State sure = reported(871'234, 135);
  EXPECT_NEAR(sure.battery.charge_percent, 87.1234, 1e-9);
  ASSERT_FALSE(sure.information.empty());
  EXPECT_EQ(sure.information.back().type, "battery");
  EXPECT_EQ(sure.information.back().references[0], (wire::Reference{"chargeStdDev_percent", "1.350"}));
  EXPECT_EQ(sure.information.back().references[1], (wire::Reference{"needsFullCharge", "false"}));
  EXPECT_EQ(reported(771'234, 600).information.back().references[1], (wire::Reference{"needsFullCharge", "true"}));
}

TEST(Onboard, sends_a_state_on_each_whole_percent_of_charge) {
  OnboardFixture fixture;
  fixture.run(1.45);
  EXPECT_EQ(fixture.state().battery.charge_percent, 90.0);
  fixture.charge = 889;
  fixture.run(0.15);  // the gauge reports twice a second
  EXPECT_NEAR(fixture.state().battery.charge_percent, 88.9, 1e-9);
  fixture.charge = 50;
  fixture.run(1.0);
  EXPECT_THAT(fixture.error_types(), Contains("batteryLowError"));
}

TEST(Onboard, shows_its_name_and_status_on_the_display_at_most_twice_a_second) {
  OnboardFixture fixture;
  fixture.order(to_1131());
  fixture.run(8.0);
  EXPECT_THAT(fixture.displayed, Contains("AIV1 stopped 0.0"));
  EXPECT_THAT(fixture.displayed, Contains("AIV1 Normal 0.3"));
  EXPECT_LE(fixture.displayed.size(), 16U);
}

// --- orders -------------------------------------------------------------------------------------------------------

TEST(Onboard, drives_its_order_and_reports_each_node) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.order(to_1131());
  fixture.run(0.1);
  EXPECT_EQ(fixture.state().order_id, "O-1");
  EXPECT_EQ(fixture.state().last_node_id, "loop_se@0");
  EXPECT_THAT(fixture.state().node_states, SizeIs(4));
  ASSERT_TRUE(fixture.run_until([&] { return fixture.state().last_node_id == "loop_se@565"; }, 5.0));
  EXPECT_THAT(fixture.state().node_states, SizeIs(2));
  EXPECT_THAT(fixture.state().edge_states, SizeIs(2));
  EXPECT_EQ(fixture.state().last_node_sequence_id, 4U);
  EXPECT_TRUE(fixture.state().driving);
  EXPECT_LT(*fixture.state().distance_since_last_node_m, 0.02);
  fixture.run(5.0);
  EXPECT_FALSE(fixture.state().driving);
  EXPECT_THAT(fixture.state().node_states, IsEmpty());
  EXPECT_NEAR(fixture.ground_truth.track_position(lacet4().circuit).s_m, 4.0 * edge_m, 0.01);
  ASSERT_TRUE(fixture.state().position);
  EXPECT_LT(distance(fixture.state().position->pose, fixture.ground_truth.pose(lacet4().circuit)), 0.01);
  EXPECT_EQ(fixture.state().position->map_id, "lacet4");
}

TEST(Onboard, merges_events_and_never_sends_states_faster_than_its_minimum_interval) {
  OnboardFixture fixture;
  fixture.order(to_1131());
  fixture.run(6.0);
  for (std::size_t i = 1; i < fixture.state_times.size(); ++i)
    EXPECT_GE(fixture.state_times[i] - fixture.state_times[i - 1], milliseconds{50});
}

TEST(Onboard, acknowledges_a_repeated_order_without_a_warning) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.order(to_1131());
  fixture.run(0.1);
  const auto count = fixture.states.size();
  fixture.order(to_1131());
  fixture.run(0.06);
  EXPECT_GT(fixture.states.size(), count);
  EXPECT_THAT(fixture.state().errors, IsEmpty());
  EXPECT_EQ(fixture.state().order_update_id, 0U);
}

TEST(Onboard, keeps_a_refusal_s_warning_until_a_new_order_is_accepted) {
  OnboardFixture fixture;
  fixture.run(0.5);
  auto bad = order("O-bad").through({"moon"});
  fixture.order(bad);
  fixture.run(3.0);
  ASSERT_THAT(fixture.error_types(), ElementsAre("noRouteError"));
  EXPECT_THAT(fixture.state().errors[0].references, Contains(wire::Reference{"orderId", "O-bad"}));
  EXPECT_EQ(fixture.state().order_id, "");
  fixture.order(to_1131());
  fixture.run(0.1);
  EXPECT_THAT(fixture.error_types(), IsEmpty());
}

TEST(Onboard, follows_an_order_in_spite_of_late_updates_and_removes_their_warning_at_the_next_accepted_one) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.order(to_1131());
  fixture.order(order("O-1", 2).from_sequence(8).through({"loop_se@1131", "loop_se@1414"}));
  fixture.order(order("O-1", 1).from_sequence(8).through({"loop_se@1131", "loop_se@1414"}));
  fixture.run(0.1);
  EXPECT_THAT(fixture.error_types(), ElementsAre("orderUpdateError"));
  EXPECT_EQ(fixture.state().order_update_id, 2U);
  fixture.order(order("O-1", 3).from_sequence(10).through({"loop_se@1414", "loop_se@1696"}));
  fixture.run(0.1);
  EXPECT_THAT(fixture.error_types(), IsEmpty());
  EXPECT_TRUE(fixture.state().driving);
}

TEST(Onboard, refuses_messages_for_other_vehicles_or_of_other_versions) {
  const auto refused = [](const std::function<void(wire::Order&)>& spoil) {
    OnboardFixture fixture;
    fixture.run(0.5);
    auto text = to_1131();
    spoil(text.order());
    fixture.order(text);
    fixture.run(0.1);
    return fixture.state().order_id.empty() ? fixture.error_types() : std::vector<std::string>{"accepted"};
  };
  EXPECT_THAT(refused([](wire::Order& o) { o.header.serial_number = "AIV2"; }), ElementsAre("validationError"));
  EXPECT_THAT(refused([](wire::Order& o) { o.header.manufacturer = "Other"; }), ElementsAre("validationError"));
  EXPECT_THAT(refused([](wire::Order& o) { o.header.version = "3.0.0"; }), ElementsAre("validationError"));
  EXPECT_THAT(refused([](wire::Order& o) { o.header.version = "2.0.0"; }), ElementsAre("accepted"));
}

TEST(Onboard, warns_of_malformed_messages_and_continues) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.order(to_1131());
  for (const char* text : {"", "{", "[]", "null", "{\"orderId\":1}", "\xFF\xFE"}) {
    fixture.receive("uagv/v2/CoSiVA/AIV1/order", text);
    fixture.receive("uagv/v2/CoSiVA/AIV1/instantActions", text);
    fixture.receive(wire::server_connection_topic, text);
    fixture.receive("cosiva/v1/zone/toml", text);
    fixture.receive("some/where/else", text);
  }
  for (const wire::Board board : wire::all_boards)
    fixture.feed(wire::InputKind::bytes, wire::port_name(1, board), std::string("\x01\x02garbage\x00\x00", 11));
  fixture.feed(wire::InputKind::bytes, "9/PILS", "garbage");
  fixture.feed(wire::InputKind::command, "somebody", "garbage");
  fixture.run(2.0);
  EXPECT_THAT(fixture.error_types(), Contains("validationError"));
  EXPECT_LE(fixture.state().errors.size(), 20U);
  EXPECT_TRUE(fixture.state().driving);
  EXPECT_EQ(fixture.state().order_id, "O-1");
}

TEST(Onboard, every_message_it_publishes_decodes) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.order(order("bad").through({"nowhere"}));
  fixture.order(to_1131());
  fixture.act("startPause", "p");
  fixture.act("nonsense", "n");
  fixture.run(1.0);
  fixture.act("factsheetRequest", "f");
  fixture.act("stopPause", "q");
  fixture.run(8.0);
  fixture.farewell();
  EXPECT_THAT(fixture.undecodable, IsEmpty());
}

// --- zone, position and state file --------------------------------------------------------------------------------

TEST(Onboard, waits_for_the_zone_from_the_broker) {
  OnboardFixture fixture{{.zone_notified = false}};
  fixture.run(0.5);
  EXPECT_THAT(fixture.error_types(), Contains("zoneUnknown"));
  fixture.order(to_1131());
  fixture.run(0.1);
  EXPECT_THAT(fixture.error_types(), Contains("noRouteError"));
  fixture.receive("cosiva/v1/zone/toml", "this is no zone", true);
  EXPECT_EQ(fixture.logs.back().level, 'e');
  fixture.receive("cosiva/v1/zone/toml", test::lacet4_configuration().text, true);
  fixture.run(0.5);
  EXPECT_THAT(fixture.error_types(), Not(Contains("zoneUnknown")));
  EXPECT_THAT(fixture.factsheets, SizeIs(1));
  ASSERT_TRUE(fixture.state().position);
  fixture.order(to_1131());
  fixture.run(1.0);
  EXPECT_TRUE(fixture.state().driving);
}

TEST(Onboard, has_no_position_until_a_tag_is_read) {
  OnboardFixture fixture{{.start = std::nullopt}};
  fixture.run(0.5);
  EXPECT_FALSE(fixture.state().position);
  EXPECT_FALSE(fixture.core->estimated_pose());
  EXPECT_THAT(fixture.error_types(), ElementsAre("positionUnknown"));
  EXPECT_THAT(fixture.visualizations, IsEmpty());
  fixture.send_from_board(wire::Board::PRAV, wire::TagRead{0, 2, 0});
  fixture.run(0.1);
  EXPECT_TRUE(fixture.state().position);
  EXPECT_TRUE(fixture.core->estimated_pose());
}

TEST(Onboard, accepts_initPosition) {
  OnboardFixture fixture{{.start = std::nullopt}};
  fixture.run(0.5);
  fixture.act("initPosition", "bad-1", {{"x", -0.5}, {"y", -0.15}});
  fixture.act("initPosition", "bad-2", {{"x", 9.0}, {"y", 9.0}, {"theta", 0.0}});
  fixture.act("initPosition", "bad-3", {{"x", -0.5}, {"y", -0.15}, {"theta", 0.0}, {"mapId", std::string("attic")}});
  fixture.run(0.1);
  for (const char* id : {"bad-1", "bad-2", "bad-3"}) EXPECT_EQ(fixture.action(id)->status, ActionStatus::failed) << id;
  EXPECT_FALSE(fixture.state().position);
  fixture.act("initPosition", "good",
              {{"x", -0.5},
               {"y", -0.15},
               {"theta", 0.0},
               {"mapId", std::string("lacet4")},
               {"lastNodeId", std::string("east@190")}});
  fixture.run(0.1);
  EXPECT_EQ(fixture.action("good")->status, ActionStatus::finished);
  ASSERT_TRUE(fixture.state().position);
  EXPECT_NEAR(fixture.state().position->pose.x_m, -0.5, 1e-6);
  EXPECT_EQ(fixture.state().last_node_id, "east@190");
}

TEST(Onboard, restores_its_position_after_a_crash) {
  OnboardFixture before;
  before.run(0.5);
  before.order(to_1131());
  before.run(2.0);
  ASSERT_FALSE(before.persisted.empty());
  auto setup = before.reborn();
  setup.odometer_m += 0.07;  // it moved on while the program was down
  setup.ground_truth = lacet4().circuit.advance(setup.ground_truth, 0.07);
  OnboardFixture after{setup};
  after.run(0.2);
  ASSERT_TRUE(after.core->estimated_pose());
  EXPECT_LT(distance(*after.core->estimated_pose(), after.ground_truth.pose(lacet4().circuit)), 0.01);
}

TEST(Onboard, does_not_trust_a_persisted_position_of_another_odometer_or_zone) {
  OnboardFixture before;
  before.run(0.5);
  before.order(to_1131());
  before.run(2.0);
  auto other_session = before.reborn();
  other_session.session = 78;
  other_session.start = std::nullopt;
  OnboardFixture after{other_session};
  after.run(0.5);
  EXPECT_FALSE(after.core->estimated_pose());

  auto other_zone = before.reborn();
  auto persisted = persisted_position_from_json(other_zone.persisted).value();
  persisted.zone = "attic";
  other_zone.persisted = to_json(persisted);
  OnboardFixture elsewhere{other_zone};
  elsewhere.run(0.5);
  ASSERT_TRUE(elsewhere.core->estimated_pose()) << "the configured start counts then";
  EXPECT_LT(distance(*elsewhere.core->estimated_pose(), lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.0))), 1e-9);
}

TEST(Onboard, survives_a_damaged_state_file) {
  OnboardFixture fixture{{.persisted = "{\"zone\":7}"}};
  fixture.run(0.5);
  EXPECT_TRUE(fixture.core->estimated_pose());
}

TEST(Onboard, stays_paused_and_slow_over_a_crash) {
  OnboardFixture before;
  before.run(0.5);
  before.act("startPause", "p");
  before.act("setSpeedLimit", "s", {{"profile", std::string("slow")}});
  before.run(0.5);
  OnboardFixture after{before.reborn()};
  after.run(0.5);
  EXPECT_TRUE(after.state().paused);
  after.order(to_1131());
  after.run(2.0);
  EXPECT_EQ(after.speed_mps, 0.0);
  after.act("stopPause", "q");
  after.run(2.0);
  EXPECT_NEAR(after.speed_mps, 0.15, 1e-9);
}

TEST(Onboard, stops_its_motors_and_saves_its_position_at_a_clean_end) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.order(to_1131());
  fixture.run(1.05);
  ASSERT_GT(fixture.last_drive().speed_mmps, 0);
  fixture.persisted.clear();
  fixture.farewell();
  EXPECT_EQ(fixture.last_drive(), (wire::Drive{0, 0, 800, 0})) << "the medium profile's braking";
  EXPECT_FALSE(fixture.persisted.empty());
  EXPECT_EQ(fixture.core->will()->message.topic, "uagv/v2/CoSiVA/AIV1/connection");
}

TEST(Onboard, ends_without_a_zone_as_well) {
  OnboardFixture fixture{{.zone_notified = false}};
  fixture.farewell();
  EXPECT_EQ(fixture.connections.back().state, wire::ConnectionState::offline);
  EXPECT_THAT(fixture.persisted, IsEmpty());
  EXPECT_EQ(fixture.drives, 0);
  EXPECT_EQ(fixture.core->estimated_speed_mps(), 0.0);
  EXPECT_FALSE(fixture.core->estimated_pose());
}

TEST(Onboard, folds_its_name_alone_before_a_zone_is_known) {
  const OnboardFixture fixture{{.zone_notified = false}};
  Digest folded;
  fixture.core->fold(folded);
  Digest expected;
  expected.add(std::string_view{"AIV1"});
  expected.add(std::uint64_t{0});
  EXPECT_EQ(folded.value(), expected.value());
}

TEST(Onboard, folds_position_motion_holds_and_order) {
  const auto folded = [](const OnboardFixture& fixture) {
    Digest digest;
    fixture.core->fold(digest);
    return digest.value();
  };
  OnboardFixture fixture;
  fixture.run(0.5);
  // The parts that do not depend on where the vehicle is, in the order of the digest.
  const auto expected = [&](std::uint64_t holds, std::string_view order_id, std::uint64_t update_id,
                            std::uint64_t last_sequence_id) {
    const DrivingContext idle{lacet4(), {}};
    const zone::TrackPosition here = at(lacet4(), "loop_se", 0.0);
    Digest digest;
    digest.add(std::string_view{"AIV1"});
    digest.add(std::uint64_t{1});
    digest.add(std::uint64_t{1});
    digest.add(std::uint64_t{here.section});
    digest.add(here.s_m);
    digest.add(0.0);  // travelled
    digest.add(0.0);  // speed
    digest.add(holds);
    digest.add(order_id);
    digest.add(update_id);
    digest.add(last_sequence_id);
    digest.add(std::uint64_t{0});
    idle.virtual_bodies().fold(digest);
    idle.sighting().fold(digest);
    idle.neighbours().fold(digest);
    return digest.value();
  };
  EXPECT_EQ(folded(fixture), expected(0, "", 0, 0));
  fixture.act("startPause", "p");
  const auto paused = static_cast<std::uint64_t>(Hold::paused);
  EXPECT_EQ(folded(fixture), expected(paused, "", 0, 0));
  fixture.order(order("O-1", 3).from_sequence(6).through({"loop_se@0", "loop_se@283"}));
  EXPECT_EQ(folded(fixture), expected(paused, "O-1", 3, 6));
}

TEST(Onboard, folds_the_pose_of_a_vehicle_off_the_path) {
  const auto folded = [](double x_m, double y_m, double heading_rad) {
    PersistedPosition persisted;
    persisted.zone = "lacet4";
    persisted.session = 77;
    persisted.off_path = true;
    persisted.pose = Pose2{x_m, y_m, heading_rad};
    OnboardFixture fixture{{.start = std::nullopt, .persisted = to_json(persisted)}};
    fixture.run(0.2);
    EXPECT_TRUE(fixture.core->estimated_pose());
    Digest digest;
    fixture.core->fold(digest);
    return digest.value();
  };
  const std::uint64_t reference = folded(3.0, 4.0, 0.5);
  EXPECT_EQ(folded(3.0, 4.0, 0.5), reference);
  EXPECT_NE(folded(3.5, 4.0, 0.5), reference);
  EXPECT_NE(folded(3.0, 4.5, 0.5), reference);
  EXPECT_NE(folded(3.0, 4.0, 1.0), reference);
}

TEST(Onboard, warns_of_a_server_s_connection_without_a_state_or_too_long) {
  OnboardFixture fixture;
  fixture.logs.clear();
  fixture.receive(wire::server_connection_topic, "{}");
  ASSERT_THAT(fixture.logs, SizeIs(1));
  EXPECT_EQ(fixture.logs[0], (wire::Log{'w', "the server's connection message has no connectionState"}));
  const std::string offline = R"({"connectionState":"OFFLINE"})";
  fixture.receive(wire::server_connection_topic, offline + std::string(4096 - offline.size(), ' '));
  EXPECT_THAT(fixture.logs, SizeIs(1));
  fixture.receive(wire::server_connection_topic, offline + std::string(4097 - offline.size(), ' '));
  EXPECT_THAT(fixture.logs, SizeIs(2));
}

TEST(Onboard, logs_the_reason_for_which_it_does_not_use_a_saved_position) {
  const OnboardFixture fixture{{.persisted = "{\"zone\":7}"}};
  ASSERT_FALSE(fixture.logs.empty());
  EXPECT_EQ(fixture.logs[0].level, 'w');
  EXPECT_THAT(fixture.logs[0].text, HasSubstr("saved position not used: "));
}

TEST(Onboard, follows_the_zone_of_its_owner_s_control_area_only) {
  OnboardFixture fixture{{.zone_notified = false}};
  fixture.receive("cosiva/v1/owner/CoSiVA/AIV1",
                  wire::to_json(wire::Owner{"north", 1, fixture.now, std::nullopt, std::nullopt}));
  EXPECT_THAT(fixture.listens, Contains("cosiva/v1/area/north/zone/+"));
  fixture.receive("cosiva/v1/zone/toml", test::lacet4_configuration().text);
  EXPECT_THAT(fixture.factsheets, IsEmpty());
  fixture.receive("cosiva/v1/area/north/zone/toml", "");
  EXPECT_THAT(fixture.factsheets, IsEmpty()) << "an empty message clears a topic";
  fixture.receive("cosiva/v1/area/north/zone/toml", test::lacet4_configuration().text);
  EXPECT_THAT(fixture.factsheets, SizeIs(1));
}

// --- options ------------------------------------------------------------------------------------------------------

TEST(Options, survive_a_json_round_trip) {
  OnboardOptions options;
  options.number = 7;
  options.id = {"Maker", "S-7"};
  options.interface_name = "twin";
  options.zone = zone::ZoneConfiguration{"toml", "a.toml", "name = \"é\"\n"};
  options.start = OnboardOptions::Start{"east", 0.125};
  options.state_period = milliseconds{250};
  options.cycle = milliseconds{100};
  options.rules = {SpeedRules::Kind::fuzzy, {}, {}};
  options.v2x = false;
  const auto back = onboard_options_from_json(to_json(options));
  ASSERT_TRUE(back) << to_string(back.error());
  EXPECT_EQ(to_json(*back), to_json(options));
  EXPECT_EQ(back->zone, options.zone);
  EXPECT_EQ(back->state_period, milliseconds{250});
  EXPECT_EQ(OnboardCore{*back}.tick_period(), milliseconds{100});
  EXPECT_EQ(back->rules, options.rules);
  EXPECT_FALSE(onboard_options_from_json(to_json(OnboardOptions{}))->zone);
  EXPECT_TRUE(onboard_options_from_json(to_json(OnboardOptions{}))->v2x);
  EXPECT_FALSE(onboard_options_from_json("{}")->v2x) << "a journal from before V2X";
}

TEST(Options, that_are_invalid_are_refused_by_field) {
  const auto location = [](std::string_view json) {
    const auto options = onboard_options_from_json(json);
    return options ? std::string("accepted") : options.error().location;
  };
  EXPECT_EQ(location(R"({"number":0})"), "number");
  EXPECT_EQ(location(R"({"number":1.5})"), "number");
  EXPECT_EQ(location(R"({"serialNumber":"a/b"})"), "serialNumber");
  EXPECT_EQ(location(R"({"zone":{"format":"toml"}})"), "zone");
  EXPECT_EQ(location(R"({"start":{"section":"east"}})"), "start");
  EXPECT_EQ(location(R"({"state_period_ms":0})"), "state_period_ms");
  EXPECT_EQ(location(R"({"cycle_ms":0})"), "cycle_ms");
  EXPECT_FALSE(onboard_options_from_json("[]"));
  EXPECT_FALSE(onboard_options_from_json("{"));
}

TEST(Onboard, has_a_port_for_each_board) {
  EXPECT_THAT(OnboardFixture{}.core->ports(), ElementsAre("1/PILS", "1/PRAV", "1/DOBS", "1/RALI"));
}

TEST(Onboard, is_deterministic) {
  const auto digest = [] {
    OnboardFixture fixture;
    fixture.run(0.5);
    fixture.order(to_1131());
    fixture.run(3.0);
    Digest folded;
    fixture.core->fold(folded);
    for (const auto& publish : fixture.published) folded.add(std::string_view{publish.payload});
    return folded.value();
  };
  EXPECT_EQ(digest(), digest());
}

// Figure 18: changeBattery is sent to the vehicle, and the vehicle's own program sends batteryReady.
TEST(OnboardCore, responds_to_changeBattery_when_rali_reads_a_full_battery) {
  OnboardFixture fixture;
  fixture.charge = 300;
  fixture.run(1.0);
  fixture.receive("cosiva/v1/battery/change/CoSiVA/AIV1", to_json(wire::BatteryRequest{{"red", 1, ""}, false}), true);
  const auto responses = [&fixture] {
    std::vector<std::string> payloads;
    for (const wire::Publish& message : fixture.published)
      if (message.topic == "cosiva/v1/battery/ready/CoSiVA/AIV1") payloads.push_back(message.payload);
    return payloads;
  };
  fixture.run(10.0);
  EXPECT_TRUE(responses().empty()) << "the old battery is still on board";
  fixture.charge = 1000;
  fixture.run(4.0);
  ASSERT_EQ(responses().size(), 1U);
  EXPECT_EQ(wire::battery_ready_from_json(responses()[0]),
            (wire::BatteryReady{"red", "unknown", 0.0, 0.0, 25.0, 100.0}));
  fixture.run(4.0);
  EXPECT_EQ(responses().size(), 1U);
}

}  // namespace
}  // namespace cosiva::aiv
