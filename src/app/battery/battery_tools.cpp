// `cosiva battery fit`, `plan`, `compare` and `check`.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/app/battery/battery_arguments.h"
#include "cosiva/app/cli/words.h"
#include "cosiva/app/resources/battery_types.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/battery/fit/fit.h"
#include "cosiva/experiments/statistics/effects.h"
#include "cosiva/experiments/statistics/tolerance.h"

namespace cosiva::app {
namespace {

using battery::Log;

Result<std::vector<Log>> load_logs(const std::string& file) {
  auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  return battery::read_logs(*text, file);
}

bool holds_one(const std::string& name, const std::vector<std::string>& parts) {
  // "rate=1C" is not meant to find "rate=0.1C", nor "rate=1C2".
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
  double full_v{0.0};  ///< of a full battery; 0: the logs tell
};

/// The logs of these files; each discharge that begins full as one of its own where a discharge is spoken of.
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
  if (each_discharge) input.full_v = full_v;  // the charges that say so are in none of the parts
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

/// What is worth saying of what was foretold beyond the fit's own notes.
void note_foretold(const FitInput& input, const std::vector<battery::Residual>& foretold, battery::Fit& fit) {
  const auto note = [&](std::string text) {
    if (std::ranges::find(fit.notes, text) == fit.notes.end()) fit.notes.push_back(std::move(text));
  };
  for (const Log& log : input.foretold)
    for (const std::string& text : log.notes) note(text);
  constexpr double far = 1.5;
  double most_a = 0.0;
  for (const battery::Residual& one : foretold) most_a = std::max(most_a, one.current_a);
  if (most_a > far * fit.largest_a)
    note("foretold at " + decimals(most_a / fit.largest_a, 1) +
         " times the largest current that was fitted: near empty a battery may give less than that tells; fit a "
         "faster log");
}

std::string residual_text(const battery::Residual& residual) {
  std::string text = "  " + residual.log + ": " + std::to_string(residual.samples) + " samples, " +
                     decimals(residual.current_a, 2) + " A, off by " + decimals(1e3 * residual.rms_v, 2) +
                     " mV RMS, at most " + decimals(1e3 * residual.worst_v, 1) + " mV at " +
                     decimals(100.0 * residual.worst_at_charge, 1) + " %";
  if (std::isfinite(residual.measured_s) && std::isfinite(residual.predicted_s))
    text += "; to " + decimals(residual.floor_v, 3) + " V " + decimals(residual.measured_s, 1) + " s measured, " +
            decimals(residual.predicted_s, 1) + " s foretold (" +
            decimals(100.0 * (residual.predicted_s / residual.measured_s - 1.0), 2) + " %)";
  constexpr double worth_saying = 0.01;
  if (residual.uncertain > worth_saying)
    text += "; its samples leave " + decimals(100.0 * residual.uncertain, 1) + " % of its charge open";
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

/// What a result's batteries lasted, each by the mean of its runs that ended.
Result<std::vector<double>> autonomies(const std::string& file) {
  auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  const auto json = JsonValue::parse(*text, 512U << 20U);
  if (!json) return fail("battery.result", json.error().message, file);
  const JsonValue* batteries = json->find("batteries");
  if (batteries == nullptr || batteries->array() == nullptr)
    return fail("battery.result", "is no result of a battery test: it has no 'batteries'", file);
  struct Own {
    double battery;
    double sum;
    double count;
  };
  std::vector<Own> all;
  for (const JsonValue& run : *batteries->array()) {
    const auto number = run.number("battery");
    const auto lasted = run.number("autonomy_s");
    if (!number || !lasted) return fail("battery.result", "a run lacks 'battery' or 'autonomy_s'", file);
    if (!run.flag("ended").value_or(true)) continue;
    auto own = std::ranges::find(all, *number, &Own::battery);
    if (own == all.end()) own = all.insert(own, {*number, 0.0, 0.0});
    own->sum += *lasted;
    own->count += 1.0;
  }
  std::vector<double> values;
  values.reserve(all.size());
  for (const Own& own : all) values.push_back(own.sum / own.count);
  return values;
}

}  // namespace

int run_battery_fit(const BatteryFitArguments& arguments) {
  const auto input = load_input(arguments);
  if (!input) return complain(input.error());
  if (!arguments.out_file.empty() && arguments.licence.empty())
    return complain({"fit.licence", "a type's file must say the licence of what it rests on", "--licence"});
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
  if (!fit) return complain(fit.error());
  std::vector<battery::Residual> foretold;
  for (const Log& log : input->foretold) {
    auto own = battery::predict(fit->type, {log});
    if (own.empty())
      return complain({"fit.full",
                       "no discharge begins full, at " + decimals(fit->type.voltage_full_v, 2) + " V or a little below",
                       log.name});
    std::ranges::move(own, std::back_inserter(foretold));
  }
  note_foretold(*input, foretold, *fit);
  if (!arguments.out_file.empty()) {
    // Nothing is written that could not be read again.
    const std::string file = battery::to_json(fit->type);
    if (const auto good = battery::read_type(file, arguments.out_file); !good) return complain(good.error());
    if (auto written = adapters::write_file(arguments.out_file, file); !written) return complain(written.error());
    say("written to " + arguments.out_file);
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
    json.key("notes").begin_array();
    for (const std::string& note : fit->notes) json.value(note);
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
  for (const std::string& note : fit->notes) text += "note: " + note + "\n";
  text.pop_back();
  print(text);
  return exit_done;
}

int run_battery_plan(const BatteryPlanArguments& arguments) {
  const std::size_t size = statistics::sample_size(0.01 * arguments.cv_percent, 0.01 * arguments.half_width_percent);
  std::size_t each = 0;
  if (arguments.difference_percent > 0.0) {
    const double effect = arguments.difference_percent / arguments.cv_percent;
    for (each = 2; each < 100'000 && statistics::power_of(effect, each, each) < 0.8;)
      each += std::max<std::size_t>(1, each / 50);
  }
  const auto square =
      arguments.aivs > 0 ? statistics::latin_square(arguments.aivs) : std::vector<std::vector<std::size_t>>{};
  if (arguments.json) {
    JsonWriter json;
    json.begin_object()
        .field("cv_percent", arguments.cv_percent)
        .field("half_width_percent", arguments.half_width_percent)
        .field("batteries", size);
    if (each > 0) json.field("difference_percent", arguments.difference_percent).field("batteries_of_each", each);
    json.key("square").begin_array();
    for (const auto& run : square) {
      json.begin_array();
      for (const std::size_t vehicle : run) json.value(vehicle + 1);
      json.end_array();
    }
    print(json.end_array().end_object().text());
    return exit_done;
  }
  std::string text = std::to_string(size) + " batteries for the mean to ± " +
                     decimals(arguments.half_width_percent, 2) + " %, at a standard deviation of " +
                     decimals(arguments.cv_percent, 2) + " %; of so few, " +
                     decimals(100.0 * statistics::share_above_smallest(size), 0) +
                     " % of all last longer than the shortest, with 95 % confidence";
  if (each > 0)
    text += "\n" + std::to_string(each) + " of each type to see a difference of " +
            decimals(arguments.difference_percent, 2) + " % with a chance of 80 %";
  for (std::size_t run = 0; run < square.size(); ++run) {
    text += "\nrun " + std::to_string(run + 1) + ":";
    for (std::size_t battery = 0; battery < square[run].size(); ++battery)
      text += "  battery " + std::to_string(battery + 1) + " on AIV" + std::to_string(square[run][battery] + 1);
  }
  print(text);
  return exit_done;
}

int run_battery_compare(const BatteryFilesArguments& arguments) {
  const auto first = autonomies(arguments.files[0]);
  if (!first) return complain(first.error());
  const auto second = autonomies(arguments.files[1]);
  if (!second) return complain(second.error());
  const auto found = statistics::compare(*first, *second);
  if (!found)
    return complain({"battery.compare", "needs two batteries of each that were seen to the end, and that differ", {}});
  if (arguments.json) {
    JsonWriter json;
    json.begin_object()
        .field("difference_s", found->difference)
        .key("ci95")
        .begin_array()
        .value(found->interval.low)
        .value(found->interval.high)
        .end_array();
    json.field("p", found->p)
        .field("effect", found->effect)
        .field("power", found->power)
        .field("batteries_of_each_for_80_percent", found->needed)
        .end_object();
    print(json.text());
    return exit_done;
  }
  print("the second lasts " + decimals(found->difference, 1) + " s longer, 95 % interval " +
        decimals(found->interval.low, 1) + " to " + decimals(found->interval.high, 1) + " s (Welch, p " +
        decimals(found->p, 4) + ")\neffect size " + decimals(found->effect, 2) +
        " standard deviations (Hedges), power " + decimals(100.0 * found->power, 0) + " %; " +
        std::to_string(found->needed) + " of each would see it with a chance of 80 %");
  return exit_done;
}

int run_battery_check(const BatteryFilesArguments& arguments) {
  JsonWriter json;
  json.begin_object().key("files").begin_array();
  std::string text;
  bool all_good = true;
  for (const std::string& file : arguments.files) {
    const auto type = load_battery_type(file);
    all_good = all_good && type;
    json.begin_object()
        .field("file", file)
        .field("good", type.has_value())
        .field("error", type ? std::string{} : to_string(type.error()))
        .end_object();
    text += (text.empty() ? "" : "\n") +
            (type ? file + ": good: " + type->name + ", " + decimals(type->capacity_ah, 2) + " Ah, " + type->licence
                  : to_string(type.error()));
  }
  json.end_array().end_object();
  print(arguments.json ? json.text() : text);
  return all_good ? exit_done : exit_bad_input;
}

}  // namespace cosiva::app
