#include "cosiva/zone/generate/plant_size.h"

#include "cosiva/base/expect.h"

namespace cosiva::zone {

std::size_t plant_sections_max(const PlantOptions& options) {
  const std::size_t aisle = 4 + 7 * std::size_t{options.bays} + 1;
  const std::size_t row = options.aisles * (aisle + 2) + 2 * (5 + 2 + 4) + 14 + 6;
  return options.rows * row;
}

PlantOptions plant_of_size(std::size_t sections) {
  COSIVA_EXPECT(sections <= 170'000);
  // A little more than requested, because the bays are drawn at random.
  const std::size_t wanted = sections + sections / 50;
  const auto held = [](const PlantOptions& options) {
    return static_cast<std::size_t>(static_cast<double>(plant_sections_max(options)) * options.bay_ratio);
  };
  PlantOptions options{};
  options.rows = 1;
  options.aisles = 2;
  options.bays = 2;
  while (held(options) < wanted) {
    // About as wide as high: an aisle is nine lengths from the next, a bay twelve from the next.
    const double wide = 9.0 * options.aisles;
    const double high = options.rows * (12.0 * options.bays + 12.0);
    if (wide < high)
      ++options.aisles;
    else if (options.bays < 3 * options.rows)
      ++options.bays;
    else
      ++options.rows;
  }
  return options;
}

}  // namespace cosiva::zone
