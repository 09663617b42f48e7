// The charge taken out from one full charge on, and when.
#include "cosiva/battery/fit/discharge.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cosiva::battery {
namespace {

double largest_current_a(const Log& log) {
  double largest_a = 0.0;
  for (const double current : log.current_a) largest_a = std::max(largest_a, std::fabs(current));
  return largest_a;
}

/// How long before sample i the current may have changed already, if it differs from the previous sample's. A tester
/// that writes a sample at each step of its test records the time of the change; a tester that writes every minute does
/// not: then the samples around the change have the same distance as those before and after it.
double change_unseen_s(const Log& log, std::size_t i) {
  const std::vector<double>& current = log.current_a;
  const auto is_alike = [](double a, double b) {
    return std::fabs(a - b) <= 0.05 * std::max(std::fabs(a), std::fabs(b));
  };
  if (i < 2 || i + 1 >= current.size() || is_alike(current[i - 1], current[i])) return 0.0;
  const double dt_s = log.time_s[i] - log.time_s[i - 1];
  const double before_s = log.time_s[i - 1] - log.time_s[i - 2];
  const double after_s = log.time_s[i + 1] - log.time_s[i];
  return is_alike(dt_s, before_s) && is_alike(dt_s, after_s) ? dt_s : 0.0;
}

/// Uncertainty of the charge taken out between the samples [As]. The starts and ends of long loads are too early as
/// often as too late: twice the standard deviation of their differences. The errors of loads of one sample or two may
/// all have the same sign, since a pulse test repeats itself; those of a drive's load, which always changes, do not.
double open_charge_as(const Discharge& one) {
  const Log& log = *one.log;
  constexpr std::size_t brief_max = 2;
  double brief_as = 0.0;       // of loads …
  double brief_back_as = 0.0;  // … and of charges
  double brief_sq = 0.0;
  double long_sq = 0.0;
  double largest_a = 0.0;
  std::size_t changes = 0;
  std::size_t changed_at = one.first;
  for (std::size_t i = one.first; i < one.last; ++i) largest_a = std::max(largest_a, std::fabs(log.current_a[i]));
  for (std::size_t i = std::max<std::size_t>(1, one.first); i < one.last; ++i) {
    const double change_as = std::fabs(log.current_a[i] - log.current_a[i - 1]) * change_unseen_s(log, i);
    if (change_as <= 0.0) continue;
    const bool was_load = std::fabs(log.current_a[i - 1]) > 0.01 * largest_a;
    // A pulse that ends after a sample or two counts with its start.
    const bool is_brief = was_load && i - changed_at <= brief_max;
    if (is_brief) (log.current_a[i - 1] > 0.0 ? brief_as : brief_back_as) += change_as;
    (is_brief ? brief_sq : long_sq) += change_as * change_as / 12.0;
    changed_at = i;
    ++changes;
  }
  const bool always_changes = 5 * changes > 4 * (one.last - one.first);
  if (always_changes) return 2.0 * std::sqrt(long_sq + brief_sq);
  return std::sqrt(brief_as * brief_as + brief_back_as * brief_back_as + 4.0 * long_sq);
}

/// Computes the charge taken out, sample by sample, and its uncertainty. The tester's own count is better, if there is
/// one, since testers measure more often than they write. A count that contradicts the samples is ignored.
void count_charge(Discharge& one) {
  const Log& log = *one.log;
  const double most_ah = *std::ranges::max_element(one.used_ah);
  if (!(most_ah > 0.0)) return;
  one.uncertain = open_charge_as(one) / 3600.0 / most_ah;
  if (log.counted_ah.size() != log.time_s.size()) return;
  const double before_ah = log.counted_ah[one.first == 0 ? 0 : one.first - 1];
  const double counted_ah = log.counted_ah[one.last - 1] - before_ah;
  if (std::fabs(counted_ah - one.used_ah.back()) > (0.05 + 2.0 * one.uncertain) * most_ah) return;
  for (std::size_t i = one.first; i < one.last; ++i) one.used_ah[i - one.first] = log.counted_ah[i] - before_ah;
  one.uncertain = 0.0;
  one.is_counted = true;
}

/// The highest voltage except during charges of less than a twentieth of the charge that the log moves.
double highest_of(const Log& log) {
  const double load_a = 0.005 * largest_current_a(log);
  const double brief_as = 0.05 * 3600.0 * charge_moved_ah(log);
  double highest_v = 0.0;
  for (std::size_t i = 0; i < log.time_s.size();) {
    double phase_v = log.voltage_v[i];
    double charged_as = 0.0;
    std::size_t end = i;
    for (; end < log.time_s.size() && log.current_a[end] < -load_a; ++end) {
      phase_v = std::max(phase_v, log.voltage_v[end]);
      if (end > 0) charged_as -= log.current_a[end] * (log.time_s[end] - log.time_s[end - 1]);
    }
    if (end == i || charged_as >= brief_as) highest_v = std::max(highest_v, phase_v);
    i = std::max(end, i + 1);
  }
  return highest_v;
}

}  // namespace

std::vector<Discharge> discharges_from_full(const Log& log, double full_v, double full_ohm) {
  const std::size_t size = log.time_s.size();
  const double largest_a = largest_current_a(log);
  const double load_a = 0.005 * largest_a;
  const double brief_ah = std::max(30.0 / 3600.0 * largest_a, 0.02 * charge_moved_ah(log));
  const auto is_full = [&](std::size_t i) { return log.voltage_v[i] >= 0.99 * full_v; };

  std::vector<Discharge> all;
  // At the log's start the battery is full if a rest or the first sample under load shows this, and it is not being
  // charged.
  const double rested_v = log.voltage_v.front() + std::max(0.0, log.current_a.front()) * full_ohm;
  bool full = log.current_a.front() >= -load_a && (is_full(0) || rested_v >= 0.96 * full_v);
  for (std::size_t i = 0; i < size; ++i) {
    if (log.current_a[i] < -load_a) {
      full = is_full(i);
      continue;
    }
    if (!full || log.current_a[i] <= load_a) continue;
    Discharge one{&log, i, i, {}, 0.0, false, 1.0};
    double used_ah = 0.0;
    double most_ah = 0.0;
    for (; one.last < size; ++one.last) {
      const std::size_t k = one.last;
      const double since_s = k == i ? load_on_s(one) : log.time_s[k - 1];
      used_ah += log.current_a[k] * (log.time_s[k] - since_s) / 3600.0;
      most_ah = std::max(most_ah, used_ah);
      // After a full charge a pulse test's regeneration returns a little charge; a recharge ends the discharge.
      if (most_ah - used_ah > std::max(0.05 * most_ah, brief_ah) && log.current_a[k] < -load_a) break;
      one.used_ah.push_back(used_ah);
    }
    full = false;
    i = one.last - 1;
    count_charge(one);
    all.push_back(std::move(one));
  }
  return all;
}

void scale_to_capacity(std::vector<Discharge>& discharges, double capacity_ah, double floor_v) {
  constexpr double uncertain_min = 0.01;
  constexpr double near_v = 0.1;
  for (Discharge& one : discharges) {
    const double own_ah = *std::ranges::max_element(one.used_ah);
    const bool is_rough = one.uncertain > uncertain_min && std::fabs(own_ah / capacity_ah - 1.0) <= one.uncertain;
    if (!is_rough || lowest_under_load_v(one) > floor_v + near_v) continue;
    one.scale = capacity_ah / own_ah;
    one.uncertain = 0.0;
    for (double& used_ah : one.used_ah) used_ah *= one.scale;
  }
}

std::vector<Log> split_at_charges(const Log& log, double full_v) {
  const std::vector<Discharge> discharges = discharges_from_full(log, full_v);
  if (discharges.size() < 2) return {log};
  std::vector<Log> all;
  all.reserve(discharges.size());
  for (const Discharge& one : discharges) {
    // From the charge's last sample on, which shows that the battery is full.
    std::size_t from = one.first;
    while (from > 0 && log.current_a[from] >= 0.0) --from;
    Log part{log.name + ", discharge " + std::to_string(all.size() + 1),
             {},
             {},
             {},
             {},
             log.origin,
             {},
             {},
             log.diagnostics};
    const auto copy = [&](const auto& column, auto& to) {
      if (column.size() == log.time_s.size())
        to.assign(column.begin() + static_cast<std::ptrdiff_t>(from),
                  column.begin() + static_cast<std::ptrdiff_t>(one.last));
    };
    copy(log.time_s, part.time_s);
    copy(log.voltage_v, part.voltage_v);
    copy(log.current_a, part.current_a);
    copy(log.temperature_c, part.temperature_c);
    copy(log.line, part.line);
    copy(log.counted_ah, part.counted_ah);
    all.push_back(std::move(part));
  }
  return all;
}

double highest_voltage_v(const std::vector<Log>& logs) {
  double volt = 0.0;
  for (const Log& log : logs) volt = std::max(volt, highest_of(log));
  return volt;
}

double charge_moved_ah(const Log& log) {
  double out_as = 0.0;
  double least_as = 0.0;
  double most_as = 0.0;
  for (std::size_t i = 1; i < log.time_s.size(); ++i) {
    out_as += log.current_a[i] * (log.time_s[i] - log.time_s[i - 1]);
    least_as = std::min(least_as, out_as);
    most_as = std::max(most_as, out_as);
  }
  return (most_as - least_as) / 3600.0;
}

double lowest_under_load_v(const Discharge& discharge) {
  double volt = std::numeric_limits<double>::infinity();
  for (std::size_t i = discharge.first; i < discharge.last; ++i)
    if (discharge.log->current_a[i] > 0.0) volt = std::min(volt, discharge.log->voltage_v[i]);
  return volt;
}

double load_on_s(const Discharge& discharge) {
  const std::vector<double>& time_s = discharge.log->time_s;
  const std::size_t first = discharge.first;
  const double usual_s = first + 1 < time_s.size() ? time_s[first + 1] - time_s[first] : 0.0;
  if (first == 0) return std::max(std::min(0.0, time_s[0]), time_s[0] - usual_s);
  // Rests are logged less often than loads, and the last sample of a rest may be long before the load.
  return std::max(time_s[first - 1], time_s[first] - usual_s);
}

double seconds_to_voltage(const Discharge& discharge, double voltage_v) {
  const Log& log = *discharge.log;
  const double start_s = load_on_s(discharge);
  for (std::size_t i = discharge.first; i < discharge.last; ++i) {
    if (log.voltage_v[i] > voltage_v) continue;
    if (i == discharge.first) return 0.0;
    const double ratio = (log.voltage_v[i - 1] - voltage_v) / (log.voltage_v[i - 1] - log.voltage_v[i]);
    return log.time_s[i - 1] + ratio * (log.time_s[i] - log.time_s[i - 1]) - start_s;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace cosiva::battery
