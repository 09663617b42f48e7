#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/app/cli/common_arguments.h"

namespace cosiva::app {

/// The options of `cosiva plant`.
struct PlantArguments {
  PartArguments part;
  std::string zone;
  std::uint32_t vehicles{4};
  std::uint64_t seed{1};
  std::string sockets_directory;
  std::string state_file;
  std::vector<std::string> line_tracking;  ///< NAME or VEHICLE=NAME
  std::vector<std::string> without_rali;   ///< numbers of vehicles, or all
};

/// `cosiva plant`: the emulated plant alone. Gives the exit status: 0 done, 1 the run's own checks failed, 2 bad usage
/// or bad input.
int run_plant(const PlantArguments& arguments);

}  // namespace cosiva::app
