#include "cosiva/experiments/battery/autonomy_output.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "cosiva/base/json_writer.h"

namespace cosiva::experiments {
namespace {

void write(JsonWriter& json, std::string_view name, const std::optional<statistics::Interval>& interval) {
  json.key(name);
  if (!interval) {
    json.null();
    return;
  }
  json.begin_array().value(interval->low).value(interval->high).end_array();
}

void write(JsonWriter& json, std::string_view name, const std::optional<double>& value) {
  json.key(name);
  if (value)
    json.value(*value);
  else
    json.null();
}

void write_survival(JsonWriter& json, const statistics::Survival& survival) {
  json.key("survival").begin_object().field("restricted_mean_s", survival.restricted_mean);
  json.field("restricted_to_s", survival.restricted_to);
  write(json, "b10_s", survival.when_ended(0.1));
  write(json, "median_s", survival.when_ended(0.5));
  write(json, "band95_before", survival.band_before);
  json.key("steps").begin_array();
  for (const statistics::SurvivalStep& step : survival.steps) {
    json.begin_object().field("at_s", step.at).field("ratio", step.ratio);
    write(json, "band95", step.band);
    json.end_object();
  }
  json.end_array().end_object();
}

void write_factor(JsonWriter& json, std::string_view name, const statistics::Factor& factor) {
  json.key(name).begin_object().field("ratio", factor.ratio).field("sd_s", factor.sd).field("f", factor.f);
  json.field("p", factor.p).end_object();
}

void write(JsonWriter& json, std::string_view name, const std::optional<statistics::Trend>& trend) {
  json.key(name);
  if (!trend) {
    json.null();
    return;
  }
  json.begin_object().field("slope_s", trend->slope).field("p", trend->p).field("r_squared", trend->r_squared);
  json.field("at_run_1_s", trend->at_first);
  write(json, "at_run_1_ci95", trend->at_first_interval);
  json.end_object();
}

void write_effects(JsonWriter& json, const AutonomyMetrics& metrics) {
  write(json, "slope_per_run", metrics.trend);
  json.key("variance");
  if (const auto& crossed = metrics.crossed) {
    json.begin_object().field("confounded", crossed->confounded);
    write_factor(json, "battery", crossed->unit);
    write_factor(json, "vehicle", crossed->carrier);
    write_factor(json, "run", crossed->run);
    json.key("noise").begin_object().field("ratio", crossed->noise_ratio).field("sd_s", crossed->noise_sd).end_object();
    json.end_object();
  } else {
    json.null();
  }
  json.key("vehicle_effect");
  if (const auto& effect = metrics.vehicles) {
    json.begin_object().field("f", effect->variance.f).field("p", effect->variance.p).key("vehicles").begin_array();
    for (const VehicleEffect::Group& one : effect->groups) {
      json.begin_object().field("vehicle", one.vehicle).field("batteries", one.batteries);
      json.field("mean_s", one.mean_s).field("sd_s", one.sd_s).end_object();
    }
    json.end_array().end_object();
  } else {
    json.null();
  }
}

/// Members that a run's own record and its battery's record have in common.
void write_metadata(JsonWriter& json, const BatteryRun& record, std::span<const TrueEnd> ground_truth) {
  json.field("vehicle", vehicle_name(record));
  json.field("started", to_iso8601(record.started)).field("stop", to_string(record.stop));
  json.field("paused_s", record.paused_s).field("charge_ah", record.charge_ah);
  json.field("energy_wh", record.energy_wh).field("distance_m", record.distance_m).field("cycles", record.tag.cycles);
  json.field("rest_s", record.tag.rest_s).field("temperature_start_c", record.tag.temperature_c);
  json.field("temperature_end_c", record.temperature_end_c).field("charge_start", record.tag.charge);
  json.field("charge_end", record.charge_end).field("charge_end_sd", record.charge_end_sd);
  json.field("voltage_end_v", record.voltage_end_v);
  for (const TrueEnd& end : ground_truth)
    if (end.run == record.run && end.vehicle == record.vehicle) json.field("true_charge_end", end.charge);
}

void write_run(JsonWriter& json, const BatteryRun& record, std::span<const TrueEnd> ground_truth) {
  json.begin_object().field("battery", record.battery + 1).field("id", record.tag.id).field("type", record.tag.type);
  json.field("run", record.run + 1).field("ended", record.ended()).field("autonomy_s", record.autonomy_s);
  write_metadata(json, record, ground_truth);
  json.end_object();
}

/// One record for each battery: the results of all its runs, and the metadata of the first run.
void write_battery(JsonWriter& json, const BatteryMetrics& metrics, std::span<const BatteryRun> records,
                   std::span<const TrueEnd> ground_truth) {
  const auto first = std::ranges::find(records, metrics.battery, &BatteryRun::battery);
  if (first == records.end()) return;  // its vehicle never came that far
  const bool ended = metrics.runs > metrics.failed;
  json.begin_object().field("battery", metrics.battery + 1).field("id", metrics.id).field("type", first->tag.type);
  json.field("runs", metrics.runs).field("failed", metrics.failed).field("ended", ended);
  json.field("autonomy_s", ended ? metrics.autonomy_s : metrics.lasted_at_least_s);
  json.field("lasted_at_least_s", metrics.lasted_at_least_s).field("is_outlier", metrics.is_outlier);
  json.field("robust_score", metrics.robust_score);
  write(json, "slope_per_run", metrics.trend);
  write_metadata(json, *first, ground_truth);
  json.end_object();
}

std::string short_text(double value, int digits) {
  std::array<char, 40> buffer{};
  const auto [end, error] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, digits);
  return {buffer.data(), error == std::errc{} ? end : buffer.data()};
}

std::string span_text(const statistics::Interval& interval) {
  return short_text(interval.low, 1) + " to " + short_text(interval.high, 1) + " s";
}

std::string survival_text(const AutonomyMetrics& metrics) {
  std::string text;
  const auto median = metrics.survival.when_ended(0.5);
  const auto b10 = metrics.survival.when_ended(0.1);
  if (median && b10 && metrics.batteries > 1)
    text += "\nhalf have ended after " + short_text(*median, 1) + " s, one in ten (B10) after " + short_text(*b10, 1) +
            " s (Kaplan and Meier)";
  if (metrics.failed > 0 && std::isfinite(metrics.mean_if_counted_s) && std::isfinite(metrics.mean_s))
    text += "\ncounted as ends, failures would make the mean " + short_text(metrics.mean_if_counted_s, 1) + " s (" +
            short_text(100.0 * (metrics.mean_if_counted_s / metrics.mean_s - 1.0), 1) + " %)";
  return text;
}

std::string outlier_text(const AutonomyMetrics& metrics) {
  std::string text;
  if (metrics.normality_p) text += "\nnormality (Anderson and Darling): p " + chance_text(*metrics.normality_p);
  for (const BatteryMetrics& one : metrics.each)
    if (one.is_outlier && metrics.grubbs)
      text += "\n" + one.id + " is an outlier (Grubbs), kept: " + short_text(metrics.grubbs->statistic, 3) + " > " +
              short_text(metrics.grubbs->critical, 3) + ", robust score " + short_text(one.robust_score, 1);
  return text;
}

std::string vehicles_text(const AutonomyMetrics& metrics) {
  const auto& effect = metrics.vehicles;
  if (!effect) return {};
  std::string text = "\nvehicles (or channels) of two batteries or more:";
  for (const VehicleEffect::Group& one : effect->groups)
    text += " " + one.vehicle + ": " + short_text(one.mean_s, 1) + " s, SD " + short_text(one.sd_s, 1) + " s of " +
            std::to_string(one.batteries) + ";";
  return text + " F " + short_text(effect->variance.f, 1) + " (p " + chance_text(effect->variance.p) + ")";
}

}  // namespace

std::string chance_text(double p) { return p < 1e-4 ? "< 0.0001" : short_text(p, 4); }

std::string to_json(const AutonomyMetrics& metrics, std::span<const BatteryRun> records,
                    std::span<const TrueEnd> ground_truth) {
  JsonWriter json;
  json.begin_object().key("autonomy_s").begin_object();
  const bool of_runs = metrics.runs_t.has_value();
  json.field("mean", metrics.mean_s).field("sd", of_runs ? metrics.runs_sd_s : metrics.sd_s);
  write(json, "ci95", of_runs ? metrics.runs_t : metrics.mean_t);
  json.field("of", of_runs ? "runs of one battery" : "batteries");
  write(json, "ci95_bca", metrics.mean_bca);
  json.field("method", metrics.method).field("at", metrics.at_s);
  json.field("mean_if_failures_counted", metrics.mean_if_counted_s);
  write(json, "sd_ci95", metrics.sd_interval);
  write(json, "tolerance_95_95_low", metrics.tolerance_low_s);
  json.field("smallest_covers", metrics.smallest_covers);
  write(json, "next_95", metrics.next);
  write(json, "normality_p", metrics.normality_p);
  json.end_object().field("n", metrics.batteries).field("runs", metrics.runs).field("failed", metrics.failed);
  json.field("cut_off", metrics.cut_off).key("outlier");
  if (metrics.grubbs) {
    json.begin_object().field("g", metrics.grubbs->statistic).field("critical", metrics.grubbs->critical);
    json.field("is_outlier", metrics.grubbs->is_outlier).end_object();
  } else {
    json.null();
  }
  write_survival(json, metrics.survival);
  write_effects(json, metrics);
  json.key("stopped_after");
  if (metrics.stopped_after)
    json.value(*metrics.stopped_after);
  else
    json.null();
  json.key("batteries").begin_array();
  for (const BatteryMetrics& one : metrics.each) write_battery(json, one, records, ground_truth);
  json.end_array().key("records").begin_array();
  for (const BatteryRun& record : records) write_run(json, record, ground_truth);
  return json.end_array().end_object().take();
}

std::string to_text(const AutonomyMetrics& metrics, std::span<const BatteryRun> records) {
  std::string text = std::to_string(metrics.batteries) + (metrics.batteries == 1 ? " battery, " : " batteries, ") +
                     std::to_string(records.size()) + (records.size() == 1 ? " run, " : " runs, ") +
                     std::to_string(metrics.failed) + " failed\n";
  for (const BatteryRun& record : records) {
    text += "  run " + std::to_string(record.run + 1) + ", " + record.tag.id + " on " + vehicle_name(record) + ": " +
            duration_text(record.autonomy_s) + " (" + std::string(to_string(record.stop)) + ")";
    if (record.charge_ah > 0.0)  // a table of durations has none
      text += ", " + short_text(record.charge_ah, 3) + " Ah, " + short_text(record.energy_wh, 2) + " Wh, " +
              short_text(record.distance_m, 0) + " m";
    text += "\n";
  }
  text += "AT " + duration_text(metrics.mean_s) + " (" + short_text(metrics.mean_s, 1) + " s, " + metrics.method + ")";
  if (metrics.mean_t) text += ", 95 % interval " + span_text(*metrics.mean_t);
  if (metrics.mean_bca) text += ", BCa " + span_text(*metrics.mean_bca);
  if (metrics.runs_t)
    text += "\nover this battery's runs: SD " + short_text(metrics.runs_sd_s, 1) + " s, 95 % interval of their mean " +
            span_text(*metrics.runs_t) + "; no statement about other batteries";
  if (metrics.sd_interval)
    text += "\nSD " + short_text(metrics.sd_s, 1) + " s, at most " + short_text(metrics.sd_interval->high, 1) + " s";
  if (metrics.tolerance_low_s)
    text +=
        "\n95 % of such batteries last " + duration_text(*metrics.tolerance_low_s) + " or longer, with 95 % confidence";
  if (metrics.next) text += "\nthe next one: " + span_text(*metrics.next);
  text += survival_text(metrics) + outlier_text(metrics);
  if (const auto& trend = metrics.trend)
    text += "\nslope " + short_text(trend->slope, 2) + " s per run (p " + chance_text(trend->p) + "), at run 1 " +
            short_text(trend->at_first, 1) + " s";
  text += vehicles_text(metrics);
  if (const auto& crossed = metrics.crossed) {
    if (crossed->confounded)
      text += "\neach battery stayed on its vehicle: battery and vehicle effects cannot be separated (--swap)";
    else
      text += "\nvariance: battery " + short_text(100.0 * crossed->unit.ratio, 0) + " %, vehicle " +
              short_text(100.0 * crossed->carrier.ratio, 0) + " %, run " + short_text(100.0 * crossed->run.ratio, 0) +
              " %, rest " + short_text(100.0 * crossed->noise_ratio, 0) + " %";
  }
  return text;
}

std::string to_csv(std::span<const BatteryRun> records) {
  std::string csv =
      "battery_id,run,vehicle,test_time_second,voltage_volt,current_ampere,temperature_t1_celsius,state_of_charge_"
      "percent,distance_meter\n";
  for (const BatteryRun& record : records) {
    for (const BatterySample& sample : record.curve) {
      csv += record.tag.id + "," + std::to_string(record.run + 1) + "," + vehicle_name(record) + "," +
             short_text(to_seconds(sample.at - record.started), 1) + "," + short_text(sample.voltage_v, 4) + "," +
             short_text(-sample.current_a, 4) + "," + short_text(sample.temperature_c, 2) + "," +
             short_text(100.0 * sample.charge, 3) + "," + short_text(sample.distance_m, 2) + "\n";
    }
  }
  return csv;
}

}  // namespace cosiva::experiments
