#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/zone/generate/generate.h"
#include "cosiva/zone/generate/plant_size.h"

namespace cosiva::app {

/// The options of `cosiva zone generate`.
struct GenerateArguments {
  std::string out_file;
  std::optional<std::uint64_t> sections;  ///< if given, the numbers of rows, aisles and bays follow from it
  zone::PlantOptions plant;
  std::string grid;                   ///< "CxR": a grid of so many columns and rows instead of a plant
  std::optional<std::uint32_t> loop;  ///< a loop of so many nodes instead of a plant
  double pitch_m{3.0};
  bool two_way{false};
  // Their defaults depend on what is generated.
  std::string name;
  std::optional<std::uint32_t> bays;
  std::optional<std::uint32_t> starts;
  bool json{false};
};

/// `cosiva zone generate`: generates a zone of any size, for experiments. Gives the exit status: 0 done, 1 the run's
/// own checks failed, 2 bad usage or bad input.
int run_zone_generate(const GenerateArguments& arguments);

}  // namespace cosiva::app
