#pragma once

#include <string>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/platform/direct_arguments.h"

namespace cosiva::app {

/// The options of `cosiva unit`.
struct UnitArguments {
  PartArguments part;
  std::string zone;
  std::string crossing;
  DirectArguments direct;
  bool emulated{false};  ///< scenarios switch it off and on
  bool off{false};       ///< it begins switched off
};

/// `cosiva unit`: one crossing unit alone. Gives the exit status: 0 done, 2 bad usage or bad input.
int run_unit(const UnitArguments& arguments);

}  // namespace cosiva::app
