#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva battery discharge`.
struct BatteryDischargeArguments {
  std::string type;                ///< name of a shipped type, or a file
  std::vector<double> currents_a;  ///< of the whole pack …
  std::vector<double> powers_w;    ///< … as power …
  std::vector<double> rates;       ///< … or in multiples of the capacity; none of the three: 0.2, 0.5, 1 and 2
  double floor_v{0.0};             ///< of a cell; 0: as in the type
  double ambient_c{25.0};
  double step_s{1.0};
  std::uint32_t series{1};
  std::uint32_t parallel{1};
  double scale{1.0};
  std::string csv_file;
  bool json{false};
};

/// `cosiva battery discharge`: discharges a type's battery under constant loads, from full to its floor. Gives the exit
/// status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_battery_discharge(const BatteryDischargeArguments& arguments);

}  // namespace cosiva::app
