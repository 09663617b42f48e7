#include "cosiva/app/battery/battery_compare_command.h"

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/statistics/effects.h"

namespace cosiva::app {
namespace {

/// The autonomy of each battery of a result, as the mean of its runs that ended.
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

int run_battery_compare(const BatteryFilesArguments& arguments) {
  const auto first = autonomies(arguments.files[0]);
  if (!first) return report_error(first.error());
  const auto second = autonomies(arguments.files[1]);
  if (!second) return report_error(second.error());
  const auto found = statistics::compare(*first, *second);
  if (!found)
    return report_error({"battery.compare", "needs two batteries of each that ran to the end, and that differ", {}});
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
        std::to_string(found->needed) + " of each would detect it with a chance of 80 %");
  return exit_done;
}

}  // namespace cosiva::app
