#include "cosiva/app/resources/battery_types.h"

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/battery/type_json.h"

namespace cosiva::app {

Result<battery::BatteryType> load_battery_type(const std::string& name_or_file) {
  if (!is_like_a_file(name_or_file)) {
    auto shipped = battery::shipped_type(name_or_file);
    if (shipped) return shipped;
    const std::string near = nearest_word(name_or_file, battery::shipped_types());
    Error error = shipped.error();
    if (!near.empty()) error.message += "; did you mean '" + near + "'?";
    return tl::unexpected(error);
  }
  auto text = adapters::read_file(name_or_file);
  if (!text) return tl::unexpected(text.error());
  return battery::read_type(*text, name_or_file);
}

Result<double> ratio_of_percent(double percent, const std::string& option) {
  if (percent > 0.0 && percent < 1.0)
    return fail("battery.percent",
                decimals(percent, 3) + " seems to be a fraction; give percent, such as " + decimals(100.0 * percent, 1),
                option);
  if (!(percent >= 0.0 && percent <= 100.0)) return fail("battery.percent", "give percent, from 0 to 100", option);
  return 0.01 * percent;
}

}  // namespace cosiva::app
