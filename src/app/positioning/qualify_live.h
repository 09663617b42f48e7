#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/positioning/qualify_arguments.h"

namespace cosiva::app {

/// The options of `cosiva qualify|compare --live`, in addition to QualifyArguments.
struct LiveQualifyArguments {
  bool live{false};
  std::string url{"http://127.0.0.1:8080"};
  BrokerArguments broker;
  std::vector<std::string> vehicles;  ///< AIV3, or MANUFACTURER/SERIAL; none: AIV1
  std::string ground_truth_topic;     ///< empty: the plant's
  bool speed_given{false};            ///< else the vehicles keep their speed
};

/// The scenarios of figures 16 and 17 on a running platform: its vehicles run the algorithms, its plant or global
/// vision system provides the actual positions. Gives the exit status.
/// @param at_least  minimum number of algorithms
int run_qualify_live(const QualifyArguments& arguments, const LiveQualifyArguments& live, std::size_t at_least);

}  // namespace cosiva::app
