#include "cosiva/zone/geometry/section_kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/zone/testing/test_shapes.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

ShapedKind kind(std::string name, std::vector<std::string> fields = {"amplitude_m", "wavelength_m"}) {
  return {std::move(name), std::move(fields),
          [](std::span<const double> values) -> Result<std::shared_ptr<const SectionShape>> {
            return test::sine_shape(values[0], values[1], 1.0);
          }};
}

TEST(SectionKinds, finds_what_was_added_and_lists_it_behind_the_built_in_ones) {
  SectionKinds kinds;
  EXPECT_EQ(kinds.find("sine"), nullptr);
  ASSERT_TRUE(kinds.add(kind("sine")));
  ASSERT_TRUE(kinds.add(kind("spline_2")));
  ASSERT_NE(kinds.find("sine"), nullptr);
  EXPECT_THAT(kinds.find("sine")->fields, ElementsAre("amplitude_m", "wavelength_m"));
  EXPECT_EQ((*kinds.find("sine")->make(std::vector{0.1, 2.0}))->kind(), "sine");
  EXPECT_THAT(kinds.names(), ElementsAre("straight", "arc", "clothoid", "sine", "spline_2"));
}

TEST(SectionKinds, refuses_a_name_that_is_taken_or_no_identifier) {
  SectionKinds kinds;
  ASSERT_TRUE(kinds.add(kind("sine")));
  for (const char* name : {"sine", "straight", "arc", "clothoid", "", "Sine", "2d", "sine wave", "sine\"", "é"}) {
    const auto added = kinds.add(kind(name));
    ASSERT_FALSE(added) << name;
    EXPECT_EQ(added.error().code, "section.kind");
  }
  EXPECT_FALSE(kinds.add(kind(std::string(65, 'a'))));
  EXPECT_TRUE(kinds.add(kind(std::string(64, 'a'))));
}

TEST(SectionKinds, refuses_a_field_that_every_section_has_or_that_occurs_twice) {
  SectionKinds kinds;
  for (const char* field :
       {"name", "kind", "start", "next", "from", "circuit", "pivots", "speed_mps_max", "Height", ""}) {
    const auto added = kinds.add(kind("sine", {"amplitude_m", field}));
    ASSERT_FALSE(added) << field;
    EXPECT_THAT(added.error().message, HasSubstr("the key of a field"));
  }
  EXPECT_FALSE(kinds.add(kind("sine", {"amplitude_m", "amplitude_m"})));
  EXPECT_TRUE(kinds.add(kind("sine", {"length_m"}))) << "its meaning is the kind's own";
}

}  // namespace
}  // namespace cosiva::zone
