#include "cosiva/experiments/faults/persons.h"

#include <gtest/gtest.h>

#include <memory>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

/// Two vehicles that have driven for 10 s.
class PersonsInWorld : public testing::Test {
 protected:
  PersonsInWorld() {
    WorldOptions options;
    options.zone = zone::testing::configuration_file("lacet4.toml");
    options.aivs = 2;
    world = *World::make(std::move(options));
    world->run_for(10s);
    persons = std::make_unique<Persons>(*world);
  }
  static constexpr std::uint64_t draw = 1;
  /// No person steps in where the path has been bent for some time.
  [[nodiscard]] bool drive_until_a_person_can_step_in() const {
    for (int i = 0; i < 200 && !persons->point_in_path(1, draw); ++i) world->run_for(100ms);
    return persons->point_in_path(1, draw).has_value();
  }
  [[nodiscard]] double distance_m() const { return world->plant().vehicles().front().distance_m; }

  std::unique_ptr<World> world;
  std::unique_ptr<Persons> persons;
};

TEST_F(PersonsInWorld, are_avoided_by_a_vehicle_that_drives_on_when_they_leave) {
  ASSERT_TRUE(drive_until_a_person_can_step_in());
  const double before_m = distance_m();
  persons->step_in(1, draw, world->now() + 5s);
  world->run_for(5s);
  EXPECT_LT(distance_m(), before_m + 1.2) << "a person is at most 1.2 m from the vehicle that it stops";
  EXPECT_EQ(world->plant().vehicles().front().speed_mps, 0.0);
  EXPECT_FALSE(persons->check());
  persons->leave(world->now());
  world->run_for(10s);
  EXPECT_GT(distance_m(), before_m + 1.2);
  EXPECT_FALSE(persons->check());
}

TEST_F(PersonsInWorld, touched_by_a_vehicle_are_found_once) {
  const Pose2 X_MB = world->plant().vehicles().front().X_MB;
  EXPECT_EQ(persons->touching(position(X_MB)), "AIV1");
  EXPECT_EQ(persons->touching(X_MB * Point2{0.5, 0.0}), "");
  const Point2 aside = X_MB * Point2{0.0, 0.3};
  EXPECT_EQ(persons->touching(aside), "");
  world->command_plant(R"({"addObstacle":{"id":"p","x":)" + std::to_string((X_MB * Point2{0.2, 0.0}).x_m) + R"(,"y":)" +
                       std::to_string((X_MB * Point2{0.2, 0.0}).y_m) + R"(,"radius":0.06}})");
  world->run_for(2s);
  const Finding found = persons->check();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->invariant, "safety");
  EXPECT_FALSE(persons->check());
}

}  // namespace
}  // namespace cosiva::experiments
