#include "cosiva/aiv/onboard/onboard_core.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_bench.h"
#include "cosiva/aiv/onboard/persisted_position.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::at;
using test::lacet4;
using test::OnboardBench;
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

// --- telling the world about itself -------------------------------------------------------------------------------

TEST(Onboard, announces_itself_when_the_broker_comes) {
  OnboardBench bench;
  ASSERT_THAT(bench.connections, SizeIs(1));
  EXPECT_EQ(bench.connections[0].state, wire::ConnectionState::online);
  EXPECT_EQ(bench.published[0].topic, "uagv/v2/CoSiVA/AIV1/connection");
  EXPECT_TRUE(bench.published[0].retained);
  EXPECT_EQ(bench.published[0].qos, 1);
  ASSERT_THAT(bench.factsheets, SizeIs(1));
  EXPECT_TRUE(bench.published[1].retained);
  EXPECT_EQ(bench.published[1].qos, 0);
  EXPECT_EQ(bench.factsheets[0].speed_max_mps, 0.5);
  EXPECT_THAT(bench.factsheets[0].actions, SizeIs(10));
}

TEST(Onboard, tells_its_state_first_when_its_boards_have_answered) {
  OnboardBench bench;
  EXPECT_THAT(bench.states, IsEmpty());
  ASSERT_TRUE(bench.run_until([&] { return !bench.states.empty(); }, 0.65));
  EXPECT_THAT(bench.error_types(), IsEmpty());
  EXPECT_EQ(bench.state().battery.charge_percent, 90.0);
}

TEST(Onboard, whose_board_never_answers_says_so_after_700_ms) {
  OnboardBench::Setup setup;
  setup.boards_up = false;
  OnboardBench bench{setup};
  for (const wire::Board board : {wire::Board::PILS, wire::Board::PRAV, wire::Board::RALI}) bench.plug(board);
  bench.run(0.69);
  EXPECT_THAT(bench.states, IsEmpty());
  EXPECT_THAT(bench.boards_reports, IsEmpty());
  bench.run(0.6);
  ASSERT_FALSE(bench.states.empty());
  EXPECT_THAT(bench.error_types(), ElementsAre("boardLost"));
  EXPECT_FALSE(bench.boards_reports.empty());
}

TEST(Onboard, leaves_a_will_that_says_the_connection_broke) {
  OnboardBench bench;
  const auto will = bench.core->will();
  ASSERT_TRUE(will);
  EXPECT_TRUE(will->message.retained);
  EXPECT_EQ(will->message.qos, 1);
  EXPECT_EQ(will->message.topic, "uagv/v2/CoSiVA/AIV1/connection");
  EXPECT_EQ(wire::vda5050::decode_connection(will->message.payload)->state, wire::ConnectionState::connection_broken);
}

TEST(Onboard, says_offline_at_a_clean_end) {
  OnboardBench bench;
  bench.run(0.5);
  bench.farewell();
  EXPECT_EQ(bench.connections.back().state, wire::ConnectionState::offline);
  EXPECT_TRUE(bench.published.back().retained);
}

TEST(Onboard, sends_a_state_every_second_and_its_place_every_100_ms) {
  OnboardBench bench;
  bench.run(2.0);
  const auto states = bench.states.size();
  const auto visualizations = bench.visualizations.size();
  bench.run(10.0);
  EXPECT_EQ(bench.states.size() - states, 10U);
  EXPECT_EQ(bench.visualizations.size() - visualizations, 100U);
}

TEST(Onboard, counts_headers_per_topic_without_gap) {
  OnboardBench bench;
  bench.order(to_1131());
  bench.run(5.0);
  for (std::size_t i = 0; i < bench.states.size(); ++i) EXPECT_EQ(bench.states[i].header.header_id, i);
  for (std::size_t i = 0; i < bench.visualizations.size(); ++i) EXPECT_EQ(bench.visualizations[i].header.header_id, i);
}

TEST(Onboard, publishes_nothing_while_the_broker_is_away_and_starts_anew_when_it_is_back) {
  OnboardBench bench;
  bench.run(1.0);
  bench.link(false);
  const auto count = bench.published.size();
  bench.run(3.0);
  EXPECT_EQ(bench.published.size(), count);
  bench.link(true);
  EXPECT_EQ(bench.connections.back().state, wire::ConnectionState::online);
  EXPECT_THAT(bench.factsheets, SizeIs(2));
}

TEST(Onboard, subscribes_to_what_concerns_it) {
  EXPECT_THAT(
      OnboardBench{}.core->subscriptions(),
      ElementsAre("cosiva/v1/owner/CoSiVA/AIV1", "uagv/v2/CoSiVA/AIV1/order", "uagv/v2/CoSiVA/AIV1/instantActions",
                  "cosiva/v1/virtual_obstacles/CoSiVA/AIV1", "cosiva/v1/estimate/request/CoSiVA/AIV1", "cosiva/v1/server/heartbeat",
                  "cosiva/v1/server/connection", "cosiva/v1/zone/+"));
}

TEST(Onboard, tells_battery_boards_and_last_tag) {
  OnboardBench bench;
  bench.run(1.0);
  bench.say(wire::Board::PRAV, wire::TagRead{0, 1, 0});
  bench.run(0.1);
  EXPECT_EQ(bench.state().battery.charge_percent, 90.0);
  EXPECT_EQ(bench.state().battery.voltage_v, 7.4);
  ASSERT_THAT(bench.state().information, SizeIs(2));
  EXPECT_EQ(bench.state().information[0].type, "lastTag");
  EXPECT_EQ(bench.state().information[0].references[0], (wire::Reference{"tag", "1"}));
  EXPECT_EQ(bench.state().information[0].references[1].key, "distance_m");
  EXPECT_EQ(bench.state().information[1].type, "boards");
  EXPECT_THAT(bench.state().information[1].references, Contains(wire::Reference{"DOBS", "ok"}));
}

TEST(Onboard, tells_how_sure_a_gauge_is_that_knows_it) {
  OnboardBench bench;
  bench.run(1.55);
  const auto told = [&](std::uint32_t charge_ppm, std::uint16_t sd) {
    const auto permille = static_cast<std::uint16_t>(charge_ppm / 1000);
    bench.say(wire::Board::RALI, wire::Power{7400, 300, 250, permille, wire::Power::Gauge{charge_ppm, sd}});
    bench.run(0.15);  // another whole percent is worth a state
    return bench.state();
  };
  const wire::State sure = told(871'234, 135);
  EXPECT_NEAR(sure.battery.charge_percent, 87.1234, 1e-9);
  ASSERT_FALSE(sure.information.empty());
  EXPECT_EQ(sure.information.back().type, "battery");
  EXPECT_EQ(sure.information.back().references[0], (wire::Reference{"chargeStdDev_percent", "1.350"}));
  EXPECT_EQ(sure.information.back().references[1], (wire::Reference{"needsFullCharge", "false"}));
  EXPECT_EQ(told(771'234, 600).information.back().references[1], (wire::Reference{"needsFullCharge", "true"}));
}

TEST(Onboard, sends_a_state_on_each_whole_percent_of_charge) {
  OnboardBench bench;
  bench.run(1.45);
  EXPECT_EQ(bench.state().battery.charge_percent, 90.0);
  bench.charge = 889;
  bench.run(0.15);  // the gauge speaks twice a second
  EXPECT_NEAR(bench.state().battery.charge_percent, 88.9, 1e-9);
  bench.charge = 50;
  bench.run(1.0);
  EXPECT_THAT(bench.error_types(), Contains("batteryLowError"));
}

TEST(Onboard, shows_its_name_and_status_on_the_display_at_most_twice_a_second) {
  OnboardBench bench;
  bench.order(to_1131());
  bench.run(8.0);
  EXPECT_THAT(bench.displayed, Contains("AIV1 stopped 0.0"));
  EXPECT_THAT(bench.displayed, Contains("AIV1 Normal 0.3"));
  EXPECT_LE(bench.displayed.size(), 16U);
}

// --- orders -------------------------------------------------------------------------------------------------------

TEST(Onboard, drives_its_order_and_reports_each_node) {
  OnboardBench bench;
  bench.run(0.5);
  bench.order(to_1131());
  bench.run(0.1);
  EXPECT_EQ(bench.state().order_id, "O-1");
  EXPECT_EQ(bench.state().last_node_id, "loop_se@0");
  EXPECT_THAT(bench.state().node_states, SizeIs(4));
  ASSERT_TRUE(bench.run_until([&] { return bench.state().last_node_id == "loop_se@565"; }, 5.0));
  EXPECT_THAT(bench.state().node_states, SizeIs(2));
  EXPECT_THAT(bench.state().edge_states, SizeIs(2));
  EXPECT_EQ(bench.state().last_node_sequence_id, 4U);
  EXPECT_TRUE(bench.state().driving);
  EXPECT_LT(*bench.state().distance_since_last_node_m, 0.02);
  bench.run(5.0);
  EXPECT_FALSE(bench.state().driving);
  EXPECT_THAT(bench.state().node_states, IsEmpty());
  EXPECT_NEAR(bench.ground_truth.place(lacet4().circuit).s_m, 4.0 * edge_m, 0.01);
  ASSERT_TRUE(bench.state().position);
  EXPECT_LT(distance(bench.state().position->pose, bench.ground_truth.pose(lacet4().circuit)), 0.01);
  EXPECT_EQ(bench.state().position->map_id, "lacet4");
}

TEST(Onboard, merges_events_and_never_sends_states_faster_than_it_said) {
  OnboardBench bench;
  bench.order(to_1131());
  bench.run(6.0);
  for (std::size_t i = 1; i < bench.state_times.size(); ++i)
    EXPECT_GE(bench.state_times[i] - bench.state_times[i - 1], milliseconds{50});
}

TEST(Onboard, acknowledges_an_order_that_comes_again_without_a_warning) {
  OnboardBench bench;
  bench.run(0.5);
  bench.order(to_1131());
  bench.run(0.1);
  const auto count = bench.states.size();
  bench.order(to_1131());
  bench.run(0.06);
  EXPECT_GT(bench.states.size(), count);
  EXPECT_THAT(bench.state().errors, IsEmpty());
  EXPECT_EQ(bench.state().order_update_id, 0U);
}

TEST(Onboard, keeps_a_refusal_s_warning_until_a_new_order_is_accepted) {
  OnboardBench bench;
  bench.run(0.5);
  auto bad = order("O-bad").through({"moon"});
  bench.order(bad);
  bench.run(3.0);
  ASSERT_THAT(bench.error_types(), ElementsAre("noRouteError"));
  EXPECT_THAT(bench.state().errors[0].references, Contains(wire::Reference{"orderId", "O-bad"}));
  EXPECT_EQ(bench.state().order_id, "");
  bench.order(to_1131());
  bench.run(0.1);
  EXPECT_THAT(bench.error_types(), IsEmpty());
}

TEST(Onboard, follows_an_order_in_spite_of_late_updates_and_forgets_their_warning_at_the_next_good_one) {
  OnboardBench bench;
  bench.run(0.5);
  bench.order(to_1131());
  bench.order(order("O-1", 2).from_sequence(8).through({"loop_se@1131", "loop_se@1414"}));
  bench.order(order("O-1", 1).from_sequence(8).through({"loop_se@1131", "loop_se@1414"}));
  bench.run(0.1);
  EXPECT_THAT(bench.error_types(), ElementsAre("orderUpdateError"));
  EXPECT_EQ(bench.state().order_update_id, 2U);
  bench.order(order("O-1", 3).from_sequence(10).through({"loop_se@1414", "loop_se@1696"}));
  bench.run(0.1);
  EXPECT_THAT(bench.error_types(), IsEmpty());
  EXPECT_TRUE(bench.state().driving);
}

TEST(Onboard, refuses_what_is_not_for_it_or_not_its_language) {
  const auto refused = [](const std::function<void(wire::Order&)>& spoil) {
    OnboardBench bench;
    bench.run(0.5);
    auto text = to_1131();
    spoil(text.order());
    bench.order(text);
    bench.run(0.1);
    return bench.state().order_id.empty() ? bench.error_types() : std::vector<std::string>{"accepted"};
  };
  EXPECT_THAT(refused([](wire::Order& o) { o.header.serial_number = "AIV2"; }), ElementsAre("validationError"));
  EXPECT_THAT(refused([](wire::Order& o) { o.header.manufacturer = "Other"; }), ElementsAre("validationError"));
  EXPECT_THAT(refused([](wire::Order& o) { o.header.version = "3.0.0"; }), ElementsAre("validationError"));
  EXPECT_THAT(refused([](wire::Order& o) { o.header.version = "2.0.0"; }), ElementsAre("accepted"));
}

TEST(Onboard, warns_of_malformed_messages_and_goes_on) {
  OnboardBench bench;
  bench.run(0.5);
  bench.order(to_1131());
  for (const char* text : {"", "{", "[]", "null", "{\"orderId\":1}", "\xFF\xFE"}) {
    bench.hear("uagv/v2/CoSiVA/AIV1/order", text);
    bench.hear("uagv/v2/CoSiVA/AIV1/instantActions", text);
    bench.hear(wire::server_connection_topic, text);
    bench.hear("cosiva/v1/zone/toml", text);
    bench.hear("some/where/else", text);
  }
  for (const wire::Board board : wire::all_boards)
    bench.feed(wire::InputKind::bytes, wire::port_name(1, board), std::string("\x01\x02garbage\x00\x00", 11));
  bench.feed(wire::InputKind::bytes, "9/PILS", "garbage");
  bench.feed(wire::InputKind::command, "somebody", "garbage");
  bench.run(2.0);
  EXPECT_THAT(bench.error_types(), Contains("validationError"));
  EXPECT_LE(bench.state().errors.size(), 20U);
  EXPECT_TRUE(bench.state().driving);
  EXPECT_EQ(bench.state().order_id, "O-1");
}

TEST(Onboard, every_message_it_publishes_decodes) {
  OnboardBench bench;
  bench.run(0.5);
  bench.order(order("bad").through({"nowhere"}));
  bench.order(to_1131());
  bench.act("startPause", "p");
  bench.act("nonsense", "n");
  bench.run(1.0);
  bench.act("factsheetRequest", "f");
  bench.act("stopPause", "q");
  bench.run(8.0);
  bench.farewell();
  EXPECT_THAT(bench.undecodable, IsEmpty());
}

// --- zone, place and memory ---------------------------------------------------------------------------------------

TEST(Onboard, waits_for_the_zone_from_the_broker) {
  OnboardBench bench{{.zone_told = false}};
  bench.run(0.5);
  EXPECT_THAT(bench.error_types(), Contains("zoneUnknown"));
  bench.order(to_1131());
  bench.run(0.1);
  EXPECT_THAT(bench.error_types(), Contains("noRouteError"));
  bench.hear("cosiva/v1/zone/toml", "this is no zone", true);
  EXPECT_EQ(bench.logs.back().level, 'e');
  bench.hear("cosiva/v1/zone/toml", test::lacet4_configuration().text, true);
  bench.run(0.5);
  EXPECT_THAT(bench.error_types(), Not(Contains("zoneUnknown")));
  EXPECT_THAT(bench.factsheets, SizeIs(1));
  ASSERT_TRUE(bench.state().position);
  bench.order(to_1131());
  bench.run(1.0);
  EXPECT_TRUE(bench.state().driving);
}

TEST(Onboard, does_not_know_where_it_is_until_a_tag_tells) {
  OnboardBench bench{{.start = std::nullopt}};
  bench.run(0.5);
  EXPECT_FALSE(bench.state().position);
  EXPECT_FALSE(bench.core->estimated_pose());
  EXPECT_THAT(bench.error_types(), ElementsAre("positionUnknown"));
  EXPECT_THAT(bench.visualizations, IsEmpty());
  bench.say(wire::Board::PRAV, wire::TagRead{0, 2, 0});
  bench.run(0.1);
  EXPECT_TRUE(bench.state().position);
  EXPECT_TRUE(bench.core->estimated_pose());
}

TEST(Onboard, takes_initPosition) {
  OnboardBench bench{{.start = std::nullopt}};
  bench.run(0.5);
  bench.act("initPosition", "bad-1", {{"x", -0.5}, {"y", -0.15}});
  bench.act("initPosition", "bad-2", {{"x", 9.0}, {"y", 9.0}, {"theta", 0.0}});
  bench.act("initPosition", "bad-3", {{"x", -0.5}, {"y", -0.15}, {"theta", 0.0}, {"mapId", std::string("attic")}});
  bench.run(0.1);
  for (const char* id : {"bad-1", "bad-2", "bad-3"}) EXPECT_EQ(bench.action(id)->status, ActionStatus::failed) << id;
  EXPECT_FALSE(bench.state().position);
  bench.act("initPosition", "good",
            {{"x", -0.5},
             {"y", -0.15},
             {"theta", 0.0},
             {"mapId", std::string("lacet4")},
             {"lastNodeId", std::string("east@190")}});
  bench.run(0.1);
  EXPECT_EQ(bench.action("good")->status, ActionStatus::finished);
  ASSERT_TRUE(bench.state().position);
  EXPECT_NEAR(bench.state().position->pose.x_m, -0.5, 1e-6);
  EXPECT_EQ(bench.state().last_node_id, "east@190");
}

TEST(Onboard, restores_its_position_after_a_crash) {
  OnboardBench before;
  before.run(0.5);
  before.order(to_1131());
  before.run(2.0);
  ASSERT_FALSE(before.persisted.empty());
  auto setup = before.reborn();
  setup.odometer_m += 0.07;  // it rolled on while nobody listened
  setup.ground_truth = lacet4().circuit.advance(setup.ground_truth, 0.07);
  OnboardBench after{setup};
  after.run(0.2);
  ASSERT_TRUE(after.core->estimated_pose());
  EXPECT_LT(distance(*after.core->estimated_pose(), after.ground_truth.pose(lacet4().circuit)), 0.01);
}

TEST(Onboard, does_not_trust_a_persisted_position_of_another_odometer_or_zone) {
  OnboardBench before;
  before.run(0.5);
  before.order(to_1131());
  before.run(2.0);
  auto other_session = before.reborn();
  other_session.session = 78;
  other_session.start = std::nullopt;
  OnboardBench after{other_session};
  after.run(0.5);
  EXPECT_FALSE(after.core->estimated_pose());

  auto other_zone = before.reborn();
  auto persisted = persisted_position_from_json(other_zone.persisted).value();
  persisted.zone = "attic";
  other_zone.persisted = to_json(persisted);
  OnboardBench elsewhere{other_zone};
  elsewhere.run(0.5);
  ASSERT_TRUE(elsewhere.core->estimated_pose()) << "then the start it was told counts";
  EXPECT_LT(distance(*elsewhere.core->estimated_pose(), lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.0))), 1e-9);
}

TEST(Onboard, survives_a_damaged_state_file) {
  OnboardBench bench{{.persisted = "{\"zone\":7}"}};
  bench.run(0.5);
  EXPECT_TRUE(bench.core->estimated_pose());
}

TEST(Onboard, stays_paused_and_slow_over_a_crash) {
  OnboardBench before;
  before.run(0.5);
  before.act("startPause", "p");
  before.act("setSpeedLimit", "s", {{"profile", std::string("slow")}});
  before.run(0.5);
  OnboardBench after{before.reborn()};
  after.run(0.5);
  EXPECT_TRUE(after.state().paused);
  after.order(to_1131());
  after.run(2.0);
  EXPECT_EQ(after.speed_mps, 0.0);
  after.act("stopPause", "q");
  after.run(2.0);
  EXPECT_NEAR(after.speed_mps, 0.15, 1e-9);
}

// --- options ------------------------------------------------------------------------------------------------------

TEST(Options, come_back_from_json_as_they_were) {
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
  EXPECT_FALSE(onboard_options_from_json("{}")->v2x) << "a journal from before there was any";
}

TEST(Options, that_make_no_sense_are_refused_by_field) {
  const auto place = [](std::string_view json) {
    const auto options = onboard_options_from_json(json);
    return options ? std::string("accepted") : options.error().place;
  };
  EXPECT_EQ(place(R"({"number":0})"), "number");
  EXPECT_EQ(place(R"({"number":1.5})"), "number");
  EXPECT_EQ(place(R"({"serialNumber":"a/b"})"), "serialNumber");
  EXPECT_EQ(place(R"({"zone":{"format":"toml"}})"), "zone");
  EXPECT_EQ(place(R"({"start":{"section":"east"}})"), "start");
  EXPECT_EQ(place(R"({"state_period_ms":0})"), "state_period_ms");
  EXPECT_EQ(place(R"({"cycle_ms":0})"), "cycle_ms");
  EXPECT_FALSE(onboard_options_from_json("[]"));
  EXPECT_FALSE(onboard_options_from_json("{"));
}

TEST(Onboard, has_a_port_for_each_board) {
  EXPECT_THAT(OnboardBench{}.core->ports(), ElementsAre("1/PILS", "1/PRAV", "1/DOBS", "1/RALI"));
}

TEST(Onboard, does_the_same_twice) {
  const auto digest = [] {
    OnboardBench bench;
    bench.run(0.5);
    bench.order(to_1131());
    bench.run(3.0);
    Digest folded;
    bench.core->fold(folded);
    for (const auto& publish : bench.published) folded.add(std::string_view{publish.payload});
    return folded.value();
  };
  EXPECT_EQ(digest(), digest());
}

}  // namespace
}  // namespace cosiva::aiv
