// A vehicle that stays in crossings and is then sent along another branch, whose crossings are behind it.
#include <gtest/gtest.h>

#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/virtual/fleet/test_fleet.h"

namespace cosiva::virtual_side {
namespace {

using namespace test;

/// A lane that forks after a crossing, with another crossing close behind the fork on one branch. Both are reserved
/// together; along the other branch only the first one is. In a drawn zone the fork itself is a crossing too, on either
/// branch; a zone made by hand may lack that crossing, so that a vehicle has passed the first one before the fork.
///
///   in ─── neck(X1) ─┬─ on(X2) ───
///                    └─ off ── (X3) ──
class ForkedLane : public testing::Test {
 protected:
  static constexpr Fleet::Vehicle first = 0;
  static constexpr Fleet::Vehicle across_1 = 1;
  static constexpr Fleet::Vehicle across_2 = 2;

  ForkedLane()
      : zone_{made()},
        fleet_{fleet(zone_, std::vector<FleetStart>{
                                {0, {id("in"), 1.0}, 0}, {0, {id("side_1"), 1.0}, 0}, {0, {id("side_2"), 1.0}, 0}})} {}

  [[nodiscard]] zone::SectionId id(const char* name) const { return *zone_->circuit.find(name); }
  [[nodiscard]] bool send(Fleet::Vehicle i, std::vector<zone::SectionId> route, double goal_s_m) {
    return fleet_.send(i, route, goal_s_m);
  }
  [[nodiscard]] Fleet::Vehicle holder(std::size_t crossing) const { return fleet_.holder(0, crossing); }
  /// Steps until the vehicle is at its goal; gives up after a minute.
  [[nodiscard]] bool arrives(Fleet::Vehicle i) {
    for (int k = 0; k < 600 && !fleet_.is_at_goal(i); ++k) fleet_.step();
    return fleet_.is_at_goal(i);
  }
  /// The first vehicle is stopped at its goal before the fork, has passed the first crossing, and holds the second. The
  /// others stay at their positions.
  void drive_to_the_fork() {
    ASSERT_TRUE(send(across_1, {id("side_1")}, 1.0));
    ASSERT_TRUE(send(across_2, {id("side_2")}, 1.0));
    ASSERT_TRUE(send(first, {id("in"), id("neck"), id("on")}, 0.0));
    ASSERT_TRUE(arrives(first));
    ASSERT_EQ(fleet_.track_position(first), (zone::TrackPosition{id("neck"), 2.0}));
    ASSERT_EQ(holder(0), Fleet::none);
    ASSERT_EQ(holder(1), first);
  }

  Zone zone_;
  Fleet fleet_;

 private:
  static Zone made() {
    const auto straight = [](const std::string& name, double x, double y, double length_m, const std::string& next) {
      return "[[section]]\nname = \"" + name + "\"\nkind = \"straight\"\nlength_m = " + std::to_string(length_m) +
             "\nstart = { x = " + std::to_string(x) + ", y = " + std::to_string(y) + ", heading_deg = 0 }\nnext = [" +
             next + "]\n";
    };
    const Zone drawn =
        zone_text("name = \"forked\"\nformat_version = 1\n[vehicle]\nlength_m = 0.3\nwidth_m = 0.2\n" +
                  straight("in", 0.0, 0.0, 4.0, "\"neck\"") + straight("neck", 4.0, 0.0, 2.0, "\"on\", \"off\"") +
                  straight("on", 6.0, 0.0, 4.0, "") +
                  "[[section]]\nname = \"off\"\nkind = \"arc\"\nradius_m = 4.0\nangle_deg = 60.0\n"
                  "start = { x = 6.0, y = 0.0, heading_deg = 0 }\nnext = []\n" +
                  straight("side_1", 0.0, 20.0, 6.0, "") + straight("side_2", 0.0, 30.0, 6.0, ""));
    const auto id = [&](const char* name) { return *drawn->circuit.find(name); };
    auto zone = std::make_shared<zone::TrafficZone>(*drawn);
    zone->crossings = std::vector<zone::Crossing>{
        {"X1", {}, {{id("neck"), 1.5, 1.8}, {id("side_1"), 3.0, 3.6}}},
        {"X2", {}, {{id("on"), 0.1, 3.0}, {id("side_2"), 3.0, 3.6}}},
        {"X3", {}, {{id("off"), 0.5, 1.0}, {id("side_2"), 5.0, 5.2}}},
    };
    return zone;
  }
};

TEST_F(ForkedLane, on_a_branch_whose_crossings_are_behind_it_a_vehicle_holds_nothing_and_drives_on) {
  drive_to_the_fork();
  ASSERT_TRUE(send(across_2, {id("side_2")}, 3.3));
  EXPECT_FALSE(arrives(across_2)) << "the first one still holds the crossing";

  ASSERT_TRUE(send(first, {id("neck"), id("off")}, 3.5));
  for (std::size_t crossing = 0; crossing < 3; ++crossing) EXPECT_EQ(holder(crossing), Fleet::none) << crossing;
  EXPECT_TRUE(arrives(first)) << "it can request the next crossings";
  EXPECT_EQ(fleet_.track_position(first), (zone::TrackPosition{id("off"), 3.5}));
  EXPECT_TRUE(fleet_.is_at_goal(across_2)) << "returned crossings are free for others";
  EXPECT_EQ(holder(1), across_2) << "and are theirs, wherever the first one drives";
  EXPECT_EQ(fleet_.collisions(), 0U);
}

TEST_F(ForkedLane, a_vehicle_that_keeps_its_branch_keeps_its_crossings_there) {
  drive_to_the_fork();
  ASSERT_TRUE(send(first, {id("neck"), id("on")}, 3.5));
  EXPECT_EQ(holder(1), first);
  EXPECT_TRUE(arrives(first));
  EXPECT_EQ(holder(1), Fleet::none);
}

TEST_F(ForkedLane, on_another_branch_a_vehicle_does_not_wait_for_crossings_behind_it) {
  drive_to_the_fork();
  ASSERT_TRUE(send(across_1, {id("side_1")}, 3.3));
  ASSERT_TRUE(arrives(across_1));
  ASSERT_EQ(holder(0), across_1) << "a vehicle that stays in a crossing holds it";
  EXPECT_TRUE(send(first, {id("neck"), id("off")}, 3.5));
  EXPECT_EQ(holder(0), across_1);
  EXPECT_EQ(holder(1), Fleet::none);
  EXPECT_TRUE(arrives(first));
}

}  // namespace
}  // namespace cosiva::virtual_side
