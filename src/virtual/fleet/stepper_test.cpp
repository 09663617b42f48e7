// The steps of a fleet: several steps at once give the same result, and no step allocates memory.
#include <gmock/gmock.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <new>

#include "cosiva/virtual/fleet/test_fleet.h"
#include "cosiva/zone/routing/route.h"

namespace {

/// Number of calls of `new` in this program.
std::atomic<std::size_t> allocations{0};

void* counted(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  const std::size_t whole = (size / alignment + 1) * alignment;
  if (void* const memory = std::aligned_alloc(alignment, whole)) return memory;
  std::abort();
}

}  // namespace

// All variants, so that memory is never freed by another variant's counterpart.
void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new(std::size_t size, std::align_val_t to) { return counted(size, static_cast<std::size_t>(to)); }
void* operator new[](std::size_t size, std::align_val_t to) { return counted(size, static_cast<std::size_t>(to)); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace cosiva::virtual_side {
namespace {

using namespace test;

std::vector<FleetStart> copies_of(const zone::TrafficZone& zone, std::uint32_t copies, std::size_t in_each) {
  std::vector<FleetStart> starts;
  const std::vector<FleetStart> one = Fleet::spread(zone, in_each);
  for (std::uint32_t copy = 0; copy < copies; ++copy)
    for (std::size_t k = copy % 3; k < one.size(); ++k) starts.push_back({copy, one[k].position, 0});
  return starts;
}

std::size_t allocations_of(Fleet& fleet, int steps) {
  const std::size_t before = allocations.load();
  EXPECT_NE(std::vector<int>(1).data(), nullptr);
  EXPECT_GT(allocations.load(), before) << "allocations are not counted";
  const std::size_t counted_before = allocations.load();
  for (int k = 0; k < steps; ++k) fleet.step();
  return allocations.load() - counted_before;
}

TEST(FleetStep, allocates_no_memory) {
  for (const char* name : {"zones/lacet4.toml", "zones/indus8.toml", "zones/crossing8.xodr"}) {
    Fleet many = fleet(zone_file(name), 8);
    EXPECT_EQ(allocations_of(many, 2000), 0U) << name;
  }
  Fleet wide = fleet(plant({.rows = 2, .aisles = 4, .bays = 3, .seed = 1}), 25);
  EXPECT_EQ(allocations_of(wide, 2000), 0U);
  const Zone clover = zone_file("bench/clover.toml");
  Fleet copies = fleet(clover, copies_of(*clover, 200, 12));
  EXPECT_EQ(allocations_of(copies, 300), 0U);
}

TEST(FleetStep, allocates_no_memory_when_goals_are_reached) {
  const Zone zone = zone_file("zones/indus8.toml");
  Fleet many = fleet(zone, 10);
  const zone::Router router{*zone};
  std::size_t sent = 0;
  for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
    const zone::TrackPosition goal{
        static_cast<zone::SectionId>((many.track_position(i).section + 3) % zone->circuit.size()), 0.2};
    const auto route = router.plan(many.track_position(i), goal);
    if (route && many.send(i, route->sections, goal.s_m)) ++sent;
  }
  EXPECT_GT(sent, 3U);
  EXPECT_EQ(allocations_of(many, 1000), 0U);
  std::size_t arrived = 0;
  for (Fleet::Vehicle i = 0; i < many.size(); ++i) arrived += many.is_at_goal(i) ? 1U : 0U;
  EXPECT_GT(arrived, 0U);
}

TEST(FleetStep, gives_the_same_result_for_several_steps_at_once) {
  const Zone zone = zone_file("bench/clover.toml");
  const std::vector<FleetStart> starts = copies_of(*zone, 150, 12);
  Fleet single = fleet(zone, starts);
  Fleet strides = fleet(zone, starts);
  AloneWorker alone;
  for (const std::uint32_t steps : {1U, 7U, 100U, 250U, 2U}) {
    for (std::uint32_t k = 0; k < steps; ++k) single.step();
    strides.step(alone, steps);
    ASSERT_EQ(strides.steps(), single.steps());
    ASSERT_EQ(strides.digest(), single.digest());
  }
  for (zone::SectionId id = 0; id < zone->circuit.size(); ++id) EXPECT_EQ(strides.occupancy(id), single.occupancy(id));
}

TEST(FleetStep, reports_every_arrival_of_several_steps_at_once) {
  const Zone zone = zone_file("zones/indus8.toml");
  std::vector<FleetStart> starts = Fleet::spread(*zone, 6, 0);
  for (const FleetStart& start : Fleet::spread(*zone, 6, 1)) starts.push_back(start);
  const auto send_all = [&](Fleet& some) {
    for (Fleet::Vehicle i = 0; i < some.size(); ++i) {
      // The higher the number, the earlier the arrival.
      const zone::TrackPosition here = some.track_position(i);
      const zone::SectionId next = zone->circuit.next(here.section).front();
      EXPECT_TRUE(some.send(i, std::vector{here.section, next}, 0.5 - 0.04 * i));
    }
  };
  Fleet single = fleet(zone, starts);
  send_all(single);
  std::vector<Fleet::Vehicle> one_by_one;
  for (int k = 0; k < 400; ++k) {
    single.step();
    one_by_one.insert(one_by_one.end(), single.arrived().begin(), single.arrived().end());
  }
  Fleet stride = fleet(zone, starts);
  send_all(stride);
  AloneWorker alone;
  stride.step(alone, 400);
  const std::vector<Fleet::Vehicle> at_once{stride.arrived().begin(), stride.arrived().end()};
  EXPECT_FALSE(std::ranges::is_sorted(one_by_one)) << "nothing to be sorted";
  EXPECT_TRUE(std::ranges::is_sorted(at_once));
  EXPECT_GT(at_once.size(), 1U);
  EXPECT_THAT(at_once, testing::UnorderedElementsAreArray(one_by_one));
  stride.step(alone, 5);
  EXPECT_TRUE(stride.arrived().empty());
}

// The envelope's rule (aiv/motion/formulas.h): this distance is left free, at standstill and while driving.
TEST(FleetStep, leaves_the_clearance_free_behind_each_vehicle_on_the_same_loop) {
  for (const char* name : {"zones/lacet4.toml", "zones/indus8.toml", "bench/clover.toml"}) {
    for (const bool rules : {false, true}) {
      Fleet full = fleet(zone_file(name), 1000, rules);
      for (int k = 0; k < 3000; ++k) full.step();
      EXPECT_GE(full.smallest_gap_m(), aiv::clearance_m - 1e-9) << name;
    }
  }
}

/// The longest standstill of the first vehicle without a break, among others of the highest priority.
SimDuration longest_wait(SimDuration overtaken_at_most) {
  const Zone zone = zone_file("bench/clover.toml");
  std::vector<FleetStart> starts = Fleet::spread(*zone, 14);
  for (std::size_t i = 1; i < starts.size(); ++i) starts[i].priority = 999;
  auto made = Fleet::make(zone, {.overtaken_at_most = overtaken_at_most}, starts);
  EXPECT_TRUE(made);
  SimDuration longest{};
  SimDuration waited{};
  std::uint64_t since = 0;
  for (int k = 0; k < 6000; ++k) {
    made->step();
    if (made->waiting(0) == waited) since = made->steps();
    waited = made->waiting(0);
    longest = std::max(longest,
                       SimDuration{std::chrono::milliseconds{100}} * static_cast<std::int64_t>(made->steps() - since));
  }
  return longest;
}

TEST(FleetStep, lets_no_vehicle_overtake_one_that_has_waited_long_enough_at_a_crossing) {
  const SimDuration patient = longest_wait(std::chrono::hours{1});
  const SimDuration aged = longest_wait(std::chrono::seconds{5});
  EXPECT_LT(aged, patient);
  // Vehicles that came before it and those in the crossing still go first: four branches, some seconds each.
  EXPECT_LT(aged, std::chrono::seconds{25});
}

TEST(FleetStep, grants_in_order_of_arrival_for_equal_priorities) {
  // Each crossing of one branch is granted in the order of the requests that can use it: no vehicle waits while others
  // circulate.
  Fleet many = fleet(zone_file("bench/clover.toml"), 12);
  for (int k = 0; k < 6000; ++k) many.step();
  double least = 1e9;
  double most = 0.0;
  for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
    least = std::min(least, many.distance_m(i));
    most = std::max(most, many.distance_m(i));
  }
  EXPECT_GT(least, 0.8 * most);
}

}  // namespace
}  // namespace cosiva::virtual_side
