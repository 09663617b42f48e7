#include "cosiva/zone/circuit/pose_table.h"

#include <gtest/gtest.h>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

/// Poses at random positions of a circuit, all at once and one by one.
void expect_same(const Circuit& circuit) {
  const PoseTable table{circuit};
  Random random{1, "pose_table"};
  constexpr std::size_t count = 1001;
  std::vector<SectionId> sections(count);
  std::vector<double> s_m(count);
  std::vector<double> x_m(count);
  std::vector<double> y_m(count);
  std::vector<double> heading_rad(count);
  for (std::size_t i = 0; i < count; ++i) {
    sections[i] = static_cast<SectionId>(random.below(circuit.size()));
    s_m[i] = random.uniform(0.0, circuit.section(sections[i]).length_m());
    if (i % 50 == 0) s_m[i] = i % 100 == 0 ? 0.0 : circuit.section(sections[i]).length_m();
  }
  table.poses(sections, s_m, x_m, y_m, heading_rad);
  for (std::size_t i = 0; i < count; ++i) {
    const Pose2 pose = circuit.pose_at({sections[i], s_m[i]});
    ASSERT_NEAR(x_m[i], pose.x_m, 1e-11) << i;
    ASSERT_NEAR(y_m[i], pose.y_m, 1e-11) << i;
    ASSERT_NEAR(wrap_angle(heading_rad[i] - pose.heading_rad), 0.0, 1e-12) << i;
    ASSERT_GT(heading_rad[i], -pi);
    ASSERT_LE(heading_rad[i], pi);
  }
}

TEST(PoseTable, gives_the_poses_of_sections) {
  expect_same(testing::lacet4().circuit);
  expect_same(testing::zone_file("indus8.toml").circuit);
}

TEST(PoseTable, evaluates_clothoids_one_by_one) { expect_same(testing::zone_file("crossing8.xodr").circuit); }

}  // namespace
}  // namespace cosiva::zone
