#include "cosiva/virtual/server/reports/vehicle_reports.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Ten vehicles that send ten states a second, of which one can send a hundred times as many, and a server on a machine
/// where each message takes time: the others wait meanwhile.
class BusyServer {
 public:
  explicit BusyServer(double per_s_max) {
    ServerOptions options;
    options.vehicle_messages_per_s_max = per_s_max;
    server_ = std::make_unique<ServerCore>(options);
  }

  /// The 99th percentile of the greatest ages, just before the next report, of what the server knows of the other nine
  /// [ms].
  double age_p99_ms(SimDuration duration, std::size_t states_per_period) {
    ages_ms_.clear();
    for (const SimTime end = now_ + duration; now_ < end; now_ += 100ms) {
      for (std::size_t i = 0; i < states_per_period; ++i) receive(0);
      for (std::size_t vehicle = 1; vehicle < vehicles; ++vehicle) receive(vehicle);
    }
    std::ranges::sort(ages_ms_);
    return ages_ms_[ages_ms_.size() * 99 / 100];
  }
  [[nodiscard]] std::string summary() const { return server_->summary_json(); }
  [[nodiscard]] std::size_t log_lines() const { return log_lines_; }
  [[nodiscard]] std::string snapshot() const { return server_->snapshot_json(); }

 private:
  static constexpr std::size_t vehicles = 10;
  // Measured on the reference machine: 25 us for a state; a tenth of its speed shows the effect in few messages.
  static constexpr SimDuration evaluating{300us};
  static constexpr SimDuration dropping{3us};

  void receive(std::size_t vehicle) {
    const SimTime at = std::max(now_, free_at_);
    wire::State state;
    state.header = {header_id_[vehicle]++, now_, "2.1.0", "Acme", "A" + std::to_string(vehicle)};
    state.position = wire::AgvPosition{{static_cast<double>(vehicle), 0.0, 0.0}, "oval", true, {}, {}};
    effects_.clear();
    server_->handle({at, wire::InputKind::message, "uagv/v2/Acme/" + state.header.serial_number + "/state",
                     vda::encode(state), false},
                    effects_);
    const std::size_t evaluated_now = evaluated();
    const bool was_evaluated = evaluated_now > std::exchange(evaluated_, evaluated_now);
    free_at_ = at + (was_evaluated ? evaluating : dropping);
    if (vehicle > 0 && reported_at_[vehicle]) ages_ms_.push_back(to_seconds(free_at_ - *reported_at_[vehicle]) * 1e3);
    if (was_evaluated) reported_at_[vehicle] = now_;
    for (const wire::Effect& effect : effects_)
      if (std::holds_alternative<wire::Log>(effect)) ++log_lines_;
  }
  /// Each evaluated state is traced.
  [[nodiscard]] std::size_t evaluated() const {
    constexpr std::string_view field = R"("traces":)";
    const std::string summary = server_->summary_json();
    return std::stoul(summary.substr(summary.rfind(field) + field.size()));
  }

  std::unique_ptr<ServerCore> server_;
  SimTime now_{virtual_epoch};
  SimTime free_at_{virtual_epoch};
  std::array<std::optional<SimTime>, vehicles> reported_at_{};
  std::array<std::uint32_t, vehicles> header_id_{};
  std::vector<double> ages_ms_;
  std::size_t evaluated_{0};
  std::size_t log_lines_{0};
  wire::Effects effects_;
};

TEST(VehicleReports, of_a_vehicle_that_floods_raise_the_age_of_no_other_by_more_than_a_fifth) {
  BusyServer limited{500.0};
  limited.age_p99_ms(20s, 1);
  const double usual_ms = limited.age_p99_ms(20s, 1);
  const std::size_t lines = limited.log_lines();
  EXPECT_LE(limited.age_p99_ms(30s, 100), 1.2 * usual_ms);
  EXPECT_EQ(limited.log_lines(), lines + 1) << "once per flood";
  // 30 000 states, of which the limit of 100 per second accepts 3 000, and its burst 200.
  EXPECT_THAT(limited.summary(), HasSubstr(R"("dropped":26)"));
  EXPECT_THAT(limited.snapshot(), HasSubstr("flood: more than 100 messages per second; the excess is dropped"));

  BusyServer unlimited{0.0};
  unlimited.age_p99_ms(20s, 1);
  EXPECT_GT(unlimited.age_p99_ms(30s, 100), 1.2 * usual_ms) << "otherwise this test shows nothing";
}

TEST(VehicleReports, show_a_vehicle_without_a_known_position_as_an_orphan) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.position_known = false;
  fixture.run_for(2s);
  const JsonValue metrics = fixture.bijection();
  EXPECT_EQ(*metrics.number("physical"), 1.0);
  EXPECT_EQ(*metrics.number("virtual"), 0.0);
  ASSERT_THAT(*metrics.find("orphans")->array(), SizeIs(1));
  EXPECT_EQ((*metrics.find("orphans")->array())[0].text("id"), "CoSiVA/AIV1");
  EXPECT_EQ((*metrics.find("orphans")->array())[0].text("side"), "physical");
  EXPECT_EQ(*metrics.number("matched_ratio"), 0.0);
}

TEST(VehicleReports, treat_a_vehicle_that_reports_after_a_stale_last_will_as_online) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  fixture.connection(aiv, wire::ConnectionState::connection_broken);
  fixture.run_for(3s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("connection"), "ONLINE");
}

TEST(VehicleReports, do_not_move_a_twin_back_for_a_late_report) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  const auto late = vda::encode(aiv.visualization(fixture.now - 200ms));
  const auto late_state = vda::encode(aiv.state(fixture.now - 1500ms));
  fixture.run_for(2s);
  const JsonValue before = fixture.aiv("CoSiVA/AIV1");
  fixture.send(aiv, "visualization", late);
  fixture.send(aiv, "state", late_state);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("x"), *before.number("x"));
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("orderUpdateId"), *before.number("orderUpdateId"));
  EXPECT_THAT(fixture.server->summary_json(), HasSubstr("\"outdated\":2"));
}

TEST(VehicleReports, ignore_a_retained_state) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.send(aiv, "state", vda::encode(aiv.state(fixture.now)), true);
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty());
  EXPECT_TRUE(fixture.logged("retained state"));
}

TEST(VehicleReports, ignore_a_message_with_another_vehicle_s_name_and_log_that_once) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  wire::State forged = aiv.state(fixture.now);
  forged.header.serial_number = "AIV2";
  for (int i = 0; i < 5; ++i) fixture.send(aiv, "state", vda::encode(forged));
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty());
  EXPECT_EQ(std::ranges::count_if(fixture.logs, [](const auto& l) { return l.find("AIV2") != std::string::npos; }), 1);
}

TEST(VehicleReports, count_lost_messages_and_let_header_ids_wrap) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  std::uint32_t id = 0xFFFFFFFEU;
  for (const std::uint32_t step : {0U, 1U, 1U, 3U}) {  // …fe, …ff, 0, 3: two lost
    id += step;
    wire::State state = aiv.state(fixture.now);
    state.header.header_id = id;
    fixture.now += 20ms;
    state.header.timestamp = fixture.now;
    fixture.send(aiv, "state", vda::encode(state));
  }
  EXPECT_THAT(fixture.server->summary_json(), HasSubstr("\"missed\":2"));
}

TEST(VehicleReports, extrapolate_from_the_arrival_when_a_vehicle_s_clock_is_wrong) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.clock_ahead = -100s;
  fixture.run_for(10s);
  EXPECT_TRUE(fixture.logged("clock"));
  const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
  EXPECT_LT(*shown.number("age_ms"), 150.0);
  const Pose2 ground_truth = aiv.pose();
  EXPECT_LT(distance({*shown.number("x"), *shown.number("y")}, position(ground_truth)), 0.03);
  EXPECT_THAT(
      (*shown.find("errors")->array()).back().text() != nullptr ? *(*shown.find("errors")->array()).back().text() : "",
      HasSubstr("clock"));
}

TEST(VehicleReports, tolerate_malformed_messages_on_every_topic_and_serve_valid_ones) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(2s);
  const std::vector<std::string> garbage{"",
                                         "{",
                                         "null",
                                         "[]",
                                         "\xFF\xFE",
                                         R"({"headerId":-1})",
                                         R"({"agvPosition":{"x":1e999,"y":0}})",
                                         std::string(300'000, '['),
                                         R"({"manufacturer":1,"serialNumber":[]})"};
  for (const std::string& payload : garbage)
    for (const char* topic : {"state", "visualization", "connection", "factsheet"}) {
      fixture.send(aiv, topic, payload);
      fixture.feed(wire::InputKind::message, std::string("uagv/v2/Acme/x1/") + topic, payload);
    }
  for (const char* topic : {"", "/", "uagv", "uagv/v2//x/state", "uagv/v3/Acme/new/state", "uagv/v2/Ac me/x/state",
                            "uagv/v2/Acme/x/order", "uagv/v2/Acme/x/y/state", "cosiva/v1/zone/", "other/v2/a/b/state"})
    fixture.feed(wire::InputKind::message, topic, "{}");
  fixture.run_for(2s);
  EXPECT_GT(aiv.speed_mps, 0.0);
  EXPECT_EQ(*fixture.bijection().number("matched"), 1.0);
  EXPECT_TRUE(fixture.logged("v3"));
}

TEST(VehicleReports, refuse_impossible_positions_and_versions) {
  ServerFixture fixture;
  FixtureVehicle& far = fixture.add("AIV1", {0, 0.5});
  wire::State state = far.state(fixture.now);
  state.position->pose.x_m = 1e6;
  fixture.send(far, "state", vda::encode(state));
  EXPECT_TRUE(fixture.logged("100 km"));
  FixtureVehicle& newer = fixture.add("AIV2", {0, 0.5});
  newer.version = "3.0.0";
  fixture.send(newer, "state", vda::encode(newer.state(fixture.now)));
  EXPECT_TRUE(fixture.logged("3.0.0"));
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty());
}

TEST(VehicleReports, accept_no_more_vehicles_than_the_limit) {
  ServerOptions options;
  options.vehicles_max = 256;
  ServerFixture fixture{oval(), options};
  for (int i = 0; i < 1000; ++i)
    fixture.feed(
        wire::InputKind::message, "uagv/v2/Flood/n" + std::to_string(i) + "/connection",
        R"({"headerId":0,"timestamp":"2023-07-11T00:00:00.000Z","version":"2.1.0","manufacturer":"Flood","serialNumber":"n)" +
            std::to_string(i) + R"(","connectionState":"ONLINE"})");
  EXPECT_EQ(fixture.snapshot().find("registry")->number("vehicles"), 256.0);
}

TEST(VehicleReports, show_events_of_the_physical_side_with_their_latency) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  aiv.information = {{"lastTag", "", {{"tag", "12"}, {"distance_m", "0.25"}}}};
  aiv.charge = 88.9;
  aiv.blocked = true;
  aiv.state_due = true;
  fixture.run_for(1s);
  const JsonValue metrics = fixture.bijection();
  const JsonValue& kinds = *metrics.find("events")->find("by_kind");
  EXPECT_EQ(*kinds.number("tag"), 1.0);
  EXPECT_EQ(*kinds.number("obstacle"), 1.0);
  EXPECT_EQ(*kinds.number("stop"), 1.0);
  EXPECT_EQ(*kinds.number("battery"), 1.0);
  EXPECT_NEAR(*metrics.find("events")->find("latency_ms")->number("p50"), 4.0, 0.5);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("lastTag"), 12.0);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("sinceTag_m"), 0.25);
}

/// A vehicle on the oval whose states the test writes itself.
class Reports : public testing::Test {
 protected:
  Reports() {
    vehicle.alive = false;
    send(next_state());
  }
  /// The state that follows: the next header id, and the present time.
  [[nodiscard]] wire::State next_state() {
    wire::State state = vehicle.state(fixture.now);
    state.header.timestamp = fixture.now;
    return state;
  }
  void send(const wire::State& state) { fixture.send(vehicle, "state", vda::encode(state)); }
  [[nodiscard]] JsonValue shown() const { return fixture.aiv("CoSiVA/AIV1"); }
  [[nodiscard]] double counted(const std::string& field) const {
    const JsonValue summary = *JsonValue::parse(fixture.server->summary_json());
    return *(*summary.find("aivs")->array())[0].number(field);
  }
  [[nodiscard]] std::string last_state_trace() const {
    const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(1, 1000));
    std::string content;
    for (const JsonValue& trace : *traces.find("traces")->array())
      if (trace.text("kind") == "state") content = *trace.text("content");
    return content;
  }
  ServerFixture fixture;
  FixtureVehicle& vehicle{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(Reports, that_are_older_than_the_last_one_are_counted_as_outdated_up_to_five_seconds) {
  fixture.now += 10s;
  send(next_state());
  wire::State late = next_state();
  late.header.timestamp = fixture.now - 4999ms;
  late.last_node_id = "late";
  send(late);
  EXPECT_EQ(counted("outdated"), 1.0);
  EXPECT_NE(shown().text("lastNode"), "late");
  wire::State after_setting_the_clock = next_state();
  after_setting_the_clock.header.timestamp = fixture.now - 5s;
  after_setting_the_clock.last_node_id = "earlier";
  send(after_setting_the_clock);
  EXPECT_EQ(counted("outdated"), 1.0);
  EXPECT_EQ(shown().text("lastNode"), "earlier") << "the vehicle's clock was set back";
}

TEST_F(Reports, of_one_instant_count_once) {
  wire::State state = next_state();
  state.last_node_id = "first";
  send(state);
  state.last_node_id = "second";
  send(state);
  EXPECT_EQ(shown().text("lastNode"), "first") << "the same header id";
  EXPECT_EQ(counted("outdated"), 1.0);
  ++state.header.header_id;
  send(state);
  EXPECT_EQ(shown().text("lastNode"), "second") << "another state of the same instant";
}

TEST_F(Reports, of_a_position_beyond_a_hundred_kilometres_are_refused) {
  const auto report_x = [&](double x_m, double y_m) {
    fixture.now += 100ms;
    wire::State state = next_state();
    state.position->pose = {x_m, y_m, 0.0};
    send(state);
    return *shown().find("reported")->number("x");
  };
  const double before_m = *shown().find("reported")->number("x");
  EXPECT_EQ(report_x(100'001.0, 0.0), before_m);
  EXPECT_EQ(report_x(0.0, -100'001.0), before_m);
  EXPECT_EQ(counted("refused"), 2.0);
  EXPECT_TRUE(fixture.logged("CoSiVA/AIV1: reports a position more than 100 km away; ignored"));
  EXPECT_EQ(report_x(100'000.0, -100'000.0), 100'000.0);
  EXPECT_EQ(counted("refused"), 2.0);
}

TEST_F(Reports, name_the_last_tag_and_the_distance_since_then) {
  const auto report = [&](const std::string& type, const std::string& tag, const std::string& distance) {
    fixture.now += 100ms;
    wire::State state = next_state();
    state.information = {{type, "", {{"tag", tag}, {"distance_m", distance}}}};
    send(state);
  };
  EXPECT_TRUE(shown().find("lastTag")->is_null());
  report("lastTag", "12", "0.25");
  EXPECT_EQ(shown().number("lastTag"), 12.0);
  EXPECT_EQ(shown().number("sinceTag_m"), 0.25);
  report("lastTag", "13", "far");
  EXPECT_EQ(shown().number("lastTag"), 13.0);
  EXPECT_EQ(shown().number("sinceTag_m"), 0.0);
  report("lastTag", "14x", "1.0");
  report("lastTag", "", "1.0");
  report("otherTag", "15", "1.0");
  EXPECT_EQ(shown().number("lastTag"), 13.0);
}

TEST_F(Reports, are_traced_with_a_summary) {
  wire::State state = next_state();
  state.order_id = "O-7";
  state.order_update_id = 3;
  state.last_node_id = "dock";
  state.last_node_sequence_id = 4;
  fixture.now += 100ms;
  state.header = next_state().header;
  send(state);
  EXPECT_EQ(last_state_trace(), "order 'O-7' update 3, node dock (4), stopped");
  fixture.now += 100ms;
  state.header = next_state().header;
  state.driving = true;
  state.paused = true;
  state.field_violation = true;
  state.errors = {{"orderError", wire::ErrorLevel::warning, "", {}}, {"motorError", wire::ErrorLevel::fatal, "", {}}};
  send(state);
  EXPECT_EQ(last_state_trace(),
            "order 'O-7' update 3, node dock (4), driving, paused, field violation, orderError, motorError");
}

/// Which of the two revisions of the page a change of the state changes.
class PageRevision : public Reports {
 protected:
  struct Changed {
    bool waited_for;
    bool events;
  };
  Changed after(const std::function<void(wire::State&)>& change) {
    fixture.now += 20ms;
    const wire::State base = next_state();
    send(base);
    const ServerCore::PageRevision before = fixture.server->page_revision();
    fixture.now += 20ms;
    wire::State state = next_state();
    change(state);
    send(state);
    const ServerCore::PageRevision now = fixture.server->page_revision();
    return {now.waited_for != before.waited_for, now.events != before.events};
  }
  void expect(const char* what, const Changed& expected, const std::function<void(wire::State&)>& change) {
    const Changed changed = after(change);
    EXPECT_EQ(changed.waited_for, expected.waited_for) << what;
    EXPECT_EQ(changed.events, expected.events) << what;
  }
};

TEST_F(PageRevision, changes_with_what_the_operator_waits_for_and_with_the_vehicle_s_events) {
  expect("nothing", {false, false}, [](wire::State&) {});
  expect("field violation", {true, false}, [](wire::State& state) { state.field_violation = true; });
  expect("pause", {true, false}, [](wire::State& state) { state.paused = true; });
  expect("error", {true, false}, [](wire::State& state) { state.errors.push_back({"e", {}, "", {}}); });
  expect("driving", {false, true}, [](wire::State& state) { state.driving = true; });
  expect("node", {false, true}, [](wire::State& state) { state.last_node_id = "other"; });
  expect("sequence", {false, true}, [](wire::State& state) { state.last_node_sequence_id = 8; });
  expect("battery", {false, false}, [](wire::State& state) { state.battery.charge_percent = 12.5; });
}

TEST_F(PageRevision, changes_with_commands_connections_and_objects) {
  ServerCore::PageRevision before = fixture.server->page_revision();
  const auto has_changed = [&] {
    const ServerCore::PageRevision now = fixture.server->page_revision();
    const bool changed = now.waited_for != before.waited_for;
    EXPECT_EQ(now.events, before.events);
    before = now;
    return changed;
  };
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  EXPECT_TRUE(has_changed());
  fixture.connection(vehicle, wire::ConnectionState::connection_broken);
  EXPECT_TRUE(has_changed());
  fixture.send_command(R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":1,"y":0.5}})");
  EXPECT_TRUE(has_changed());
  fixture.send_command(R"({"command":"edit","edit":{"priorities":{"CoSiVA/AIV1":5}}})");
  EXPECT_TRUE(has_changed());
  EXPECT_FALSE(has_changed());
}

TEST_F(Reports, snapshot_lists_the_last_fifty_commands) {
  for (int i = 1; i <= 50; ++i) fixture.command("stop", "CoSiVA/AIV9", "x" + std::to_string(i));
  const auto ids = [&] {
    std::vector<std::string> found;
    const JsonValue snapshot = fixture.snapshot();
    for (const JsonValue& command : *snapshot.find("commands")->array()) found.push_back(*command.text("id"));
    return found;
  };
  ASSERT_EQ(ids().size(), 50U);
  EXPECT_EQ(ids().front(), "x1");
  fixture.command("stop", "CoSiVA/AIV9", "x51");
  ASSERT_EQ(ids().size(), 50U);
  EXPECT_EQ(ids().front(), "x2");
  EXPECT_EQ(ids().back(), "x51");
}

TEST(VehicleReports, refuse_each_part_of_a_name_that_the_standard_does_not_permit) {
  ServerFixture fixture;
  for (const std::string vehicle : {"Ac me/x", "Acme/x y"}) {
    const std::string topic = "uagv/v2/" + vehicle + "/connection";
    fixture.feed(wire::InputKind::message, topic, "{}");
    EXPECT_TRUE(fixture.logged("ignored '" + topic + "': it has a name with characters that VDA 5050 does not permit"));
  }
  fixture.feed(wire::InputKind::message, "uagv/v3/Acme/x/state", "{}");
  EXPECT_TRUE(fixture.logged("ignored 'uagv/v3/Acme/x/state': it uses 'v3'; this server uses v2"));
  const JsonValue summary = *JsonValue::parse(fixture.server->summary_json());
  EXPECT_EQ(summary.number("messages_refused"), 3.0);
  EXPECT_THAT(*summary.find("aivs")->array(), IsEmpty());
}

TEST_F(Reports, that_are_retained_are_counted_as_refused_but_for_connection_and_factsheet) {
  fixture.send(vehicle, "connection", vda::encode(vehicle.connection(fixture.now, wire::ConnectionState::offline)),
               true);
  EXPECT_EQ(shown().text("connection"), "OFFLINE");
  wire::Factsheet factsheet;
  factsheet.header = vehicle.header(fixture.now, 0);
  factsheet.series_name = "T1";
  fixture.send(vehicle, "factsheet", vda::encode(factsheet), true);
  EXPECT_EQ(counted("refused"), 0.0);
  const double messages = counted("messages");
  fixture.send(vehicle, "visualization", vda::encode(vehicle.visualization(fixture.now)), true);
  EXPECT_EQ(counted("refused"), 1.0);
  fixture.send(vehicle, "state", "");
  EXPECT_EQ(counted("refused"), 1.0) << "a message that clears a topic";
  EXPECT_EQ(counted("messages"), messages + 2.0);
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 1000));
  EXPECT_EQ(traces.find("traces")->array()->back().text("kind"), "factsheet");
  EXPECT_EQ(traces.find("traces")->array()->back().text("content"), "T1, 0 actions");
}

TEST_F(Reports, of_state_and_visualization_of_one_instant_are_one_position) {
  fixture.now += 100ms;
  send(next_state());
  fixture.send(vehicle, "visualization", vda::encode(vehicle.visualization(fixture.now)));
  EXPECT_EQ(counted("outdated"), 0.0);
  fixture.send(vehicle, "visualization", vda::encode(vehicle.visualization(fixture.now - 1s)));
  EXPECT_EQ(counted("outdated"), 1.0);
  EXPECT_EQ(shown().number("age_ms"), 0.0);
}

TEST_F(Reports, of_an_implausible_position_are_refused_once_for_each_instant) {
  fixture.now += 100ms;
  wire::State state = next_state();
  state.position->pose.x_m = 1e6;
  send(state);
  wire::Visualization same = vehicle.visualization(fixture.now);
  same.position->pose.x_m = 1e6;
  fixture.send(vehicle, "visualization", vda::encode(same));
  EXPECT_EQ(counted("refused"), 1.0);
}

TEST_F(Reports, without_a_time_count_from_their_arrival) {
  for (const double x_m : {0.6, 0.7}) {
    fixture.now += 100ms;
    wire::Visualization report = vehicle.visualization(fixture.now);
    report.header.timestamp = SimTime{};
    report.position->pose = {x_m, 0.0, 0.0};
    fixture.send(vehicle, "visualization", vda::encode(report));
    EXPECT_EQ(shown().find("reported")->number("x"), x_m);
  }
  EXPECT_EQ(counted("outdated"), 0.0);
}

TEST_F(Reports, of_a_new_session_may_begin_with_earlier_times_and_header_ids) {
  fixture.now += 10s;
  for (int i = 0; i < 3; ++i) {
    fixture.now += 100ms;
    send(next_state());
  }
  fixture.connection(vehicle, wire::ConnectionState::offline);
  fixture.connection(vehicle, wire::ConnectionState::online);
  wire::State first = next_state();
  first.header.header_id = 0;
  first.header.timestamp = fixture.now - 1s;
  first.last_node_id = "first";
  send(first);
  EXPECT_EQ(shown().text("lastNode"), "first");
  EXPECT_EQ(counted("outdated"), 0.0);
  EXPECT_EQ(counted("missed"), 0.0);
}

TEST_F(Reports, of_a_vehicle_after_its_last_will_make_it_connected_after_two_seconds) {
  fixture.connection(vehicle, wire::ConnectionState::connection_broken);
  fixture.now += 2s;
  send(next_state());
  EXPECT_EQ(shown().text("connection"), "CONNECTIONBROKEN");
  EXPECT_FALSE(fixture.logged("continues to report"));
  fixture.now += 1ms;
  send(next_state());
  EXPECT_EQ(shown().text("connection"), "ONLINE");
  EXPECT_TRUE(fixture.logged("CoSiVA/AIV1: continues to report; treated as connected"));
}

TEST_F(Reports, of_the_position_are_traced_with_the_speed) {
  const auto traced_after = [&](const wire::Visualization& report) {
    fixture.send(vehicle, "visualization", vda::encode(report));
    const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 1000));
    const JsonValue& trace = traces.find("traces")->array()->back();
    return *trace.text("kind") + " " + *trace.text("content");
  };
  fixture.now += 100ms;
  wire::Visualization report = vehicle.visualization(fixture.now);
  report.position->pose = {0.5, 0.0, 0.25};
  report.velocity = wire::Velocity{0.3, 0.0, 0.0};
  EXPECT_EQ(traced_after(report), R"(visualization {"x":0.5,"y":0,"theta":0.25,"speed":0.3})");
  report.velocity.reset();
  EXPECT_EQ(traced_after(report), R"(visualization {"x":0.5,"y":0,"theta":0.25,"speed":0})");
  fixture.command("stop", "CoSiVA/AIV9");
  report.position.reset();
  EXPECT_THAT(traced_after(report), testing::StartsWith("command ")) << "nothing to show";
}

TEST_F(Reports, of_states_alone_show_the_effect_of_a_command) {
  fixture.command("slow", "CoSiVA/AIV1", "c1");
  const auto sent = fixture.published_on("uagv/v2/CoSiVA/AIV1/instantActions");
  ASSERT_THAT(sent, SizeIs(1));
  const std::string id = vda::decode_instant_actions(sent[0].payload)->actions[0].action_id;
  EXPECT_TRUE(fixture.command_entry("c1").find("accepted_ms")->is_null());
  EXPECT_TRUE(fixture.command_entry("c1").find("materialised_ms")->is_null());
  fixture.now += 50ms;
  wire::State state = next_state();
  state.action_states = {{id, "setSpeedLimit", wire::ActionStatus::running, ""}};
  send(state);
  EXPECT_EQ(fixture.command_entry("c1").text("state"), "accepted");
  EXPECT_EQ(fixture.command_entry("c1").number("accepted_ms"), 50.0);
  fixture.now += 70ms;
  state = next_state();
  state.action_states = {{id, "setSpeedLimit", wire::ActionStatus::finished, "slow"}};
  send(state);
  const JsonValue command = fixture.command_entry("c1");
  EXPECT_EQ(command.text("state"), "materialised");
  EXPECT_EQ(command.text("vehicle"), "CoSiVA/AIV1");
  EXPECT_EQ(command.text("command"), "slow");
  EXPECT_EQ(command.text("reason"), "");
  EXPECT_EQ(command.number("accepted_ms"), 50.0);
  EXPECT_EQ(command.number("materialised_ms"), 120.0);
  EXPECT_EQ(command.number("time_ms"), to_milliseconds_scaled(fixture.now - 120ms));
}

TEST_F(Reports, of_a_vehicle_without_a_position_make_it_present_more_than_a_second_after_the_first_one) {
  FixtureVehicle& orphan = fixture.add("AIV2", {2, 0.5});
  orphan.alive = false;
  orphan.position_known = false;
  const auto present_after = [&](SimDuration time) {
    fixture.now += time;
    fixture.send(orphan, "state", vda::encode(orphan.state(fixture.now)));
    return *fixture.bijection().number("physical") == 2.0;
  };
  EXPECT_FALSE(present_after(0ms));
  EXPECT_FALSE(present_after(1000ms));
  EXPECT_TRUE(present_after(1ms));
}

TEST_F(Reports, that_are_missing_change_the_revision_of_the_page_when_the_vehicle_is_lost) {
  for (int i = 0; i < 40; ++i) {
    fixture.now += 100ms;
    send(next_state());
  }
  fixture.feed(wire::InputKind::tick, "", "");
  const ServerCore::PageRevision before = fixture.server->page_revision();
  EXPECT_EQ(shown().flag("lost"), false);
  fixture.now += 2s;
  fixture.feed(wire::InputKind::tick, "", "");
  EXPECT_EQ(shown().flag("lost"), true);
  EXPECT_NE(fixture.server->page_revision().waited_for, before.waited_for);
  EXPECT_EQ(fixture.server->page_revision().events, before.events);
}

}  // namespace
}  // namespace cosiva::virtual_side
