#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/battery/fit/log.h"
#include "cosiva/battery/type.h"

namespace cosiva::battery {

struct FitOptions {
  std::string name{"fitted"};
  std::string source{};
  std::string licence{};
  double capacity_ah{0.0};  ///< 0: what the slowest discharge took out
  double floor_v{0.0};      ///< 0: the lowest voltage under load in the logs
  double full_v{0.0};       ///< 0: the highest voltage in the logs
  /// Rows of the tables.
  std::vector<double> charge{0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0};
};

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

struct Fit {
  BatteryType type;
  double fast_s;  ///< the two time constants found
  double slow_s;
  double rms_v;                  ///< over all that was fitted
  double largest_a{0.0};         ///< discharging current that was fitted
  double charge_uncertain{0.0};  ///< how far what was taken out may be off, as a share of it: the worst discharge's
  std::vector<Residual> residuals;
  std::vector<std::string> notes;  ///< what was assumed
};

/// Fits a type's tables to discharges that begin full. With straight tables all but the two time constants is linear:
/// least squares with resistances that are not negative and an open-circuit voltage that grows, for every pair of time
/// constants on a grid. Capacity, spread, ageing and heat that logs do not tell are assumed, and said so.
/// Fails ("fit.…"): fit.full  no discharge begins full; fit.range  too little of the charge is covered;
///  fit.capacity  less than what was taken out; fit.spread  the voltages do not determine the tables
[[nodiscard]] Result<Fit> fit_type(const std::vector<Log>& logs, const FitOptions& options);

/// What a type says of discharges that begin full, whether it was fitted to them or not, at the temperature it was
/// fitted at. Logs without such a discharge have no residual.
/// @param floor_v  of the times; 0: the type's own floor
/// @param known_ah  what the logs' own battery holds, for logs whose samples lie too far apart; 0: what they count
[[nodiscard]] std::vector<Residual> predict(const BatteryType& type, const std::vector<Log>& logs, double floor_v = 0.0,
                                            double known_ah = 0.0);

}  // namespace cosiva::battery
