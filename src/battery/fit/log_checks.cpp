#include "cosiva/battery/fit/log_checks.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

namespace cosiva::battery {
namespace {

std::string location(const Log& log, std::size_t i) {
  return i < log.line.size() ? log.origin + ":" + std::to_string(log.line[i]) : log.name;
}

double largest_current_a(const Log& log) {
  double largest_a = 0.0;
  for (const double current : log.current_a) largest_a = std::max(largest_a, std::fabs(current));
  return largest_a;
}

/// The interval that nineteen of twenty do not exceed, or that five of the largest agree on: a pulse test has far more
/// samples in its pulses than between them. Testers write less and less often as the voltage approaches its steady
/// state.
double usual_of(std::vector<double> values) {
  std::ranges::sort(values);
  double usual = values[values.size() - 1 - values.size() / 20];
  constexpr std::size_t agreeing = 5;
  for (std::size_t i = agreeing - 1; i < values.size(); ++i)
    if (values[i] <= 1.02 * values[i + 1 - agreeing]) usual = std::max(usual, values[i]);
  return usual;
}

/// A gap under load: three times longer than usual under load, and more than 2 ‰ of all charge that flowed. If a load's
/// first sample follows a rest, the load may have started only then: a gap is far longer than the log's own rests
/// between two samples. A charge that continues unchanged, with a higher voltage, is one charge, whatever the sampling
/// interval.
Result<void> check_gaps(const Log& log) {
  std::vector<double> loaded;
  std::vector<double> rested;
  double flowed_as = 0.0;
  const double largest_a = largest_current_a(log);
  const auto is_load = [&](std::size_t i) { return std::fabs(log.current_a[i]) > 0.01 * largest_a; };
  for (std::size_t i = 1; i < log.time_s.size(); ++i) {
    const double dt_s = log.time_s[i] - log.time_s[i - 1];
    if (!is_load(i)) {
      rested.push_back(dt_s);
      continue;
    }
    loaded.push_back(dt_s);
    flowed_as += std::fabs(log.current_a[i]) * dt_s;
  }
  if (loaded.empty()) return fail("log.short", "has no load anywhere", log.name);
  const double usual_s = usual_of(loaded);
  constexpr std::size_t rests_min = 40;
  const double rest_s = rested.size() < rests_min ? std::numeric_limits<double>::infinity() : usual_of(rested);
  for (std::size_t i = 1; i < log.time_s.size(); ++i) {
    const double dt_s = log.time_s[i] - log.time_s[i - 1];
    const bool load_comes = is_load(i) && !is_load(i - 1);
    // After the end of a load testers write the rest's first sample only after a rest's usual time: this is no gap.
    const bool still_charges = is_load(i - 1) && log.current_a[i] < 0.0 && log.current_a[i - 1] < 0.0 &&
                               log.voltage_v[i] >= 0.998 * log.voltage_v[i - 1];
    if (still_charges) continue;
    const double longest_s =
        load_comes ? std::max(3.0 * rest_s, 610.0) : std::max(3.0 * usual_s, is_load(i) ? 61.0 : 310.0);
    if (!(is_load(i) || is_load(i - 1)) || dt_s <= longest_s) continue;
    const double unseen_as = dt_s * std::max(std::fabs(log.current_a[i]), std::fabs(log.current_a[i - 1]));
    if (unseen_as <= 0.002 * flowed_as) continue;
    return fail("log.gap",
                "nothing between " + short_number(log.time_s[i - 1]) + " s and " + short_number(log.time_s[i]) +
                    " s, under up to " + short_number(unseen_as / dt_s) + " A",
                location(log, i));
  }
  return {};
}

Result<void> check_voltages(const Log& log) {
  const std::vector<double>& volt = log.voltage_v;
  for (std::size_t i = 0; i < volt.size(); ++i)
    if (!(volt[i] > 0.0 && volt[i] < 2000.0))
      return fail("log.number",
                  "voltage_volt is " + short_number(volt[i]) + " at " + short_number(log.time_s[i]) + " s",
                  location(log, i));
  // One sample far from both its neighbours, which have similar voltages and the same current: an error of the tester.
  const double largest_a = largest_current_a(log);
  for (std::size_t i = 1; i + 1 < volt.size(); ++i) {
    const double apart_v = std::fabs(volt[i + 1] - volt[i - 1]);
    const double off_v = std::min(std::fabs(volt[i] - volt[i - 1]), std::fabs(volt[i] - volt[i + 1]));
    const double change_a = std::fabs(log.current_a[i] - log.current_a[i - 1]);
    if (off_v > 0.15 * volt[i - 1] && apart_v < 0.1 * off_v && change_a < 0.05 * largest_a)
      return fail("log.number",
                  "voltage_volt jumps from " + short_number(volt[i - 1]) + " to " + short_number(volt[i]) + " and back",
                  location(log, i));
  }
  return {};
}

Result<void> check_temperatures(const Log& log) {
  for (std::size_t i = 0; i < log.temperature_c.size(); ++i)
    if (!(log.temperature_c[i] > -80.0 && log.temperature_c[i] < 200.0))
      return fail("log.number",
                  "the temperature is " + short_number(log.temperature_c[i]) + " °C at " + short_number(log.time_s[i]) +
                      " s; kelvin?",
                  location(log, i));
  return {};
}

/// Correlation of the voltage with the charge taken out: -1 falls steadily, 1 rises steadily.
double fall_with_charge(const Log& log) {
  const auto count = static_cast<double>(log.voltage_v.size());
  std::vector<double> used_as{0.0};
  used_as.reserve(log.time_s.size());
  for (std::size_t i = 1; i < log.time_s.size(); ++i)
    used_as.push_back(used_as.back() + log.current_a[i] * (log.time_s[i] - log.time_s[i - 1]));
  const auto mean = [&](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value / count;
    return sum;
  };
  const double mean_v = mean(log.voltage_v);
  const double mean_as = mean(used_as);
  double both = 0.0;
  double volt_sq = 0.0;
  double used_sq = 0.0;
  for (std::size_t i = 0; i < used_as.size(); ++i) {
    both += (used_as[i] - mean_as) * (log.voltage_v[i] - mean_v);
    volt_sq += (log.voltage_v[i] - mean_v) * (log.voltage_v[i] - mean_v);
    used_sq += (used_as[i] - mean_as) * (used_as[i] - mean_as);
  }
  return volt_sq > 0.0 && used_sq > 0.0 ? both / std::sqrt(volt_sq * used_sq) : 0.0;
}

/// An increase of the discharge current lowers the voltage, and charge taken out lowers it permanently. If a tester
/// holds the voltage and the current follows, steps carry no information.
Result<void> check_sign(const Log& log) {
  double right = 0.0;
  double wrong = 0.0;
  std::size_t wrong_count = 0;
  std::size_t wrong_at = 0;
  double worst = 0.0;
  const double largest_a = largest_current_a(log);
  const auto [low, high] = std::ranges::minmax_element(log.voltage_v);
  for (std::size_t i = 1; i < log.time_s.size(); ++i) {
    const double change_a = log.current_a[i] - log.current_a[i - 1];
    const double change_v = log.voltage_v[i] - log.voltage_v[i - 1];
    if (std::fabs(change_a) <= 0.1 * largest_a || std::fabs(change_v) < 0.001 * (*high - *low)) continue;
    const double product = change_a * change_v;
    (product > 0.0 ? wrong : right) += std::fabs(product);
    if (product <= 0.0) continue;
    ++wrong_count;
    if (product <= worst) continue;
    worst = product;
    wrong_at = i;
  }
  const double fall = fall_with_charge(log);
  constexpr double plain = 0.8;
  constexpr std::size_t few = 3;
  if (wrong_count < few && fall < -plain) return {};
  // Steps of both signs in one log: a tester that writes the magnitude of the current, and its direction in another
  // column.
  if (std::min(wrong, right) > 0.3 * std::max(wrong, right))
    return fail(
        "log.sign",
        "the voltage rises with some steps of current_ampere and falls with others: it has no sign. Write charging "
        "currents as positive and discharging currents as negative",
        location(log, wrong_at));
  if (wrong > right || (wrong == right && fall > 0.0))
    return fail("log.sign",
                "the voltage falls at positive current_ampere, which should charge: it has the other sign. Invert "
                "the column's sign",
                location(log, wrong_at));
  return {};
}

/// If the tester counted charge itself, its count and current times time must be about the same.
Result<void> check_count(const Log& log) {
  if (log.counted_ah.size() != log.time_s.size()) return {};
  double counted_ah = 0.0;
  double flowed_ah = 0.0;
  for (std::size_t i = 1; i < log.time_s.size(); ++i) {
    if (log.current_a[i] <= 0.0) continue;
    counted_ah += std::max(0.0, log.counted_ah[i] - log.counted_ah[i - 1]);
    flowed_ah += log.current_a[i] * (log.time_s[i] - log.time_s[i - 1]) / 3600.0;
  }
  constexpr double most = 10.0;  // a log with infrequent samples may be off by much
  if (!(counted_ah > 0.0 && flowed_ah > 0.0) || (flowed_ah < most * counted_ah && counted_ah < most * flowed_ah))
    return {};
  return fail("log.unit",
              "current times time is " + short_number(flowed_ah) +
                  " Ah, the tester's own column of the charge taken out " + short_number(counted_ah) +
                  " Ah: test_time_second, current_ampere or that column has another unit",
              location(log, log.time_s.size() - 1));
}

/// Hours or minutes in a column of seconds: a whole discharge within a minute of load, at 60C.
Result<void> check_time(const Log& log) {
  double most_as = 0.0;
  double used_as = 0.0;
  double load_s = 0.0;
  for (std::size_t i = 1; i < log.time_s.size(); ++i) {
    const double dt_s = log.time_s[i] - log.time_s[i - 1];
    used_as += log.current_a[i] * dt_s;
    most_as = std::max(most_as, used_as);
    if (log.current_a[i] > 0.0) load_s += dt_s;
  }
  const double fall_v = *std::ranges::max_element(log.voltage_v) - *std::ranges::min_element(log.voltage_v);
  // Only if the voltage shows a discharge from full to empty.
  if (load_s > 0.0 && load_s < 60.0 && most_as > 0.0 && fall_v > 0.15 * log.voltage_v.front())
    return fail("log.unit",
                "discharged from full to empty in " + short_number(load_s) +
                    " s of test_time_second: it holds hours or minutes, not seconds",
                location(log, log.time_s.size() - 1));
  constexpr double year_s = 365.0 * 86400.0;
  if (load_s > 3.0 * year_s)
    return fail("log.unit",
                "was under load for " + short_number(load_s / year_s) +
                    " years by test_time_second: it holds milliseconds, or was scaled twice",
                location(log, log.time_s.size() - 1));
  return {};
}

}  // namespace

std::string short_number(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6);
  return {buffer.data(), error == std::errc{} ? end : buffer.data()};
}

Result<void> check_log(const Log& log) {
  if (auto time = check_time(log); !time) return time;
  if (auto count = check_count(log); !count) return count;
  if (auto gap = check_gaps(log); !gap) return gap;
  if (auto voltage = check_voltages(log); !voltage) return voltage;
  if (auto temperature = check_temperatures(log); !temperature) return temperature;
  return check_sign(log);
}

}  // namespace cosiva::battery
