#pragma once

#include <string>
#include <vector>

namespace cosiva::app {

/// Of the subcommands of `cosiva vehicle`.
struct VehicleArguments {
  std::vector<std::string> vehicles;  ///< "CoSiVA/AIV1", or "AIV1" where only one vehicle has that serial number
  std::string url{"http://127.0.0.1:8080"};
  bool json{false};
};

}  // namespace cosiva::app
