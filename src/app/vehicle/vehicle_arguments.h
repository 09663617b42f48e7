#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosiva::app {

/// Of `cosiva vehicle line-tracking`.
struct LineTrackingArguments {
  std::vector<std::string> algorithms;  ///< empty: all
  std::string zone{"lacet4"};
  std::vector<double> speeds_mps{0.2, 0.4, 0.6};
  double distance_m{20.0};
  double unevenness_mm{0.5};
  std::uint64_t seed{1};
  std::string out_file;  ///< of the chart; empty: none
  bool json{false};
};

/// Of the subcommands of `cosiva vehicle`.
struct VehicleArguments {
  std::vector<std::string> vehicles;  ///< "CoSiVA/AIV1", or "AIV1" where only one vehicle has that serial number
  std::string url{"http://127.0.0.1:8080"};
  bool json{false};
  LineTrackingArguments line;
};

}  // namespace cosiva::app
