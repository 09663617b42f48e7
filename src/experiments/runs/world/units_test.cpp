// Crossing units in virtual time: vehicles negotiate over a radio that reaches less far than their crossings demand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/experiments/runs/world/test_world.h"
#include "cosiva/wire/own/crossing_status.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using testing::total_m;

/// Vehicles that claim a crossing on two approaches are up to 1.4 m apart, and do not receive each other; a unit above
/// the centre reaches the whole zone.
constexpr RadioReach short_reach{.vehicles_m = 0.8, .units_m = 3.5};

struct Fleet {
  std::uint64_t seed{1};
  double radio_loss{0.0};
  std::uint32_t aivs{12};
  bool units{true};
  std::optional<RadioReach> reach{short_reach};
  std::uint32_t ignores_claims{0};  ///< the number of a vehicle that drives as its base permits; 0: none
  std::optional<bool> as_values{};
};

std::unique_ptr<World> world_of(const Fleet& fleet) {
  WorldOptions options;
  options.zone = testing::zone_named("lacet4");
  options.aivs = fleet.aivs;
  options.seed = fleet.seed;
  options.as_values = fleet.as_values.value_or(passes_values(fleet.seed));
  options.server.negotiated_crossings = true;
  options.radio.emplace();
  options.radio->loss = options.radio->duplication = options.radio->reordering = fleet.radio_loss;
  options.reach = fleet.reach;
  if (fleet.units)
    for (const char* crossing : {"X1", "X2", "X3", "X4"}) options.units.push_back({crossing});
  options.adapt_aiv = [ignores = fleet.ignores_claims](aiv::OnboardOptions& aiv) {
    if (aiv.number != ignores) aiv.autonomy = aiv::Autonomy::negotiate;
  };
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world.has_value()) << (world ? "" : to_string(world.error()));
  return std::move(*world);
}

double least_m(const World& world) {
  double least = 1e9;
  for (const auto& vehicle : world.plant().vehicles()) least = std::min(least, vehicle.distance_m);
  return least;
}

TEST(UnitsStatistics, of_12_vehicles_of_short_radio_reach_for_10_minutes_have_no_collision_and_all_drive) {
  for (const auto& [loss, duration] : {std::pair<double, SimDuration>{0.3, 600s}, {0.0, 120s}}) {
    const auto world = world_of({.seed = 1, .radio_loss = loss});
    world->run_for(duration);
    EXPECT_THAT(world->plant().collisions(), IsEmpty()) << "loss " << loss;
    std::printf("radio loss %.1f, %.0f s: %.1f m, the least of one vehicle %.1f m\n", loss, to_seconds(duration),
                total_m(*world), least_m(*world));
    EXPECT_GT(least_m(*world), 17.31) << "a lap of the clover";
  }
}

TEST(UnitsStatistics, without_units_vehicles_of_short_radio_reach_come_to_a_stop) {
  const auto world = world_of({.units = false});
  world->run_for(300s);
  std::printf("without units: %zu collisions, %.1f m, the least of one vehicle %.1f m\n",
              world->plant().collisions().size(), total_m(*world), least_m(*world));
  EXPECT_LT(least_m(*world), 17.31) << "otherwise the test above could not fail";
}

TEST(UnitsStatistics, reduce_the_collisions_of_a_vehicle_that_ignores_claims_and_cannot_prevent_all) {
  const auto collisions_of = [](bool units) {
    std::size_t collisions = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const auto world = world_of({.seed = seed, .units = units, .reach = {}, .ignores_claims = 1});
      world->run_for(200s);
      collisions += world->plant().collisions().size();
    }
    return collisions;
  };
  const std::size_t without = collisions_of(false);
  const std::size_t with = collisions_of(true);
  std::printf("collisions in 3 runs of 200 s: %zu without units, %zu with units\n", without, with);
  EXPECT_GT(without, 0U) << "otherwise the first test could not fail";
  EXPECT_LE(with, without);
}

/// The last status of each unit on the broker.
struct Statuses {
  explicit Statuses(World& world) {
    world.tap([this](SimTime at, const std::string&, const wire::Publish& message) {
      if (!message.topic.starts_with(wire::unit_topic_prefix)) return;
      const auto status = wire::crossing_status_from_json(message.payload);
      ASSERT_TRUE(status) << message.payload;
      last[status->crossing] = *status;
      at_of[status->crossing] = at;
    });
  }
  std::map<std::string, wire::CrossingStatus> last;
  std::map<std::string, SimTime> at_of;
};

JsonValue shown(const World& world, const std::string& crossing) {
  const JsonValue snapshot = testing::snapshot(world);
  for (const JsonValue& unit : *snapshot.find("units")->array())
    if (unit.text("crossing") == crossing) return unit;
  return {};
}

void set_radio(World& world, const std::string& of, double loss) {
  world.faults().publish_from_outside(
      {std::string(wire::plant_radio_topic), wire::to_json(wire::Radio{of, loss}), 1, false});
}

TEST(Units, report_to_the_server_who_is_in_their_crossings) {
  const auto world = world_of({.aivs = 4, .reach = {}});
  Statuses statuses{*world};
  std::size_t occupied = 0;
  for (int i = 0; i < 120; ++i) {
    world->run_for(500ms);
    for (const auto& [crossing, status] : statuses.last) occupied += status.holders.size();
  }
  EXPECT_EQ(statuses.last.size(), 4U);
  EXPECT_GT(occupied, 10U);
  EXPECT_EQ(testing::snapshot(*world).find("units")->array()->size(), 4U);
  EXPECT_EQ(shown(*world, "X3").text("state"), "online");
  EXPECT_THAT(world->plant().collisions(), IsEmpty());
}

TEST(Units, that_die_or_lose_their_radio_stop_no_vehicle_and_are_shown) {
  const auto world = world_of({.aivs = 6, .reach = {}});
  world->run_for(30s);
  world->faults().kill(first_unit);
  // Its program runs, but nothing passes its antenna.
  set_radio(*world, "CoSiVA.unit/X2", 1.0);
  world->run_for(3s);
  EXPECT_EQ(shown(*world, "X1").text("state"), "unresponsive");
  EXPECT_EQ(shown(*world, "X1").text("trouble").value_or("").substr(0, 13), "no status for");
  const double before_m = total_m(*world);
  world->run_for(60s);
  EXPECT_THAT(world->plant().collisions(), IsEmpty());
  EXPECT_GT(total_m(*world), before_m + 20.0);
  world->faults().start(first_unit);
  set_radio(*world, "CoSiVA.unit/X2", 0.0);
  world->run_for(3s);
  EXPECT_EQ(shown(*world, "X1").text("state"), "online");
}

TEST(Units, keep_a_crossing_occupied_for_a_vehicle_that_died_in_it_and_this_is_shown) {
  const auto world = world_of({.aivs = 4, .reach = {}});
  Statuses statuses{*world};
  std::string crossing;
  std::uint32_t number = 0;
  for (int i = 0; i < 1200 && number == 0; ++i) {
    world->run_for(100ms);
    for (const auto& [name, status] : statuses.last)
      if (status.holders.size() == 1 && number == 0) {
        crossing = name;
        number = static_cast<std::uint32_t>(status.holders[0].vehicle.serial_number.back() - '0');
      }
  }
  ASSERT_GT(number, 0U);
  const std::string serial = "AIV" + std::to_string(number);
  world->kill_aiv(number);
  world->run_for(15s);
  EXPECT_EQ(statuses.last[crossing].holders.at(0).vehicle.serial_number, serial);
  EXPECT_THAT(shown(*world, crossing).text("trouble").value_or(""), ::testing::HasSubstr("occupied for " + serial));
  EXPECT_THAT(world->plant().collisions(), IsEmpty());
  world->start_aiv(number);
  world->run_for(30s);
  EXPECT_FALSE(shown(*world, crossing).text("trouble"));
  EXPECT_THAT(world->plant().collisions(), IsEmpty());
}

TEST(Units, are_switched_off_and_on_by_the_steps_of_a_scenario) {
  const auto world = world_of({.aivs = 2, .reach = {}});
  Statuses statuses{*world};
  Scenario scenario;
  const auto step = [](SimDuration at, const std::string& on) {
    return Scenario::Step{at, R"({"command":"plant","plant":{"setUnit":{"crossing":"X1","on":)" + on + "}}}", "unit X1",
                          1};
  };
  scenario.steps = {step(5s, "false"), step(12s, "true")};
  world->play(scenario);
  while (!world->scenario_began()) world->run_for(1s);
  const SimTime began = *world->scenario_began();
  world->run_for(began + 10s - world->now());
  EXPECT_LT(statuses.at_of["X1"], began + 6s);
  EXPECT_EQ(shown(*world, "X1").text("state"), "unresponsive");
  EXPECT_EQ(shown(*world, "X2").text("state"), "online");
  world->run_for(4s);
  EXPECT_EQ(shown(*world, "X1").text("state"), "online");
}

TEST(Units, give_the_same_run_for_the_same_seed_with_texts_and_with_values) {
  const auto digest_of = [](std::optional<bool> as_values) {
    const auto world = world_of({.seed = 3, .radio_loss = 0.1, .aivs = 3, .as_values = as_values});
    world->run_for(20s);
    return std::pair{world->digest().hex(), world->estimates().hex()};
  };
  const auto first = digest_of({});
  EXPECT_EQ(digest_of({}), first);
  EXPECT_EQ(digest_of(false).second, first.second);
}

TEST(Units, belong_to_crossings_of_the_zone) {
  WorldOptions options;
  options.zone = testing::zone_named("lacet4");
  options.units.push_back({"X9"});
  const auto world = World::make(std::move(options));
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().code, "unit.crossing");
}

}  // namespace
}  // namespace cosiva::experiments
