#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/pose.h"

/// The result of a qualification for other programs.
namespace cosiva::experiments {

/// The conditions of the runs, so that they can be repeated.
struct Conditions {
  std::string command;                                        ///< the command line
  std::string what;                                           ///< "virtual time on lacet4", "recordings"
  std::vector<std::pair<std::string, std::string>> settings;  ///< name and value, as text
  std::vector<std::string> diagnostics;                       ///< remarks for the reader
  std::vector<std::vector<Point2>> lines{};  ///< of the zone, to be drawn beneath paths; none in the open
};

}  // namespace cosiva::experiments
