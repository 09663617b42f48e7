#include "cosiva/aiv/localisation/distance_counter.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

namespace cosiva::aiv {
namespace {

TEST(DistanceCounter, starts_at_the_first_reading) {
  DistanceCounter counter{0.5};
  EXPECT_EQ(counter.reading_um(), std::nullopt);
  EXPECT_EQ(counter.count(123'456'789), 0.0);
  EXPECT_NEAR(counter.count(123'466'789), 0.01, 1e-12);
  EXPECT_NEAR(counter.count(123'456'789), -0.01, 1e-12);
  EXPECT_NEAR(counter.travelled_m(), 0.0, 1e-12);
  EXPECT_EQ(counter.reading_um(), 123'456'789);
}

TEST(DistanceCounter, does_not_count_a_step_that_is_impossible) {
  DistanceCounter counter{0.5};
  counter.count(700'000);
  EXPECT_EQ(counter.count(0), 0.0) << "the board counts from zero again";
  EXPECT_NEAR(counter.count(10'000), 0.01, 1e-12);
  EXPECT_EQ(counter.count(std::numeric_limits<std::int64_t>::min()), 0.0);
  EXPECT_EQ(counter.count(std::numeric_limits<std::int64_t>::max()), -1e-6) << "one step round the counter";
}

TEST(DistanceCounter, takes_the_reading_after_a_restart_as_a_new_origin) {
  DistanceCounter counter{0.5};
  counter.count(0);
  counter.count(100'000);
  counter.restart();
  EXPECT_EQ(counter.reading_um(), std::nullopt);
  EXPECT_EQ(counter.count(200'000), 0.0);
  EXPECT_NEAR(counter.travelled_m(), 0.1, 1e-12);
}

TEST(DistanceCounter, continues_from_another_counter_of_the_same_board) {
  DistanceCounter before{0.5};
  before.count(0);
  before.count(100'000);
  DistanceCounter after{0.5};
  after.take_over(before);
  EXPECT_NEAR(after.count(150'000), 0.05, 1e-12);
  EXPECT_NEAR(after.travelled_m(), 0.15, 1e-12);
}

}  // namespace
}  // namespace cosiva::aiv
