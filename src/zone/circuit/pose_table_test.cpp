#include "cosiva/zone/circuit/pose_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

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

TEST(PoseTable, gives_the_poses_of_arcs_too_flat_for_a_centre) {
  std::vector<Circuit::Part> parts;
  // Radii of 1 m to 1e9 m, to both sides, one of them beyond and one within the limit of 10 km.
  for (const double curvature_per_m : {1.0, -1.0, 1.01e-4, -1.01e-4, 0.99e-4, -0.99e-4, 1e-9, -1e-9, 0.0})
    parts.push_back(
        testing::part("s" + std::to_string(parts.size()), testing::section({3.0, -4.0, 2.5}, 3.0, curvature_per_m)));
  const Circuit circuit = testing::circuit(std::move(parts));
  expect_same(circuit);
  // A flat arc is evaluated like a single one, to the same bits.
  const PoseTable table{circuit};
  for (SectionId id = 4; id < circuit.size(); ++id) {
    const std::vector<SectionId> sections{id};
    const std::vector<double> s_m{2.25};
    std::vector<double> x_m(1);
    std::vector<double> y_m(1);
    std::vector<double> heading_rad(1);
    table.poses(sections, s_m, x_m, y_m, heading_rad);
    if (id < 8) {
      EXPECT_EQ((Pose2{x_m[0], y_m[0], heading_rad[0]}), circuit.pose_at({id, 2.25})) << id;
    }
  }
}

TEST(PoseTable, wraps_headings_at_both_ends_of_the_circle) {
  std::vector<Circuit::Part> parts;
  for (const double heading_rad : {pi, -pi + 1e-9, pi - 1e-9, 0.5 * pi})
    for (const double bend_per_m : {1.0, -1.0, 0.0})
      parts.push_back(testing::part("s" + std::to_string(parts.size()),
                                    testing::section({0.0, 0.0, heading_rad}, 9.0, bend_per_m)));
  expect_same(testing::circuit(std::move(parts)));
}

TEST(PoseTable, takes_eight_numbers_a_section) {
  const PoseTable table{testing::lacet4().circuit};
  EXPECT_GE(table.bytes(), 8U * 8U * sizeof(double));
  EXPECT_LT(table.bytes(), 2U * 8U * 8U * sizeof(double));
}

TEST(PoseTable, evaluates_clothoids_one_by_one) { expect_same(testing::zone_file("crossing8.xodr").circuit); }

TEST(PoseTable, of_lists_of_different_lengths_is_an_error_of_the_program) {
  const Circuit circuit = testing::track();
  const PoseTable table{circuit};
  const std::vector<SectionId> sections(3);
  for (std::size_t shorter = 0; shorter < 4; ++shorter) {
    std::vector<std::vector<double>> lists(4, std::vector<double>(3));
    lists[shorter].resize(2);
    EXPECT_DEATH(table.poses(sections, lists[0], lists[1], lists[2], lists[3]),
                 "s_m.size.. == count && x_m.size.. == count && y_m.size.. == count && heading_rad.size.. == count")
        << shorter;
  }
}

TEST(PoseTable, wraps_a_heading_of_exactly_minus_half_a_turn) {
  const Circuit circuit = testing::circuit({testing::part("a", testing::section({}, 9.0, -1.0))});
  const std::vector<SectionId> sections{0};
  const std::vector<double> s_m{pi};
  std::vector<double> x_m(1);
  std::vector<double> y_m(1);
  std::vector<double> heading_rad(1);
  PoseTable{circuit}.poses(sections, s_m, x_m, y_m, heading_rad);
  EXPECT_GT(heading_rad[0], -pi);
  EXPECT_LE(heading_rad[0], pi);
  EXPECT_NEAR(std::fabs(heading_rad[0]), pi, 1e-15);
  EXPECT_NEAR(y_m[0], -2.0, 1e-12);
}

TEST(PoseTable, wraps_headings_to_the_bits_of_a_single_pose) {
  const Circuit circuit = testing::circuit({testing::part("left", testing::section({0.0, 0.0, 2.5}, 40.0, 1.0)),
                                            testing::part("right", testing::section({0.0, 0.0, -2.5}, 40.0, -1.0))});
  const PoseTable table{circuit};
  std::vector<SectionId> sections;
  std::vector<double> s_m;
  for (int i = 1; i < 80; ++i) {
    sections.push_back(static_cast<SectionId>(i % 2));
    s_m.push_back(0.5 * i);  // never near half a turn
  }
  std::vector<double> x_m(s_m.size());
  std::vector<double> y_m(s_m.size());
  std::vector<double> heading_rad(s_m.size());
  table.poses(sections, s_m, x_m, y_m, heading_rad);
  for (std::size_t i = 0; i < s_m.size(); ++i)
    EXPECT_EQ(heading_rad[i], circuit.pose_at({sections[i], s_m[i]}).heading_rad) << s_m[i];
}

TEST(PoseTable, takes_no_more_bytes_than_a_row_and_a_bit_a_section) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 129; ++i)
    parts.push_back(testing::part("s" + std::to_string(i), testing::section({0.0, 1.0 * i, 0.0}, 1.0)));
  const Circuit circuit = testing::circuit(std::move(parts));
  // 129 bits are three words of 8 bytes.
  EXPECT_EQ(PoseTable{circuit}.bytes(), 129U * 8U * sizeof(double) + 3U * 8U);
}

}  // namespace
}  // namespace cosiva::zone
