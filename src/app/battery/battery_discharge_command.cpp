#include "cosiva/app/battery/battery_discharge_command.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/battery_types.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/pack.h"
#include "cosiva/experiments/battery/analysis.h"

namespace cosiva::app {
namespace {

struct Load {
  double current_a;  ///< the load; where NaN, power_w is
  double power_w;    ///< the load where current_a is NaN
  [[nodiscard]] bool is_power() const { return std::isnan(current_a); }
};

struct Discharged {
  Load load;
  double lasted_s;
  double charge_ah;
  double energy_wh;
  double voltage_end_v;
  double temperature_end_c;
  std::string_view stop;  ///< floor, empty, brown-out, or time
};

constexpr double longest_s = 1e7;

/// Discharges a full and rested battery to the floor, whose crossing is interpolated between two steps. `csv` grows by
/// a line for each second.
Discharged discharge(const battery::BatteryType& type, const BatteryDischargeArguments& arguments, const Load& load,
                     double floor_v, std::string* csv) {
  const battery::PackDesign design{arguments.series, arguments.parallel, arguments.scale};
  battery::Pack pack{std::make_shared<battery::CellTable>(type), design, {"new", 1, false, 0.0}, arguments.ambient_c};
  Discharged found{load, 0.0, 0.0, 0.0, pack.voltage_v(), arguments.ambient_c, "time"};
  const double dt_s = arguments.step_s;
  double written_s = -1.0;
  while (found.lasted_s < longest_s) {
    const battery::PackStep step = load.is_power() ? pack.draw_power(load.power_w, arguments.ambient_c, dt_s)
                                                   : pack.draw_current(load.current_a, arguments.ambient_c, dt_s);
    const double before_v = found.voltage_end_v;
    const bool below = step.voltage_v <= floor_v;
    const double ratio = below && before_v > step.voltage_v
                             ? std::clamp((before_v - floor_v) / (before_v - step.voltage_v), 0.0, 1.0)
                             : 1.0;
    found.lasted_s += ratio * dt_s;
    found.charge_ah += ratio * step.current_a * dt_s / 3600.0;
    found.energy_wh += ratio * step.current_a * step.voltage_v * dt_s / 3600.0;
    found.voltage_end_v = step.voltage_v;
    found.temperature_end_c = pack.temperature_c();
    const bool out = step.event == battery::PackEvent::brown_out || step.event == battery::PackEvent::empty;
    if (csv != nullptr && (found.lasted_s - written_s >= 1.0 || below || out)) {
      written_s = found.lasted_s;
      *csv += decimals(found.lasted_s, 3) + "," + decimals(step.voltage_v, 5) + "," + decimals(-step.current_a, 5) +
              "," + decimals(found.temperature_end_c, 2) + "\n";
    }
    if (step.event == battery::PackEvent::brown_out)
      found.stop = "brown-out";
    else if (below)
      found.stop = "floor";
    else if (step.event == battery::PackEvent::empty)
      found.stop = "empty";
    if (below || out) break;
  }
  return found;
}

std::vector<Load> loads_of(const BatteryDischargeArguments& arguments, double capacity_ah) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<Load> loads;
  for (const double current_a : arguments.currents_a) loads.push_back({current_a, none});
  for (const double power_w : arguments.powers_w) loads.push_back({none, power_w});
  for (const double rate : arguments.rates) loads.push_back({rate * capacity_ah, none});
  if (loads.empty())
    for (const double rate : {0.2, 0.5, 1.0, 2.0}) loads.push_back({rate * capacity_ah, none});
  return loads;
}

std::string text_of(const Discharged& one, double capacity_ah) {
  const std::string load = one.load.is_power() ? decimals(one.load.power_w, 3) + " W"
                                               : decimals(one.load.current_a, 3) + " A (" +
                                                     decimals(one.load.current_a / capacity_ah, 2) + "C)";
  return "  " + load + ": " + decimals(one.lasted_s, 1) + " s, " + experiments::duration_text(one.lasted_s) + ", " +
         decimals(one.charge_ah, 4) + " Ah, " + decimals(one.energy_wh, 3) + " Wh, ends by " + std::string(one.stop) +
         " at " + decimals(one.temperature_end_c, 1) + " °C";
}

/// Peukert's exponent between the slowest and the fastest current: a derived value, never an input.
std::string peukert_text(const std::vector<Discharged>& all) {
  const Discharged* slow = nullptr;
  const Discharged* fast = nullptr;
  for (const Discharged& one : all) {
    if (one.load.is_power() || !(one.lasted_s > 0.0)) continue;
    if (slow == nullptr || one.load.current_a < slow->load.current_a) slow = &one;
    if (fast == nullptr || one.load.current_a > fast->load.current_a) fast = &one;
  }
  if (slow == nullptr || !(fast->load.current_a > slow->load.current_a)) return {};
  const double exponent =
      det_log(slow->lasted_s / fast->lasted_s) / det_log(fast->load.current_a / slow->load.current_a);
  return "\nPeukert's exponent between them " + decimals(exponent, 3);
}

}  // namespace

int run_battery_discharge(const BatteryDischargeArguments& arguments) {
  const auto type = load_battery_type(arguments.type);
  if (!type) return report_error(type.error());
  const double capacity_ah = type->capacity_ah * arguments.scale * arguments.parallel;
  const double floor_v = (arguments.floor_v > 0.0 ? arguments.floor_v : type->voltage_floor_v) * arguments.series;
  const std::vector<Load> loads = loads_of(arguments, capacity_ah);
  if (!arguments.csv_file.empty() && loads.size() != 1)
    return report_error(
        {"battery.discharge", "a log has one load; select it with --current, --power or --rate", "--csv"});
  std::string csv = "test_time_second,voltage_volt,current_ampere,temperature_t1_celsius\n";
  std::vector<Discharged> all;
  all.reserve(loads.size());
  for (const Load& load : loads)
    all.push_back(discharge(*type, arguments, load, floor_v, arguments.csv_file.empty() ? nullptr : &csv));
  if (!arguments.csv_file.empty()) {
    if (auto written = adapters::write_file(arguments.csv_file, csv); !written) return report_error(written.error());
    print_info("written to " + arguments.csv_file);
  }
  if (!arguments.json) {
    std::string text = type->name + ", " + decimals(capacity_ah, 3) + " Ah, from full to " + decimals(floor_v, 3) +
                       " V at " + decimals(arguments.ambient_c, 1) + " °C ambient temperature:";
    for (const Discharged& one : all) text += "\n" + text_of(one, capacity_ah);
    print(text + peukert_text(all));
    return exit_done;
  }
  JsonWriter json;
  json.begin_object().field("type", type->name).field("capacity_ah", capacity_ah).field("floor_v", floor_v);
  json.key("discharges").begin_array();
  for (const Discharged& one : all) {
    json.begin_object();
    if (one.load.is_power())
      json.field("power_w", one.load.power_w);
    else
      json.field("current_a", one.load.current_a);
    json.field("lasted_s", one.lasted_s).field("charge_ah", one.charge_ah).field("energy_wh", one.energy_wh);
    json.field("temperature_end_c", one.temperature_end_c).field("stop", one.stop).end_object();
  }
  print(json.end_array().end_object().text());
  return exit_done;
}

}  // namespace cosiva::app
