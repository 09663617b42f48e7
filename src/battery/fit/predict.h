#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cosiva/battery/fit/log.h"
#include "cosiva/battery/type.h"

namespace cosiva::battery {

/// The deviation of a type from a measured battery, over one discharge.
struct Residual {
  std::string log;
  std::size_t samples;
  double current_a;  ///< mean, while discharging
  double rms_v;
  double worst_v;          ///< largest absolute difference …
  double worst_at_charge;  ///< … and its charge
  double measured_s;       ///< from the start of the load to `floor_v`; NaN if the log has no load
  double predicted_s;      ///< the type's, under the same current; NaN if the floor is never reached
  double floor_v;          ///< the requested floor, or the log's lowest voltage under load if it ends above
  double began_s;          ///< start of its load, in the log's own time
  double uncertain;        ///< uncertainty of the log's charge taken out, as a ratio of it
};

/// A type's predictions for discharges that begin full, whether it was fitted to them or not, at the temperature of the
/// fit. Logs without such a discharge have no residual.
/// @param floor_v  of the times; 0: the type's own floor
/// @param known_ah  capacity of the logs' battery, for logs with infrequent samples; 0: their own counts
[[nodiscard]] std::vector<Residual> predict(const BatteryType& type, const std::vector<Log>& logs, double floor_v = 0.0,
                                            double known_ah = 0.0);

}  // namespace cosiva::battery
