#include "cosiva/physical/plant/power_train.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/type_json.h"

namespace cosiva::physical {
namespace {

/// Two of the published cells of 850 mAh in series, of the same capacity as the vehicles' own.
constexpr battery::PackDesign usual_design{2, 1, 2.2 / 0.85};
constexpr double seed_max = 9007199254740992.0;

tl::unexpected<Error> bad(std::string message, std::string location) {
  return fail("plant.battery", std::move(message), "changeBattery '" + std::move(location) + "'");
}

Result<battery::BatteryType> read_type(const JsonValue& json) {
  const JsonValue* given = json.find("type");
  if (given == nullptr) return battery::shipped_type("lipo850");
  if (given->text() == nullptr) return bad("expected a shipped type's name, or a type's file as text", "type");
  if (given->text()->starts_with('{')) return battery::read_type(*given->text(), "changeBattery");
  return battery::shipped_type(*given->text());
}

}  // namespace

double CartModel::drive_energy_j(double distance_m, double speed_mps, double acceleration_mps2, double dt_s) const {
  const double friction_j = rolling_force_n * std::fabs(distance_m);
  const double speeding_up_j = mass_kg * acceleration_mps2 * std::fabs(speed_mps) * dt_s;
  return std::max(0.0, friction_j + speeding_up_j) / drive_efficiency;
}

double CartModel::manoeuvre_energy_j(double turned_rad, double traversed_m) const {
  const double rolled_m = std::fabs(traversed_m) + half_track_m * std::fabs(turned_rad);
  return rolling_force_n * rolled_m / drive_efficiency;
}

Result<BatteryChange> battery_change_from_json(const JsonValue& json) {
  if (json.object() == nullptr) return bad("expected an object", "");
  auto type = read_type(json);
  if (!type) return tl::unexpected(type.error());
  BatteryChange change;
  change.type = std::move(*type);
  change.design = {static_cast<std::uint32_t>(change.type.series_cells),
                   static_cast<std::uint32_t>(change.type.parallel_cells), 1.0};
  if (json.find("type") == nullptr) change.design = usual_design;
  const auto id = json.text("id");
  if (!id || id->empty() || id->size() > 64) return bad("give the battery a name of 1 to 64 bytes", "id");
  change.history.id = *id;
  change.history.spread = json.flag("spread").value_or(false);
  std::optional<Error> error;
  const auto number = [&](const char* name, double low, double high, double otherwise) {
    const JsonValue* given = json.find(name);
    if (given == nullptr) return otherwise;
    const double* value = given->number();
    if (value != nullptr && *value >= low && *value <= high) return *value;
    if (!error)
      error = bad("expected a number from " + std::to_string(low) + " to " + std::to_string(high), name).value();
    return otherwise;
  };
  change.history.seed = static_cast<std::uint64_t>(number("seed", 0.0, seed_max, 1.0));
  change.history.cycles = number("cycles", 0.0, 1e5, 0.0);
  change.temperature_c = number("temperature", -40.0, 85.0, CartModel{}.ambient_c);
  change.charge = number("charge", 0.0, 1.0, 1.0);
  change.design.scale = number("scale", 1e-4, 1e4, change.design.scale);
  change.design.series = static_cast<std::uint32_t>(number("series", 1.0, 100.0, change.design.series));
  change.design.parallel = static_cast<std::uint32_t>(number("parallel", 1.0, 100.0, change.design.parallel));
  if (error) return tl::unexpected(*error);
  if (const auto word = json.text("gauge")) {
    const auto method = battery::parse_method(*word);
    if (!method) return bad("it is counter, rest or kalman", "gauge");
    change.gauge = *method;
  }
  return change;
}

std::shared_ptr<const battery::CellTable> PowerTrain::usual_table() {
  return std::make_shared<battery::CellTable>(*battery::shipped_type("lipo850"));
}

PowerTrain::PowerTrain(const std::shared_ptr<const battery::CellTable>& table, Random random)
    : pack_{table, usual_design, {"own", 1, false, 0.0}, CartModel{}.ambient_c},
      monitor_{battery::MonitorErrors{}, random},
      gauge_{table, {battery::GaugeMethod::rest, usual_design, {}, 0.01}},
      measured_{monitor_.measure(pack_.voltage_v(), 0.0, pack_.temperature_c())} {}

void PowerTrain::change(const BatteryChange& change) {
  changed_ = change;
  const auto table = std::make_shared<battery::CellTable>(change.type);
  pack_ = battery::Pack{table, change.design, change.history, change.temperature_c};
  pack_.set_charge(change.charge);
  battery::GaugeOptions options{change.gauge, change.design, {}, change.type.capacity_spread};
  gauge_ = battery::Gauge{table, options};
  // The battery changer reports "full", or that the charge is unknown.
  if (change.charge < 0.999) gauge_.unknown();
  cut_off_ = false;
  measured_ = monitor_.measure(pack_.voltage_v(), 0.0, pack_.temperature_c());
}

void PowerTrain::draw(double energy_j, double dt_s) {
  load_w_ = cut_off_ ? 0.0 : load_factor_ * (cart_.idle_w + energy_j / dt_s);
  COSIVA_EXPECT(load_w_ >= 0.0);
  const battery::PackStep step = pack_.draw_power(load_w_, cart_.ambient_c, dt_s);
  if (load_w_ > 0.0 && step.event != battery::PackEvent::none) cut_off_ = true;
  measured_ = monitor_.measure(step.voltage_v, step.current_a, pack_.temperature_c());
  gauge_.see(measured_, dt_s);
}

PowerReadings PowerTrain::readings() const {
  const battery::GaugeReading reading = gauge_.reading();
  return {measured_.voltage_v, measured_.current_a, measured_.temperature_c, reading.charge, reading.charge_sd};
}

void PowerTrain::archive(Archive& archive) {
  archive(changed_, load_factor_, load_w_, cut_off_);
  const bool cut_off = cut_off_;
  if (archive.reads() && changed_) change(BatteryChange{*changed_});
  cut_off_ = cut_off;
  std::string pack = pack_.state_json();
  std::string gauge = gauge_.state_json();
  archive(pack, gauge);
  if (!archive.reads() || archive.failed()) return;
  for (const auto& restored : {pack_.restore(pack), gauge_.restore(gauge)})
    if (!restored) archive.fail(restored.error().message);
  measured_ = monitor_.measure(pack_.voltage_v(), pack_.current_a(), pack_.temperature_c());
}

}  // namespace cosiva::physical
