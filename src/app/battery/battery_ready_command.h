#pragma once

#include <string>

#include "cosiva/app/cli/common_arguments.h"

namespace cosiva::app {

/// The options of `cosiva battery ready`.
struct BatteryReadyArguments {
  std::string vehicle;
  std::string battery;
  std::string type{"unknown"};
  double cycles{0.0};
  double rest_s{0.0};
  double temperature_c{22.0};
  double charge_percent{100.0};
  BrokerArguments broker;
};

/// `cosiva battery ready`: publishes batteryReady for the person who changed the battery. Gives the exit status: 0
/// done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_battery_ready(const BatteryReadyArguments& arguments);

}  // namespace cosiva::app
