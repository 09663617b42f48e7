#pragma once

#include <cstddef>

namespace cosiva::app {

/// The options of `cosiva battery plan`.
struct BatteryPlanArguments {
  double cv_percent{1.4};
  double half_width_percent{1.0};
  double difference_percent{0.0};  ///< between two types; 0: not requested
  std::size_t aivs{0};             ///< number of AIVs of the Latin square; 0: not requested
  bool json{false};
};

/// `cosiva battery plan`: how many batteries a test needs, and which vehicle gets which battery. Gives the exit status:
/// 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_battery_plan(const BatteryPlanArguments& arguments);

}  // namespace cosiva::app
