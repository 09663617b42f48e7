#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cosiva/battery/fit/log.h"
#include "cosiva/battery/type.h"

namespace cosiva::battery {

/// How far a type is from what a battery of it did, over one discharge.
struct Residual {
  std::string log;
  std::size_t samples;
  double current_a;  ///< mean, while discharging
  double rms_v;
  double worst_v;          ///< largest absolute difference …
  double worst_at_charge;  ///< … and where
  double measured_s;       ///< load on to `floor_v`; NaN where the log has no load
  double predicted_s;      ///< the type's, under the same current; NaN where it never gets there
  double floor_v;          ///< what was asked for, or the log's lowest voltage under load where it ends above
  double began_s;          ///< when its load came on, in the log's own time
  double uncertain;        ///< how far what the log says was taken out may be off, as a share of it
};

/// What a type says of discharges that begin full, whether it was fitted to them or not, at the temperature it was
/// fitted at. Logs without such a discharge have no residual.
/// @param floor_v  of the times; 0: the type's own floor
/// @param known_ah  what the logs' own battery holds, for logs whose samples lie too far apart; 0: what they count
[[nodiscard]] std::vector<Residual> predict(const BatteryType& type, const std::vector<Log>& logs, double floor_v = 0.0,
                                            double known_ah = 0.0);

}  // namespace cosiva::battery
