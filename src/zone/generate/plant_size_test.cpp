#include "cosiva/zone/generate/plant_size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "cosiva/zone/generate/generate.h"

namespace cosiva::zone {
namespace {

std::size_t sections_in(const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find("[[section]]"); at != std::string::npos; at = text.find("[[section]]", at + 1))
    ++count;
  return count;
}

TEST(PlantSize, is_an_upper_bound_for_every_layout_and_a_close_one_without_gaps) {
  for (const std::uint32_t rows : {1U, 2U, 5U}) {
    for (const std::uint32_t aisles : {1U, 2U, 7U}) {
      for (const std::uint32_t bays : {0U, 1U, 2U, 9U}) {
        PlantOptions options;
        options.rows = rows;
        options.aisles = aisles;
        options.bays = bays;
        options.bay_ratio = 1.0;
        const std::size_t count = sections_in(*generate_plant(options));
        const std::size_t most = plant_sections_max(options);
        EXPECT_LE(count, most) << rows << ' ' << aisles << ' ' << bays;
        // A row with less than two bays has less than two chargers, seven sections each; the outermost rows have no
        // connections on one side.
        const std::size_t spare = 20 + 7 * (2 - std::min(bays, 2U));
        EXPECT_LE(most, count + rows * spare) << rows << ' ' << aisles << ' ' << bays;
        options.bay_ratio = 0.5;
        EXPECT_LE(sections_in(*generate_plant(options)), count);
      }
    }
  }
}

TEST(PlantSize, is_reached_by_a_layout_about_as_wide_as_high_and_by_no_smaller_one) {
  // In a smaller plant one more aisle or bay is more than a fifth of it.
  for (const std::size_t sections : {1'000U, 5'000U, 20'000U, 100'000U, 170'000U}) {
    const PlantOptions options = plant_of_size(sections);
    const double held = static_cast<double>(plant_sections_max(options)) * options.bay_ratio;
    EXPECT_GE(held, 1.02 * static_cast<double>(sections) - 1.0) << "two per cent for bays that are left out";
    EXPECT_LE(held, 1.2 * static_cast<double>(sections));
    // In vehicle lengths: nine from aisle to aisle, twelve from bay to bay and for the lanes.
    const double wide = 9.0 * options.aisles;
    const double high = options.rows * (12.0 * options.bays + 12.0);
    EXPECT_GT(wide, 0.65 * high) << sections;
    EXPECT_LT(wide, 1.5 * high) << sections;
    EXPECT_LE(options.bays, 3 * options.rows);
    EXPECT_GE(options.bays + 1, 3 * (options.rows - 1)) << sections;
    EXPECT_GE(options.bays, 2U);
    EXPECT_GE(options.aisles, 2U);
  }
}

// Without gaps a plant has rows · (aisles · (7 · bays + 7) + 42) sections, of which nine tenths are there, and two per
// cent more are wanted. A plant grows by an aisle where it is less wide than high, 9 aisles against 12 for each bay and
// 12 for the lanes of each row, else by a bay up to three for each row, else by a row.
TEST(PlantSize, grows_from_one_row_of_two_aisles_by_aisles_then_bays_then_rows) {
  const struct {
    std::size_t sections;
    std::uint32_t rows, aisles, bays;
  } all[] = {{0, 1, 2, 2},     // 75
             {74, 1, 2, 2},    // 74 and 1 are 75
             {75, 1, 3, 2},    // 18 < 36; 94
             {93, 1, 3, 2},    // 93 and 1
             {94, 1, 4, 2},    // 27 < 36; 113
             {111, 1, 4, 2},   // 111 and 2
             {112, 1, 4, 3},   // 36 = 36, two bays; 138
             {140, 1, 5, 3},   // 36 < 48; 163
             {162, 1, 6, 3},   // 45 < 48; 189
             {186, 1, 6, 3},   // 186 and 3
             {187, 2, 6, 3}};  // 54 > 48, three bays; 378
  for (const auto& [sections, rows, aisles, bays] : all) {
    const PlantOptions options = plant_of_size(sections);
    EXPECT_EQ(options.rows, rows) << sections;
    EXPECT_EQ(options.aisles, aisles) << sections;
    EXPECT_EQ(options.bays, bays) << sections;
  }
}

TEST(PlantSize, counts_seven_sections_a_bay_and_the_lanes_and_ends_of_each_row) {
  const auto most = [](std::uint32_t rows, std::uint32_t aisles, std::uint32_t bays) {
    PlantOptions options;
    options.rows = rows;
    options.aisles = aisles;
    options.bays = bays;
    return plant_sections_max(options);
  };
  EXPECT_EQ(most(1, 1, 0), 7U + 42U);
  EXPECT_EQ(most(1, 1, 1), 14U + 42U);
  EXPECT_EQ(most(1, 3, 2), 3U * 21U + 42U);
  EXPECT_EQ(most(5, 3, 2), 5U * (3U * 21U + 42U));
}

TEST(PlantSize, is_limited_to_what_can_be_generated) {
  EXPECT_LE(plant_sections_max(plant_of_size(170'000)), 200'000U);
  EXPECT_DEATH(static_cast<void>(plant_of_size(170'001)), "sections <= 170'000");
}

}  // namespace
}  // namespace cosiva::zone
