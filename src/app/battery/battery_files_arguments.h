#pragma once

#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva battery compare` and `check`.
struct BatteryFilesArguments {
  std::vector<std::string> files;
  bool json{false};
};

}  // namespace cosiva::app
