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

TEST(PlantSize, is_limited_to_what_can_be_generated) {
  EXPECT_LE(plant_sections_max(plant_of_size(170'000)), 200'000U);
  EXPECT_DEATH(static_cast<void>(plant_of_size(170'001)), "sections <= 170'000");
}

}  // namespace
}  // namespace cosiva::zone
