#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/pose.h"

/// A qualification as others read it.
namespace cosiva::experiments {

/// What the runs were, so that they can be repeated.
struct Conditions {
  std::string command;                                        ///< the command line
  std::string what;                                           ///< "virtual time on lacet4", "recordings"
  std::vector<std::pair<std::string, std::string>> settings;  ///< name and value, in words
  std::vector<std::string> diagnostics;                       ///< what its reader should know
  std::vector<std::vector<Point2>> lines{};  ///< of the zone, to be drawn beneath ways; none in the open
};

}  // namespace cosiva::experiments
