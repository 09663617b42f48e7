#include "cosiva/app/battery/battery_plan_command.h"

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/statistics/effects.h"
#include "cosiva/experiments/statistics/tolerance.h"

namespace cosiva::app {

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
                     decimals(100.0 * statistics::ratio_above_smallest(size), 0) +
                     " % of all last longer than the shortest, with 95 % confidence";
  if (each > 0)
    text += "\n" + std::to_string(each) + " of each type to detect a difference of " +
            decimals(arguments.difference_percent, 2) + " % with a chance of 80 %";
  for (std::size_t run = 0; run < square.size(); ++run) {
    text += "\nrun " + std::to_string(run + 1) + ":";
    for (std::size_t battery = 0; battery < square[run].size(); ++battery)
      text += "  battery " + std::to_string(battery + 1) + " on AIV" + std::to_string(square[run][battery] + 1);
  }
  print(text);
  return exit_done;
}

}  // namespace cosiva::app
