#include "cosiva/app/battery/battery_fit_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/battery/fit/discharge.h"
#include "cosiva/battery/fit/fit.h"
#include "cosiva/battery/fit/predict.h"
#include "cosiva/battery/type_json.h"

namespace cosiva::app {
namespace {

using battery::Log;

Result<std::vector<Log>> load_logs(const std::string& file) {
  auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  return battery::read_logs(*text, file);
}

bool holds_one(const std::string& name, const std::vector<std::string>& parts) {
  // "rate=1C" does not match "rate=0.1C" or "rate=1C2".
  return std::ranges::any_of(parts, [&](const std::string& part) {
    for (std::size_t at = name.find(part); at != std::string::npos; at = name.find(part, at + 1)) {
      const std::size_t end = at + part.size();
      if ((end == name.size() || name[end] == ',') && (at == 0 || name[at - 1] == ' ' || name[at - 1] == '='))
        return true;
    }
    return false;
  });
}

struct FitInput {
  std::vector<Log> fitted;
  std::vector<Log> foretold;
  double full_v{0.0};  ///< of a full battery; 0: derived from the logs
};

/// The logs of these files; where a discharge is selected, each discharge that begins full is a log of its own.
Result<std::vector<Log>> load_all(const std::vector<std::string>& files, bool each_discharge, double& full_v) {
  std::vector<Log> all;
  for (const std::string& file : files) {
    auto logs = load_logs(file);
    if (!logs) return tl::unexpected(logs.error());
    std::ranges::move(*logs, std::back_inserter(all));
  }
  full_v = std::max(full_v, battery::highest_voltage_v(all));
  if (!each_discharge) return all;
  std::vector<Log> parts;
  for (const Log& log : all) std::ranges::move(battery::split_at_charges(log, full_v), std::back_inserter(parts));
  return parts;
}

Result<FitInput> load_input(const BatteryFitArguments& arguments) {
  FitInput input;
  std::vector<std::string> series;
  std::vector<std::string> files;
  for (const std::string& given : arguments.predict) (std::filesystem::exists(given) ? files : series).push_back(given);
  const auto speaks_of_one = [](const std::string& part) { return part.starts_with("discharge "); };
  const bool each_discharge =
      std::ranges::any_of(series, speaks_of_one) || std::ranges::any_of(arguments.series, speaks_of_one);
  double full_v = 0.0;
  auto foretold = load_all(files, false, full_v);
  if (!foretold) return tl::unexpected(foretold.error());
  input.foretold = std::move(*foretold);
  full_v = 0.0;
  auto logs = load_all(arguments.files, each_discharge, full_v);
  if (!logs) return tl::unexpected(logs.error());
  if (each_discharge) input.full_v = full_v;  // the charges that show it are in none of the parts
  std::vector<bool> found(series.size(), false);
  for (Log& log : *logs) {
    for (std::size_t i = 0; i < series.size(); ++i) found[i] = found[i] || holds_one(log.name, {series[i]});
    if (holds_one(log.name, series))
      input.foretold.push_back(std::move(log));
    else if (arguments.series.empty() || holds_one(log.name, arguments.series))
      input.fitted.push_back(std::move(log));
  }
  for (std::size_t i = 0; i < series.size(); ++i)
    if (!found[i]) return fail("fit.predict", "is neither a file nor a series of the logs", series[i]);
  if (input.fitted.empty()) return fail("fit.full", "no series is left to be fitted", arguments.files.front());
  return input;
}

/// Diagnostics of the predictions that the fit's own diagnostics do not contain.
void record_foretold(const FitInput& input, const std::vector<battery::Residual>& foretold, battery::Fit& fit) {
  const auto record = [&](std::string text) {
    if (std::ranges::find(fit.diagnostics, text) == fit.diagnostics.end()) fit.diagnostics.push_back(std::move(text));
  };
  for (const Log& log : input.foretold)
    for (const std::string& text : log.diagnostics) record(text);
  constexpr double far = 1.5;
  double most_a = 0.0;
  for (const battery::Residual& one : foretold) most_a = std::max(most_a, one.current_a);
  if (most_a > far * fit.largest_a)
    record("predicted at " + decimals(most_a / fit.largest_a, 1) +
           " times the largest current that was fitted: near empty a battery may give less than predicted; fit a "
           "faster log");
}

std::string residual_text(const battery::Residual& residual) {
  std::string text = "  " + residual.log + ": " + std::to_string(residual.samples) + " samples, " +
                     decimals(residual.current_a, 2) + " A, off by " + decimals(1e3 * residual.rms_v, 2) +
                     " mV RMS, at most " + decimals(1e3 * residual.worst_v, 1) + " mV at " +
                     decimals(100.0 * residual.worst_at_charge, 1) + " %";
  if (std::isfinite(residual.measured_s) && std::isfinite(residual.predicted_s))
    text += "; to " + decimals(residual.floor_v, 3) + " V " + decimals(residual.measured_s, 1) + " s measured, " +
            decimals(residual.predicted_s, 1) + " s predicted (" +
            decimals(100.0 * (residual.predicted_s / residual.measured_s - 1.0), 2) + " %)";
  constexpr double is_significant = 0.01;
  if (residual.uncertain > is_significant)
    text += "; " + decimals(100.0 * residual.uncertain, 1) + " % of its charge is not resolved by its samples";
  return text + "\n";
}

void write_residuals(JsonWriter& json, std::string_view name, const std::vector<battery::Residual>& residuals) {
  json.key(name).begin_array();
  for (const battery::Residual& one : residuals) {
    json.begin_object().field("log", one.log).field("samples", one.samples).field("current_a", one.current_a);
    json.field("rms_v", one.rms_v).field("worst_v", one.worst_v).field("worst_at_charge", one.worst_at_charge);
    json.field("measured_s", one.measured_s).field("predicted_s", one.predicted_s).field("floor_v", one.floor_v);
    json.field("began_s", one.began_s).field("charge_uncertain_percent", 100.0 * one.uncertain).end_object();
  }
  json.end_array();
}

}  // namespace

int run_battery_fit(const BatteryFitArguments& arguments) {
  const auto input = load_input(arguments);
  if (!input) return report_error(input.error());
  if (!arguments.out_file.empty() && arguments.licence.empty())
    return report_error({"fit.licence", "a type's file must state the licence of its data", "--licence"});
  battery::FitOptions options;
  options.name = arguments.name;
  options.licence = arguments.licence.empty() ? "not given" : arguments.licence;
  options.source = arguments.source;
  for (const std::string& file : arguments.files)
    if (arguments.source.empty())
      options.source += (options.source.empty() ? "fit of " : ", ") + std::filesystem::path{file}.filename().string();
  options.capacity_ah = arguments.capacity_ah;
  options.floor_v = arguments.floor_v;
  options.full_v = input->full_v;
  auto fit = battery::fit_type(input->fitted, options);
  if (!fit) return report_error(fit.error());
  std::vector<battery::Residual> foretold;
  for (const Log& log : input->foretold) {
    auto own = battery::predict(fit->type, {log});
    if (own.empty())
      return report_error(
          {"fit.full", "no discharge begins full, at " + decimals(fit->type.voltage_full_v, 2) + " V or a little below",
           log.name});
    std::ranges::move(own, std::back_inserter(foretold));
  }
  record_foretold(*input, foretold, *fit);
  if (!arguments.out_file.empty()) {
    // Only a file that can be read again is written.
    const std::string file = battery::to_json(fit->type);
    if (const auto good = battery::read_type(file, arguments.out_file); !good) return report_error(good.error());
    if (auto written = adapters::write_file(arguments.out_file, file); !written) return report_error(written.error());
    print_info("written to " + arguments.out_file);
  }
  if (arguments.json) {
    JsonWriter json;
    json.begin_object()
        .field("name", fit->type.name)
        .field("capacity_ah", fit->type.capacity_ah)
        .field("rms_v", fit->rms_v)
        .field("charge_uncertain_percent", 100.0 * fit->charge_uncertain);
    json.field("fast_s", fit->fast_s).field("slow_s", fit->slow_s).field("floor_v", fit->type.voltage_floor_v);
    write_residuals(json, "residuals", fit->residuals);
    write_residuals(json, "predictions", foretold);
    json.key("diagnostics").begin_array();
    for (const std::string& diagnostic : fit->diagnostics) json.value(diagnostic);
    json.end_array().key("type").raw(battery::to_json(fit->type)).end_object();
    print(json.text());
    return exit_done;
  }
  std::string text = fit->type.name + ": " + decimals(fit->type.capacity_ah, 3) + " Ah, time constants " +
                     decimals(fit->fast_s, 0) + " s and " + decimals(fit->slow_s, 0) + " s, residual " +
                     decimals(1e3 * fit->rms_v, 2) + " mV RMS\nfitted:\n";
  for (const auto& residual : fit->residuals) text += residual_text(residual);
  if (!foretold.empty()) text += "foretold:\n";
  for (const auto& residual : foretold) text += residual_text(residual);
  for (const std::string& diagnostic : fit->diagnostics) text += "note: " + diagnostic + "\n";
  text.pop_back();
  print(text);
  return exit_done;
}

}  // namespace cosiva::app
