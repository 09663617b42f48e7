#include "cosiva/virtual/server/deadlocks/deadlocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/zone/check/deadlock.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

struct Shown {
  double cycles;
  double detected;
  double resolved;
  double open;
  JsonValue::Array list;
};

Shown shown(const ServerFixture& fixture) {
  const JsonValue snapshot = fixture.snapshot();
  const JsonValue& deadlocks = *snapshot.find("deadlocks");
  return {*deadlocks.number("cycles"), *deadlocks.number("detected"), *deadlocks.number("resolved"),
          *deadlocks.number("open"), *deadlocks.find("list")->array()};
}

std::vector<std::string> members(const JsonValue& deadlock) {
  std::vector<std::string> names;
  for (const JsonValue& name : *deadlock.find("members")->array()) names.push_back(*name.text());
  return names;
}

std::size_t backed_up(const ServerFixture& fixture, const FixtureVehicle& vehicle) {
  std::size_t count = 0;
  for (const wire::Publish& message : fixture.published_on(vehicle.topic("instantActions")))
    count += message.payload.find("\"backUp\"") == std::string::npos ? 0U : 1U;
  return count;
}

/// Four vehicles on the clover, each in the first crossing of its straight, which is the second crossing of another
/// straight.
class FourArms : public testing::Test {
 protected:
  FourArms() : FourArms{std::string(wire::our_manufacturer)} {}
  /// @param maker  manufacturer of the last two
  explicit FourArms(const std::string& maker) {
    for (const zone::SectionId straight : {0U, 2U, 4U, 6U})
      fixture.add("AIV" + std::to_string(straight / 2 + 1), {straight, 0.6}, straight < 4 ? "CoSiVA" : maker);
  }
  /// Runs until the snapshot states for all four vehicles what they wait for.
  void run_until_closed() {
    for (int i = 0; i < 200; ++i) {
      fixture.run_for(20ms);
      const JsonValue snapshot = fixture.snapshot();
      const auto& aivs = *snapshot.find("aivs")->array();
      if (std::ranges::all_of(aivs, [](const JsonValue& aiv) { return aiv.text("waitsFor").has_value(); }) &&
          aivs.size() == 4)
        return;
    }
    FAIL() << "they do not wait for each other";
  }

  ServerFixture fixture{zone_file("lacet4.toml")};
};

TEST_F(FourArms, is_detected_in_the_tick_in_which_it_closes_and_names_all_four) {
  run_until_closed();
  const Shown now = shown(fixture);
  EXPECT_EQ(now.cycles, 1.0);
  EXPECT_EQ(now.detected, 0.0) << "it may dissolve by itself";
  ASSERT_THAT(now.list, SizeIs(1));
  EXPECT_EQ(now.list[0].text("state"), "forming");
  EXPECT_THAT(members(now.list[0]), ElementsAre("CoSiVA/AIV1", "CoSiVA/AIV2", "CoSiVA/AIV3", "CoSiVA/AIV4"));
  const std::string reason = *now.list[0].text("reason");
  EXPECT_THAT(reason, AllOf(HasSubstr("CoSiVA/AIV1 waits for X"), HasSubstr("CoSiVA/AIV2 waits for X"),
                            HasSubstr("CoSiVA/AIV3 waits for X"), HasSubstr("CoSiVA/AIV4 waits for X")));
}

TEST_F(FourArms, is_resolved_and_all_vehicles_continue) {
  int touches = 0;
  fixture.each_step = [&] { touches += fixture.touches(); };
  fixture.run_for(60s);
  EXPECT_EQ(touches, 0);
  const Shown now = shown(fixture);
  EXPECT_EQ(now.detected, 1.0);
  EXPECT_EQ(now.resolved, 1.0);
  EXPECT_EQ(now.open, 0.0);
  ASSERT_THAT(now.list, SizeIs(1));
  EXPECT_EQ(now.list[0].text("state"), "resolved");
  EXPECT_THAT(*now.list[0].text("how"), HasSubstr("AIV4 backs up "));
  EXPECT_TRUE(now.list[0].number("ended_ms").has_value());
  for (const auto& vehicle : fixture.vehicles) {
    EXPECT_GT(vehicle->driven_m, 5.0) << vehicle->id.serial_number;
    EXPECT_THAT(vehicle->refusals, IsEmpty());
  }
  EXPECT_TRUE(fixture.logged("deadlock 1: CoSiVA/AIV1 waits for"));
  EXPECT_TRUE(fixture.logged("deadlock 1 is resolved"));
}

TEST_F(FourArms, lets_the_vehicle_with_the_lowest_priority_yield) {
  fixture.send_command(R"({"command":"edit","edit":{"priorities":{"CoSiVA/AIV1":5,"CoSiVA/AIV3":5,"CoSiVA/AIV4":5}}})");
  fixture.run_for(20s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").number("priority"), 5.0);
  ASSERT_THAT(shown(fixture).list, SizeIs(1));
  EXPECT_THAT(*shown(fixture).list[0].text("how"), HasSubstr("AIV2 backs up "));
}

TEST_F(FourArms, is_resolved_by_the_next_vehicle_when_one_fails) {
  fixture.vehicles[3]->refuses.insert("backUp");
  fixture.run_for(60s);
  EXPECT_GT(backed_up(fixture, *fixture.vehicles[3]), 0U);
  EXPECT_EQ(shown(fixture).resolved, 1.0);
  EXPECT_THAT(*shown(fixture).list[0].text("how"), HasSubstr("AIV3 backs up "));
  for (const auto& vehicle : fixture.vehicles) EXPECT_GT(vehicle->driven_m, 5.0) << vehicle->id.serial_number;
}

TEST_F(FourArms, that_no_vehicle_can_resolve_is_logged_as_an_error_and_retried) {
  for (const auto& vehicle : fixture.vehicles) vehicle->refuses.insert("backUp");
  fixture.run_for(90s);
  ASSERT_THAT(shown(fixture).list, SizeIs(1));
  EXPECT_EQ(shown(fixture).open, 1.0);
  EXPECT_TRUE(fixture.logged("deadlock 1 is unresolved"));
  // The vehicles accept the action from now on.
  for (const auto& vehicle : fixture.vehicles) vehicle->refuses.clear();
  fixture.run_for(90s);
  EXPECT_EQ(shown(fixture).resolved, 1.0);
  for (const auto& vehicle : fixture.vehicles) EXPECT_GT(vehicle->driven_m, 5.0) << vehicle->id.serial_number;
}

TEST_F(FourArms, that_dissolves_by_itself_is_no_deadlock) {
  run_until_closed();
  fixture.run_for(1s);
  // One of the vehicles is carried away.
  fixture.vehicles[2]->motion = {fixture.zone->circuit, {5, 0.5}};
  fixture.vehicles[2]->state_due = true;
  fixture.run_for(30s);
  const Shown now = shown(fixture);
  EXPECT_GE(now.cycles, 1.0);
  EXPECT_EQ(now.detected, 0.0);
  EXPECT_THAT(now.list, IsEmpty());
  for (const auto& vehicle : fixture.vehicles) EXPECT_EQ(backed_up(fixture, *vehicle), 0U);
}

/// The last two are third-party vehicles, which cannot back up.
class FourArmsWithThirdParty : public FourArms {
 protected:
  FourArmsWithThirdParty() : FourArms{"Acme"} {}
};

TEST_F(FourArmsWithThirdParty, is_resolved_by_a_cosiva_vehicle) {
  fixture.run_for(60s);
  EXPECT_EQ(shown(fixture).resolved, 1.0);
  EXPECT_THAT(*shown(fixture).list[0].text("how"), HasSubstr("CoSiVA/AIV2 backs up "));
  EXPECT_EQ(backed_up(fixture, *fixture.vehicles[2]) + backed_up(fixture, *fixture.vehicles[3]), 0U);
  for (const auto& vehicle : fixture.vehicles) EXPECT_GT(vehicle->driven_m, 5.0) << vehicle->id.serial_number;
}

// The vehicle does not hold the crossing, but its front end obstructs the vehicle that does: either well inside the
// crossing, or so little beyond its stop line that only beams of 8 degrees detect it as in the path.
class Overshot : public ::testing::TestWithParam<double> {};

TEST_P(Overshot, vehicle_goes_first_when_the_vehicle_that_it_obstructs_releases_the_crossing) {
  ServerFixture fixture{zone_file("lacet4.toml")};
  double stop_m = 0.0;
  for (const zone::Waypoint& waypoint : fixture.zone->waypoints)
    if (waypoint.position.section == 0 && waypoint.position.s_m < 0.5) stop_m = waypoint.position.s_m;
  FixtureVehicle& nose = fixture.add("AIV1", {0, stop_m + GetParam()});
  nose.paused = true;
  // In the crossing that is the first one of the other straight and the second one of its own.
  FixtureVehicle& other = fixture.add("AIV2", {6, 0.2});
  int touches = 0;
  fixture.each_step = [&] {
    touches += fixture.touches();
    // Emulates its obstacle sensor; the sensor of the other vehicle faces in another direction.
    const bool near = std::fabs(other.track_position().s_m - 0.9) < 0.32 && other.track_position().section == 6 &&
                      nose.track_position().section == 0 && nose.track_position().s_m < 1.0;
    if (near != other.blocked) other.state_due = true;
    other.blocked = near;
    if (near && nose.paused) {
      nose.paused = false;
      nose.state_due = true;
    }
  };
  fixture.run_for(40s);
  EXPECT_EQ(touches, 0);
  ASSERT_THAT(shown(fixture).list, SizeIs(1));
  const JsonValue deadlock = shown(fixture).list[0];
  EXPECT_THAT(*deadlock.text("reason"),
              AllOf(HasSubstr("CoSiVA/AIV1 waits for X"), HasSubstr("which CoSiVA/AIV2 holds"),
                    HasSubstr("CoSiVA/AIV2 detects CoSiVA/AIV1 in its path")));
  EXPECT_EQ(deadlock.text("how"), "CoSiVA/AIV2 releases what it holds ahead and lets the others go first");
  EXPECT_EQ(deadlock.text("state"), "resolved");
  EXPECT_GT(nose.driven_m, 3.0);
  EXPECT_GT(other.driven_m, 3.0);
}

INSTANTIATE_TEST_SUITE_P(Metres, Overshot, ::testing::Values(0.035, 0.005));

TEST(UnresponsiveVehicle, that_is_stopped_with_base_ahead_is_given_a_new_order) {
  ServerFixture fixture;
  FixtureVehicle& is_cosiva = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& foreign = fixture.add("AGV1", {2, 0.5}, "Acme");
  fixture.run_for(5s);
  for (FixtureVehicle* vehicle : {&is_cosiva, &foreign}) vehicle->hangs_on = vehicle->book->ids().order_id;
  const double before_m = is_cosiva.driven_m;
  fixture.run_for(10s);
  EXPECT_EQ(is_cosiva.driven_m, before_m);
  fixture.run_for(10s);
  EXPECT_GT(is_cosiva.driven_m, before_m + 0.5);
  EXPECT_TRUE(fixture.logged("CoSiVA/AIV1: is stopped with base ahead and reports no reason"));
  EXPECT_FALSE(fixture.logged("Acme/AGV1: is stopped with base ahead"))
      << "a third-party vehicle may have other reasons";
}

/// Track positions of vehicles stopped one behind the other at waypoints, as many as there is room for.
std::vector<zone::TrackPosition> packed(const zone::TrafficZone& zone, const std::vector<zone::SectionId>& round) {
  std::vector<zone::TrackPosition> positions;
  double start_m = 0.0;
  double last_m = -1.0;
  double first_m = 0.0;
  double round_m = 0.0;
  for (const zone::SectionId id : round) round_m += zone.circuit.section(id).length_m();
  const double room_m = zone::stopping_room_m(zone.vehicle);
  for (const zone::SectionId id : round) {
    for (const zone::Waypoint& waypoint : zone.waypoints) {
      const double at_m = start_m + waypoint.position.s_m;
      if (waypoint.position.section != id || zone.crossing_at(waypoint.position) != nullptr) continue;
      if (!positions.empty() && (at_m - last_m < room_m || first_m + round_m - at_m < room_m)) continue;
      if (positions.empty()) first_m = at_m;
      positions.push_back(waypoint.position);
      last_m = at_m;
    }
    start_m += zone.circuit.section(id).length_m();
  }
  return positions;
}

TEST(CrowdedLoop, is_reported_as_unresolved_and_moves_with_one_vehicle_less) {
  const std::vector<zone::SectionId> round{0, 1, 2, 3};
  for (const bool full : {true, false}) {
    ServerFixture fixture;
    auto positions = packed(*fixture.zone, round);
    // The number that `cosiva zone check` reports, plus one.
    ASSERT_EQ(positions.size(), zone::vehicles_going_round(*fixture.zone, round) + 1);
    if (!full) positions.pop_back();
    for (std::size_t i = 0; i < positions.size(); ++i) fixture.add("AIV" + std::to_string(i + 1), positions[i]);
    fixture.run_for(60s);
    const Shown now = shown(fixture);
    EXPECT_EQ(now.open, full ? 1.0 : 0.0);
    if (full) {
      EXPECT_THAT(members(now.list[0]), SizeIs(positions.size()));
    }
    EXPECT_EQ(fixture.logged("deadlock 1 is unresolved"), full);
    for (const auto& vehicle : fixture.vehicles) EXPECT_EQ(vehicle->driven_m > 0.5, !full) << vehicle->id.serial_number;
  }
}

TEST(CrowdedLoop, opens_where_a_vehicle_can_take_another_route) {
  ServerFixture fixture{
      fork("[[loop]]\nname = \"round\"\nsections = [\"entry\", \"south\", \"east\", \"north\", \"west\"]\n")};
  const std::vector<zone::SectionId> round{0, 1, 2, 3, 4};
  const auto positions = packed(*fixture.zone, round);
  for (std::size_t i = 0; i < positions.size(); ++i) fixture.add("AIV" + std::to_string(i + 1), positions[i]);
  int touches = 0;
  fixture.each_step = [&] { touches += fixture.touches(); };
  fixture.run_for(90s);
  EXPECT_EQ(touches, 0);
  const Shown now = shown(fixture);
  EXPECT_GE(now.detected, 1.0);
  EXPECT_EQ(now.open, 0.0);
  EXPECT_TRUE(fixture.logged("takes another route"));
  for (const auto& vehicle : fixture.vehicles) EXPECT_GT(vehicle->driven_m, 0.5) << vehicle->id.serial_number;
}

/// The north-western loop of the clover is full: each vehicle in the loop is stopped at a waypoint, and the next
/// waypoint is too close to its leader. The vehicle that waits at the loop's end needs the crossing in which the
/// frontmost vehicle of the queue is stopped without room to leave: that vehicle's leader stopped before making enough
/// room.
TEST(FullLoop, that_ends_in_a_crossing_opens_when_the_vehicle_beyond_it_moves_up) {
  ServerFixture fixture{zone_file("lacet4.toml")};
  constexpr zone::SectionId west = 4;
  constexpr zone::SectionId loop = 5;
  constexpr zone::SectionId south = 6;
  const auto at = [&](const std::string& id) { return fixture.zone->find_waypoint(id)->position; };
  FixtureVehicle& in_crossing = fixture.add("AIV1", {west, 0.99});
  fixture.add("AIV2", at("west@1310"));
  int number = 3;
  for (const char* id : {"loop_nw@283", "loop_nw@848", "loop_nw@1414", "loop_nw@1979", "loop_nw@2262"})
    fixture.add("AIV" + std::to_string(number++), at(id));
  fixture.add("AIV8", {south, 0.0});
  FixtureVehicle& at_end = fixture.add("AIV9", at("south@380"));
  ASSERT_EQ(fixture.zone->circuit.next(loop).front(), south);
  int touches = 0;
  fixture.each_step = [&] { touches += fixture.touches(); };
  fixture.run_for(60s);
  EXPECT_EQ(touches, 0);
  ASSERT_GE(shown(fixture).list.size(), 1U);
  EXPECT_THAT(*shown(fixture).list[0].text("reason"), HasSubstr("CoSiVA/AIV9 waits for X4, which CoSiVA/AIV1 holds"));
  EXPECT_EQ(shown(fixture).list[0].text("how"),
            "CoSiVA/AIV2 moves up to its leader and lets its follower out of a crossing");
  EXPECT_EQ(shown(fixture).open, 0.0);
  EXPECT_GT(in_crossing.driven_m, 3.0);
  EXPECT_GT(at_end.driven_m, 3.0);
}

/// An on-path vehicle and an off-path vehicle so close to each other that neither can drive.
class SideBySide : public testing::Test {
 protected:
  void put(double ahead_m, double beside_m, double turned_rad) {
    fixture.add("AIV1", {0, 0.8});
    FixtureVehicle& neighbour = fixture.add("AIV2", {0, 0.8 + ahead_m});
    const Pose2 X_ML = fixture.zone->circuit.pose_at({0, 0.8 + ahead_m});
    neighbour.put(X_ML * Pose2{0.0, beside_m, turned_rad});
  }
  ServerFixture fixture;
};

TEST_F(SideBySide, is_resolved_by_the_on_path_vehicle_which_backs_up) {
  // Its rear end would sweep over the other vehicle's front end on its path to any position nearby.
  put(0.15, 0.17, 0.3);
  int touches = 0;
  fixture.each_step = [&] { touches += fixture.touches(); };
  fixture.run_for(60s);
  EXPECT_EQ(touches, 0);
  const Shown now = shown(fixture);
  EXPECT_EQ(now.open, 0.0);
  EXPECT_EQ(now.detected, now.resolved);
  for (const auto& vehicle : fixture.vehicles) EXPECT_GT(vehicle->driven_m, 3.0) << vehicle->id.serial_number;
}

TEST_F(SideBySide, a_few_millimetres_apart_is_resolved_by_backing_up) {
  put(0.15, 0.150, 0.3);
  fixture.run_for(60s);
  EXPECT_EQ(shown(fixture).open, 0.0);
  // A vehicle that stopped at once because of the close vehicle would not be commanded to back up again.
  EXPECT_EQ(backed_up(fixture, *fixture.vehicles[0]), 1U);
  for (const auto& vehicle : fixture.vehicles) EXPECT_GT(vehicle->driven_m, 3.0) << vehicle->id.serial_number;
}

// --- the exact times ------------------------------------------------------------------------------------------------

/// The four vehicles of FourArms without a server: none of them moves, and each tick is 100 ms.
struct FourStill {
  FourStill() {
    manager.set_map(&*orders.map);
    for (const zone::SectionId straight : {0U, 2U, 4U, 6U}) {
      const VehicleIndex v = orders.add_at("AIV" + std::to_string(straight / 2 + 1), {straight, 0.6});
      manager.resize(orders.server.registry.size());
      manager.set_reported_pose(v, orders.positions.reported(v));
    }
    tick();
  }
  void tick() {
    manager.tick(true, true, 1h);
    deadlocks.tick();
  }
  void run_for(SimDuration duration) {
    for (; duration > SimDuration::zero(); duration -= 100ms) {
      orders.pass(100ms);
      tick();
    }
  }
  [[nodiscard]] JsonValue json() const {
    JsonWriter text;
    deadlocks.write(text);
    return *JsonValue::parse(text.text());
  }
  [[nodiscard]] JsonValue::Array list() const { return *json().find("list")->array(); }
  [[nodiscard]] std::vector<std::string> lines_with(std::string_view phrase) const {
    std::vector<std::string> lines = orders.logs();
    std::erase_if(lines, [&](const std::string& line) { return line.find(phrase) == std::string::npos; });
    return lines;
  }
  [[nodiscard]] std::string digest() const {
    Digest digest;
    deadlocks.fold(digest);
    return digest.hex();
  }
  OrdersFixture orders{zone_file("lacet4.toml")};
  OrderManager manager{orders.server.registry, orders.traffic,  orders.server.publisher,
                       orders.actions,         orders.missions, orders.server.simulator};
  Deadlocks deadlocks{orders.server.registry, orders.server.publisher, orders.server.traces, manager};
};

TEST(CycleOfFour, is_a_deadlock_after_two_seconds) {
  FourStill four;
  EXPECT_EQ(four.deadlocks.counters().cycles, 1U);
  EXPECT_THAT(four.deadlocks.list(), IsEmpty());
  ASSERT_THAT(four.list(), SizeIs(1));
  EXPECT_EQ(four.list()[0].text("state"), "forming");
  EXPECT_EQ(four.list()[0].number("number"), 0.0);
  four.run_for(1900ms);
  EXPECT_EQ(four.deadlocks.counters().detected, 0U);
  four.run_for(100ms);
  EXPECT_EQ(four.deadlocks.counters().detected, 1U);
  EXPECT_EQ(four.deadlocks.counters().cycles, 1U);
  EXPECT_EQ(four.deadlocks.open(), 1U);
  EXPECT_EQ(four.deadlocks.unresolved(), 0U);
  ASSERT_THAT(four.deadlocks.list(), SizeIs(1));
  EXPECT_EQ(four.deadlocks.list()[0].state, Deadlock::State::yielding);
  EXPECT_THAT(four.deadlocks.list()[0].members, ElementsAre(0U, 1U, 2U, 3U));
  EXPECT_THAT(four.deadlocks.list()[0].how, HasSubstr(" backs up "));
  int yielding = 0;
  for (VehicleIndex v = 0; v < 4; ++v) yielding += four.manager.yields(v) ? 1 : 0;
  EXPECT_EQ(yielding, 1);
}

TEST(CycleOfFour, is_listed_with_its_members_and_counted) {
  FourStill four;
  four.run_for(2s);
  const JsonValue json = four.json();
  EXPECT_EQ(json.number("cycles"), 1.0);
  EXPECT_EQ(json.number("detected"), 1.0);
  EXPECT_EQ(json.number("resolved"), 0.0);
  EXPECT_EQ(json.number("open"), 1.0);
  EXPECT_EQ(json.number("unresolved"), 0.0);
  EXPECT_EQ(json.number("longest_s"), 0.0) << "it has not ended yet";
  EXPECT_EQ(json.number("longest_wait_s"), 2.0);
  ASSERT_THAT(four.list(), SizeIs(1));
  const JsonValue deadlock = four.list()[0];
  EXPECT_EQ(deadlock.number("number"), 1.0);
  EXPECT_EQ(deadlock.text("state"), "yielding");
  EXPECT_THAT(members(deadlock), ElementsAre("CoSiVA/AIV1", "CoSiVA/AIV2", "CoSiVA/AIV3", "CoSiVA/AIV4"));
  EXPECT_FALSE(deadlock.number("ended_ms").has_value());
  EXPECT_THAT(four.lines_with("deadlock 1: CoSiVA/AIV1 waits for X"), SizeIs(1));
}

TEST(CycleOfFour, that_opens_for_600_ms_counts_as_closed_throughout) {
  FourStill four;
  four.run_for(1s);
  four.orders.proxy(2).settings.on_cancel();
  four.run_for(500ms);
  four.orders.proxy(2).settings.on_mission();
  four.run_for(400ms);
  EXPECT_EQ(four.deadlocks.counters().detected, 0U);
  four.run_for(100ms);
  EXPECT_EQ(four.deadlocks.counters().detected, 1U);
  EXPECT_EQ(four.deadlocks.counters().cycles, 1U);
}

TEST(CycleOfFour, that_opens_for_longer_has_dissolved) {
  FourStill four;
  four.run_for(1s);
  four.orders.proxy(2).settings.on_cancel();
  four.run_for(600ms);
  EXPECT_THAT(four.list(), SizeIs(1));
  four.run_for(100ms);
  EXPECT_THAT(four.list(), IsEmpty());
  four.orders.proxy(2).settings.on_mission();
  four.run_for(2s);
  EXPECT_EQ(four.deadlocks.counters().cycles, 2U);
  EXPECT_EQ(four.deadlocks.counters().detected, 0U) << "two seconds after it has closed again";
  four.run_for(100ms);
  EXPECT_EQ(four.deadlocks.counters().detected, 1U);
}

TEST(CycleOfFour, ends_when_the_zone_is_switched) {
  FourStill four;
  four.run_for(2s);
  const std::string before = four.digest();
  const std::uint64_t revision = four.deadlocks.revision();
  const std::string how = four.deadlocks.list()[0].how;
  four.deadlocks.forget();
  ASSERT_THAT(four.deadlocks.list(), SizeIs(1));
  EXPECT_EQ(four.deadlocks.list()[0].state, Deadlock::State::resolved);
  EXPECT_EQ(four.deadlocks.list()[0].how, "the zone was switched");
  EXPECT_EQ(four.deadlocks.list()[0].ended_at, four.orders.now);
  EXPECT_EQ(four.deadlocks.counters().resolved, 1U);
  EXPECT_EQ(four.deadlocks.counters().longest, 2s);
  EXPECT_EQ(four.deadlocks.open(), 0U);
  EXPECT_NE(four.digest(), before);
  EXPECT_GT(four.deadlocks.revision(), revision);
  EXPECT_EQ(four.orders.logs().back(), "i deadlock 1 is resolved after 2 s: " + how);
  four.deadlocks.forget();
  EXPECT_EQ(four.deadlocks.counters().resolved, 1U) << "once";
}

TEST(CycleOfFour, that_no_vehicle_can_open_is_an_error_once) {
  FourStill four;
  for (VehicleIndex v = 0; v < 4; ++v) four.orders.proxy(v).factsheet.on_factsheet(wire::Factsheet{});
  four.run_for(2s);
  EXPECT_EQ(four.deadlocks.unresolved(), 1U);
  EXPECT_EQ(four.deadlocks.open(), 1U);
  const std::vector<std::string> errors = four.lines_with("is unresolved");
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_EQ(errors[0], "e deadlock 1 is unresolved: " + four.deadlocks.list()[0].reason +
                           "; none of its vehicles can yield; remove one of them, or close a section");
  four.run_for(11s);
  EXPECT_THAT(four.lines_with("is unresolved"), SizeIs(1));
  EXPECT_EQ(four.deadlocks.unresolved(), 1U);
}

TEST(CycleOfFour, that_no_vehicle_could_open_is_tried_again_after_five_seconds) {
  FourStill four;
  for (VehicleIndex v = 0; v < 4; ++v) four.orders.proxy(v).factsheet.on_factsheet(wire::Factsheet{});
  four.run_for(2s);
  wire::Factsheet factsheet;
  factsheet.actions = {{"backUp", "", true, false, false, {}}};
  for (VehicleIndex v = 0; v < 4; ++v) four.orders.proxy(v).factsheet.on_factsheet(factsheet);
  four.run_for(4900ms);
  EXPECT_EQ(four.deadlocks.unresolved(), 1U);
  four.run_for(100ms);
  EXPECT_EQ(four.deadlocks.unresolved(), 0U);
  EXPECT_EQ(four.deadlocks.list()[0].state, Deadlock::State::yielding);
}

TEST(CycleOfFour, is_opened_by_the_member_with_the_lowest_priority) {
  FourStill four;
  for (const VehicleIndex v : {0U, 2U, 3U}) four.orders.proxy(v).settings.set_priority(5);
  four.run_for(2s);
  EXPECT_TRUE(four.manager.yields(1));
  EXPECT_THAT(four.deadlocks.list()[0].how, testing::StartsWith("CoSiVA/AIV2 backs up "));
}

}  // namespace
}  // namespace cosiva::virtual_side
