#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/battery/fit/log.h"
#include "cosiva/battery/fit/predict.h"
#include "cosiva/battery/type.h"

namespace cosiva::battery {

struct FitOptions {
  std::string name{"fitted"};
  std::string source{};
  std::string licence{};
  double capacity_ah{0.0};  ///< 0: the charge that the slowest discharge took out
  double floor_v{0.0};      ///< 0: the lowest voltage under load in the logs
  double full_v{0.0};       ///< 0: the highest voltage in the logs
  /// Rows of the tables.
  std::vector<double> charge{0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0};
};

struct Fit {
  BatteryType type;
  double fast_s;  ///< the two time constants found
  double slow_s;
  double rms_v;                  ///< over all that was fitted
  double largest_a{0.0};         ///< largest discharging current fitted
  double charge_uncertain{0.0};  ///< uncertainty of the charge taken out, as a ratio of it: that of the worst discharge
  std::vector<Residual> residuals;
  std::vector<std::string> diagnostics;  ///< assumptions and warnings
};

/// Fits a type's tables to discharges that begin full. With piecewise linear tables all but the two time constants is
/// linear: least squares with non-negative resistances and an increasing open-circuit voltage, for every pair of time
/// constants on a grid. Capacity, spread, ageing and heat that logs do not determine are assumed, and reported as such.
/// Fails ("fit.…"): fit.full  no discharge begins full; fit.range  too little of the charge is covered;
///  fit.capacity  less than the charge taken out; fit.spread  the voltages do not determine the tables
[[nodiscard]] Result<Fit> fit_type(const std::vector<Log>& logs, const FitOptions& options);

}  // namespace cosiva::battery
