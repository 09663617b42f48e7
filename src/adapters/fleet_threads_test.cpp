// The fleet's engine with real threads: the result must not depend on their number.
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <sstream>
#include <vector>

#include "cosiva/adapters/thread_pool.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/zone/generate/generate.h"
#include "cosiva/zone/generate/plant_size.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::adapters {
namespace {

using virtual_side::Fleet;
using virtual_side::FleetStart;

std::shared_ptr<const zone::TrafficZone> read(const std::string& text) {
  auto rtm = zone::Rtm::initialise({"toml", "test.toml", text});
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->shared_zone();
}

std::uint64_t digest_after(const std::shared_ptr<const zone::TrafficZone>& zone, const std::vector<FleetStart>& starts,
                           std::size_t threads, int steps) {
  auto fleet = Fleet::make(zone, {.rules = aiv::AgentRules::built_in()}, starts);
  EXPECT_TRUE(fleet) << to_string(fleet.error());
  ThreadPool pool{threads};
  for (int k = 0; k < steps; ++k) fleet->step(pool);
  EXPECT_EQ(fleet->collisions(), 0U);
  return fleet->digest();
}

void expect_same(const std::shared_ptr<const zone::TrafficZone>& zone, const std::vector<FleetStart>& starts,
                 int steps) {
  const std::uint64_t alone = digest_after(zone, starts, 1, steps);
  for (const std::size_t threads : {2U, 4U, 8U}) EXPECT_EQ(digest_after(zone, starts, threads, steps), alone);
}

TEST(FleetThreads, many_copies_of_a_zone_are_the_same_on_any_number_of_threads) {
  std::stringstream text;
  text << std::ifstream(source_dir() + "/zones/lacet4.toml").rdbuf();
  const auto zone = read(text.str());
  std::vector<FleetStart> starts;
  for (std::uint32_t copy = 0; copy < 700; ++copy)
    for (const FleetStart& start : Fleet::spread(*zone, 4 + copy % 4)) starts.push_back({copy, start.position, 0});
  expect_same(zone, starts, 200);
}

TEST(FleetThreads, one_large_zone_is_the_same_on_any_number_of_threads) {
  const auto text = zone::generate_plant(zone::plant_of_size(20'000));
  ASSERT_TRUE(text);
  const auto zone = read(*text);
  const std::vector<FleetStart> starts = Fleet::spread(*zone, 5'000);
  ASSERT_GT(starts.size(), 4'096U) << "so many that it is stepped in parts";
  expect_same(zone, starts, 40);
}

}  // namespace
}  // namespace cosiva::adapters
