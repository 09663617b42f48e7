#include "cosiva/battery/gauge/gauge.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/battery/cell_table.h"

namespace cosiva::battery {
namespace {

constexpr double unknown_variance = 0.09;  // a third: half full, with a large uncertainty
constexpr double needs_full_sd = 0.05;

/// Deviation of the voltage after a rest from the open-circuit voltage, expressed as charge: half of the maximum that
/// the Leaf's pulse test at 25 °C shows 1, 5, 15 and 30 minutes after a load, as one standard deviation.
struct Rest {
  double seconds;
  double sd;
};
constexpr std::array rests{Rest{60.0, 0.0145}, Rest{300.0, 0.0085}, Rest{900.0, 0.004}, Rest{1800.0, 0.002}};
constexpr double rest_smoothing_s = 20.0;

double rest_sd(double rested_s) {
  if (rested_s >= rests.back().seconds) return rests.back().sd;
  std::size_t i = 1;
  while (rests[i].seconds <= rested_s) ++i;
  const Rest& a = rests[i - 1];
  const Rest& b = rests[i];
  return a.sd + (b.sd - a.sd) * (rested_s - a.seconds) / (b.seconds - a.seconds);
}

/// The error of a model's voltage under load is persistent (it results from this battery's resistance): samples of five
/// minutes have the weight of one.
constexpr double model_error_lasts_s = 300.0;
constexpr double model_resistance_error = 0.3;  // of R0 + R1 + R2, as a ratio
constexpr double model_heat_error_per_k = 0.01;

double squared(double x) { return x * x; }

}  // namespace

std::optional<GaugeMethod> parse_method(std::string_view word) {
  if (word == "counter") return GaugeMethod::counter;
  if (word == "rest") return GaugeMethod::rest;
  if (word == "kalman") return GaugeMethod::kalman;
  return std::nullopt;
}

std::string_view to_string(GaugeMethod method) {
  switch (method) {
    case GaugeMethod::counter: return "counter";
    case GaugeMethod::rest: return "rest";
    case GaugeMethod::kalman: break;
  }
  return "kalman";
}

Gauge::Gauge(std::shared_ptr<const CellTable> table, GaugeOptions options, double charge, double charge_sd)
    : table_{std::move(table)}, options_{options}, charge_{charge}, variance_{squared(charge_sd)} {
  COSIVA_EXPECT(table_ != nullptr && options_.design.series > 0 && options_.design.parallel > 0);
  start_from(charge, variance_);
}

void Gauge::full() { start_from(1.0, squared(0.005)); }
void Gauge::unknown() { start_from(0.5, unknown_variance); }

void Gauge::start_from(double charge, double variance) {
  charge_ = charge;
  variance_ = variance;
  used_ = 0.0;
  counted_s_ = 0.0;
  rested_s_ = 0.0;
  pair_v_ = {};
  covariance_ = {};
  covariance_[0][0] = variance;
}

GaugeReading Gauge::reading() const {
  const double sd = std::sqrt(variance_);
  return {std::clamp(charge_, 0.0, 1.0), sd, sd > needs_full_sd};
}

/// Error of one cell's voltage as measured by the monitor: gain, noise and half a step.
double Gauge::cell_error_v(double cell_v) const {
  const double noise_v =
      (options_.errors.voltage_noise_v + 0.5 * options_.errors.voltage_step_v) / options_.design.series;
  return std::sqrt(squared(options_.errors.voltage_gain_sd * cell_v) + squared(noise_v));
}

void Gauge::see(const Measured& measured, double dt_s) {
  const double added_variance = count(measured.current_a, dt_s);
  if (options_.method != GaugeMethod::counter) rest(measured, dt_s);
  if (options_.method == GaugeMethod::kalman) filter(measured, added_variance, dt_s);
}

/// @return  the increase of the charge's variance: the errors of a gain and of an unknown capacity grow with the
/// counted charge, the error of an offset with the time, so that their squares add up to the square of the whole
double Gauge::count(double current_a, double dt_s) {
  const BatteryType& type = table_->type();
  const double capacity_as = 3600.0 * type.capacity_ah * options_.design.scale * options_.design.parallel;
  const double kept = current_a < 0.0 ? type.coulombic_efficiency : 1.0;
  const double step = kept * current_a * dt_s / capacity_as;
  charge_ -= step;
  const double ratio = squared(options_.errors.current_gain_sd) + squared(options_.capacity_sd);
  const double used = used_ + std::fabs(step);
  double added = ratio * (squared(used) - squared(used_));
  used_ = used;
  const double drift_per_s = options_.errors.current_offset_sd_a / capacity_as;
  added += squared(drift_per_s) * (squared(counted_s_ + dt_s) - squared(counted_s_));
  counted_s_ += dt_s;
  COSIVA_EXPECT(!(added < 0.0));
  variance_ += added;
  return added;
}

void Gauge::rest(const Measured& measured, double dt_s) {
  const BatteryType& type = table_->type();
  const double capacity_ah = type.capacity_ah * options_.design.scale * options_.design.parallel;
  const double still_a = 0.01 * capacity_ah + 3.0 * options_.errors.current_noise_a;
  if (std::fabs(measured.current_a) > still_a) {
    rested_s_ = 0.0;
    return;
  }
  const double cell_v = measured.voltage_v / options_.design.series;
  if (rested_s_ == 0.0) {
    before_rest_ = charge_;
    variance_before_rest_ = variance_;
    rest_v_ = cell_v;
  }
  rested_s_ += dt_s;
  rest_v_ += (cell_v - rest_v_) * std::min(1.0, dt_s / rest_smoothing_s);
  if (rested_s_ < rests.front().seconds) return;
  // Combined at every moment of a rest with the estimate before the rest: the errors of samples of one rest are the
  // same, so later samples replace the earlier ones instead of adding to them.
  const double detected = table_->charge_of(rest_v_);
  const double slope_v = std::max(1e-3, table_->volt_per_charge(detected));
  const double detected_variance = squared(rest_sd(rested_s_)) + squared(cell_error_v(cell_v) / slope_v);
  const double weight = variance_before_rest_ / (variance_before_rest_ + detected_variance);
  charge_ = before_rest_ + weight * (detected - before_rest_);
  variance_ = (1.0 - weight) * variance_before_rest_;
  used_ = 0.0;
  counted_s_ = 0.0;
  covariance_ = {};
  covariance_[0][0] = variance_;
  pair_v_ = {};
}

void Gauge::filter(const Measured& measured, double added_variance, double dt_s) {
  const CellRow row = table_->at(charge_);
  const PackDesign& design = options_.design;
  const double heat = table_->heat_factor(measured.temperature_c) / design.scale;
  const double cell_a = measured.current_a / design.parallel;
  const std::array decay{det_exp(-std::min(600.0, row.fast_per_s * dt_s)),
                         det_exp(-std::min(600.0, row.slow_per_s * dt_s))};
  const std::array ohm{row.fast_ohm * heat, row.slow_ohm * heat};
  auto& cov = covariance_;
  for (std::size_t k = 0; k < 2; ++k) {
    pair_v_[k] = decay[k] * pair_v_[k] + (1.0 - decay[k]) * ohm[k] * cell_a;
    for (std::size_t j = 0; j < 3; ++j) {
      cov[k + 1][j] *= decay[k];
      cov[j][k + 1] *= decay[k];
    }
    cov[k + 1][k + 1] += squared(model_resistance_error * (1.0 - decay[k]) * ohm[k] * cell_a);
  }
  cov[0][0] += added_variance;
  if (rested_s_ >= rests.front().seconds) return;  // the rest layer has already used this voltage

  // The model's uncertainty of its voltage grows with the current and with the distance from the conditions of its
  // measurement.
  const double series_ohm = row.series_ohm * heat;
  const double drop_v = (series_ohm + ohm[0] + ohm[1]) * cell_a;
  const double away_k = std::fabs(measured.temperature_c - table_->type().reference_temperature_c);
  const double cell_v = measured.voltage_v / design.series;
  const double variance = (squared(cell_error_v(cell_v)) + squared(model_resistance_error * drop_v) +
                           squared(model_heat_error_per_k * away_k * drop_v)) *
                          std::max(1.0, model_error_lasts_s / dt_s);
  const std::array<double, 3> slope{table_->volt_per_charge(charge_), -1.0, -1.0};
  std::array<double, 3> gain{};
  for (std::size_t i = 0; i < 3; ++i) gain[i] = cov[i][0] * slope[0] + cov[i][1] * slope[1] + cov[i][2] * slope[2];
  const double total = slope[0] * gain[0] + slope[1] * gain[1] + slope[2] * gain[2] + variance;
  const double surprise_v = cell_v - (row.open_circuit_v - series_ohm * cell_a - pair_v_[0] - pair_v_[1]);
  charge_ = std::clamp(charge_ + gain[0] / total * surprise_v, 0.0, 1.0);
  pair_v_[0] += gain[1] / total * surprise_v;
  pair_v_[1] += gain[2] / total * surprise_v;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) cov[i][j] -= gain[i] * gain[j] / total;
  }
  variance_ = cov[0][0];
}

std::string Gauge::state_json() const {
  JsonWriter json;
  json.begin_array();
  for (const double value : {charge_, variance_, used_, counted_s_, rested_s_, rest_v_, before_rest_,
                             variance_before_rest_, pair_v_[0], pair_v_[1]})
    json.value(value);
  for (const auto& row : covariance_) {
    for (const double value : row) json.value(value);
  }
  return json.end_array().take();
}

Result<void> Gauge::restore(std::string_view state_json) {
  const auto json = JsonValue::parse(state_json);
  if (!json || json->array() == nullptr || json->array()->size() != 19)
    return fail("gauge.state", "expected a list of 19 numbers", "gauge state");
  for (const JsonValue& item : *json->array())
    if (item.number() == nullptr) return fail("gauge.state", "expected a list of 19 numbers", "gauge state");
  std::size_t next = 0;
  const auto take = [&] { return *(*json->array())[next++].number(); };
  for (double* target : {&charge_, &variance_, &used_, &counted_s_, &rested_s_, &rest_v_, &before_rest_,
                         &variance_before_rest_, &pair_v_[0], &pair_v_[1]})
    *target = take();
  for (auto& row : covariance_) {
    for (double& value : row) value = take();
  }
  return {};
}

void Gauge::fold(Digest& digest) const {
  digest.add(charge_);
  digest.add(variance_);
  digest.add(rested_s_);
}

}  // namespace cosiva::battery
