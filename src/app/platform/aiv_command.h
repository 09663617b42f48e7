#pragma once

#include <cstdint>
#include <string>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/platform/direct_arguments.h"

namespace cosiva::app {

/// The options of `cosiva aiv`.
struct AivArguments {
  PartArguments part;
  std::uint32_t number{1};
  std::string serial;  ///< empty: "AIV<number>"
  std::string sockets_directory;
  std::string zone;   ///< empty: from the broker
  std::string start;  ///< "section:s"; empty: unknown until a tag or an initPosition defines the position
  std::string state_file;
  bool emulated{false};        ///< its radio is the emulated world's
  std::string rules{"fuzzy"};  ///< crisp, fuzzy or a file
  std::string vehicle_file;    ///< loads and actions; empty: the usual ones
  bool v2x{true};
  bool rali{true};  ///< the vehicle has this board
  DirectArguments direct;
};

/// `cosiva aiv`: the on-board program of one AIV alone. Gives the exit status: 0 done, 1 the run's own checks failed, 2
/// bad usage or bad input.
int run_aiv(const AivArguments& arguments);

}  // namespace cosiva::app
