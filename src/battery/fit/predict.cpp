// The behaviour of a type's battery under a log's current.
#include "cosiva/battery/fit/predict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/fit/discharge.h"
#include "cosiva/battery/pack.h"

namespace cosiva::battery {
namespace {

/// One discharge, and the type's battery under the same current.
class Foretelling {
 public:
  Foretelling(const std::shared_ptr<CellTable>& table, const Discharge& discharge, double floor_v, double ambient_c)
      : discharge_{discharge},
        log_{*discharge.log},
        floor_v_{reached_floor(discharge, floor_v)},
        ambient_c_{ambient_c},
        pack_{table, {}, {"fit", 1, false, 0.0}, ambient_c},
        start_s_{load_on_s(discharge)},
        now_s_{start_s_},
        before_v_{pack_.voltage_v()},
        residual_{log_.name,
                  0,
                  0.0,
                  0.0,
                  0.0,
                  1.0,
                  seconds_to_voltage(discharge, floor_v_),
                  std::numeric_limits<double>::quiet_NaN(),
                  floor_v_,
                  start_s_,
                  discharge.uncertain} {}

  /// Applies the measured current sample by sample, until the floor was measured, or to the log's end; beyond that the
  /// last current.
  Residual run() {
    std::size_t end = discharge_.last;
    for (std::size_t i = discharge_.first; i < discharge_.last && !std::isnan(residual_.measured_s); ++i) {
      if (log_.voltage_v[i] > floor_v_) continue;
      end = i + 1;
      break;
    }
    residual_.samples = end - discharge_.first;
    double sum_sq = 0.0;
    for (std::size_t i = discharge_.first; i < end; ++i) {
      go_on(i);
      record_load(i);
      if (ended()) break;
      sum_sq += record_difference(i);
    }
    const double last_a = log_.current_a[end - 1];
    while (!ended() && last_a > 0.0 && now_s_ - start_s_ <= 1.5 * residual_.measured_s) advance(now_s_ + 10.0, last_a);
    residual_.rms_v = std::sqrt(sum_sq / static_cast<double>(std::max<std::size_t>(1, residual_.samples)));
    residual_.current_a = load_s_ > 0.0 ? load_as_ / load_s_ : 0.0;
    return residual_;
  }

 private:
  /// A log that ends above the floor is compared at its own lowest voltage under load.
  static double reached_floor(const Discharge& discharge, double floor_v) {
    return std::max(floor_v, lowest_under_load_v(discharge));
  }
  [[nodiscard]] bool ended() const { return !std::isnan(residual_.predicted_s); }

  void advance(double until_s, double current_a) {
    constexpr double step_max_s = 1.0;
    while (now_s_ < until_s - 1e-9 && !ended()) {
      const double dt_s = std::min(step_max_s, until_s - now_s_);
      const PackStep step = pack_.draw_current(current_a, ambient_c_, dt_s);
      now_s_ += dt_s;
      const bool is_out = step.event == PackEvent::empty || step.event == PackEvent::brown_out;
      if (step.voltage_v <= floor_v_ && current_a > 0.0) {
        const double ratio = before_v_ > step.voltage_v
                                 ? std::clamp((before_v_ - floor_v_) / (before_v_ - step.voltage_v), 0.0, 1.0)
                                 : 1.0;
        residual_.predicted_s = now_s_ - start_s_ - (1.0 - ratio) * dt_s;
      } else if (is_out && current_a > 0.0) {
        residual_.predicted_s = now_s_ - start_s_;
      }
      before_v_ = step.voltage_v;
    }
  }

  /// Advances to sample i under its current; or, if the charge in between is known better, under the corresponding
  /// current, and at the end under the sample's.
  void go_on(std::size_t i) {
    const double dt_s = log_.time_s[i] - now_s_;
    constexpr double glimpse_s = 1e-3;
    const bool is_known = discharge_.is_counted || discharge_.scale != 1.0;
    if (!is_known || dt_s <= 2.0 * glimpse_s) return advance(log_.time_s[i], log_.current_a[i]);
    const double before_ah = i == discharge_.first ? 0.0 : discharge_.used_ah[i - 1 - discharge_.first];
    const double used_ah = discharge_.used_ah[i - discharge_.first] - before_ah;
    advance(log_.time_s[i] - glimpse_s, used_ah * 3600.0 / dt_s);
    advance(log_.time_s[i], log_.current_a[i]);
  }

  void record_load(std::size_t i) {
    if (log_.current_a[i] <= 0.0) return;
    const double dt_s = log_.time_s[i] - (i == discharge_.first ? start_s_ : log_.time_s[i - 1]);
    load_s_ += dt_s;
    load_as_ += log_.current_a[i] * dt_s;
  }

  double record_difference(std::size_t i) {
    const double off_v = pack_.voltage_v() - log_.voltage_v[i];
    if (std::fabs(off_v) > residual_.worst_v) {
      residual_.worst_v = std::fabs(off_v);
      residual_.worst_at_charge = pack_.charge();
    }
    return off_v * off_v;
  }

  const Discharge& discharge_;
  const Log& log_;
  double floor_v_;
  double ambient_c_;
  Pack pack_;
  double start_s_;
  double now_s_;
  double before_v_;
  double load_s_{0.0};
  double load_as_{0.0};
  Residual residual_;
};

}  // namespace

std::vector<Residual> predict(const BatteryType& type, const std::vector<Log>& logs, double floor_v, double known_ah) {
  const double floor = floor_v > 0.0 ? floor_v : type.voltage_floor_v;
  const double full_v = std::max(type.voltage_full_v, highest_voltage_v(logs));
  const auto table = std::make_shared<CellTable>(type);
  std::vector<Residual> residuals;
  for (const Log& log : logs) {
    auto discharges = discharges_from_full(log, full_v, type.series_ohm.back() + type.fast_ohm.back());
    if (known_ah > 0.0) scale_to_capacity(discharges, known_ah, floor);
    for (std::size_t k = 0; k < discharges.size(); ++k) {
      residuals.push_back(Foretelling{table, discharges[k], floor, type.reference_temperature_c}.run());
      if (discharges.size() > 1) residuals.back().log += ", discharge " + std::to_string(k + 1);
    }
  }
  return residuals;
}

}  // namespace cosiva::battery
