#include "cosiva/battery/pack.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/battery/cell_table.h"

namespace cosiva::battery {
namespace {

constexpr double seconds_per_hour = 3600.0;

/// e^x for x ≥ 0 as p⁴ with p the series of e^(x/4) to its fourth power. Its inverse is always in (0, 1], so a pair is
/// stable at any step, and e^-x is within 1e-9 for steps of a tenth of its time constant.
double growth_of(double x) {
  const double y = 0.25 * x;
  const double p = 1.0 + y * (1.0 + y * (0.5 + y * (1.0 / 6.0 + y * (1.0 / 24.0))));
  const double p2 = p * p;
  return p2 * p2;
}

/// Lognormal with mean 1 and this relative standard deviation: never negative.
double lognormal(Random& random, double relative_sd) {
  const double log_variance = det_log(1.0 + relative_sd * relative_sd);
  return det_exp(std::sqrt(log_variance) * random.gaussian() - 0.5 * log_variance);
}

}  // namespace

std::string_view to_string(PackEvent event) {
  switch (event) {
    case PackEvent::none: return "none";
    case PackEvent::brown_out: return "brown_out";
    case PackEvent::floor: return "floor";
    case PackEvent::empty: break;
  }
  return "empty";
}

Pack::Pack(std::shared_ptr<const CellTable> table, PackDesign design, PackHistory history, double temperature_c)
    : table_{std::move(table)}, design_{design}, history_{std::move(history)}, voltage_v_{0.0} {
  COSIVA_EXPECT(table_ != nullptr && design_.series > 0 && design_.parallel > 0 && design_.scale > 0.0);
  Random random{history_.seed, "battery/cells"};
  cells_.resize(std::size_t{design_.series} * design_.parallel);
  for (Cell& cell : cells_) {
    cell = {};
    cell.charge = 1.0;
    cell.temperature_c = temperature_c;
    // Both are always drawn, so that one cell's numbers do not depend on the others'.
    const double capacity_factor = lognormal(random, type().capacity_spread);
    const double resistance_factor = lognormal(random, type().resistance_spread);
    cell.new_capacity_ah = type().capacity_ah * design_.scale * (history_.spread ? capacity_factor : 1.0);
    cell.resistance_factor = (history_.spread ? resistance_factor : 1.0) / design_.scale;
  }
  age();
  voltage_v_ = open_circuit_v();
}

void Pack::age() {
  // No model applies to a cell that has lost nine tenths.
  fade_ = std::max(0.1, 1.0 - type().capacity_fade_per_cycle * history_.cycles);
  growth_ = 1.0 + type().resistance_growth_per_cycle * history_.cycles;
  kelvin_per_j_ = 1.0 / (type().heat_capacity_j_per_k * design_.scale);
  for (Cell& cell : cells_) cell.charge_per_as = 1.0 / (cell.new_capacity_ah * fade_ * seconds_per_hour);
}

void Pack::update() {
  COSIVA_EXPECT(cells_.size() == std::size_t{design_.series} * design_.parallel);
  source_v_ = 0.0;
  ohm_ = 0.0;
  for (std::size_t first = 0; first < cells_.size(); first += design_.parallel) {
    double conductance = 0.0;
    double short_a = 0.0;
    for (std::size_t i = first; i < first + design_.parallel; ++i) {
      Cell& cell = cells_[i];
      cell.row = table_->at(cell.charge);
      cell.heat_factor = table_->heat_factor(cell.temperature_c) * cell.resistance_factor * growth_;
      cell.source_v = cell.row.open_circuit_v - cell.fast_v - cell.slow_v;
      cell.siemens = 1.0 / (cell.row.series_ohm * cell.heat_factor);
      conductance += cell.siemens;
      short_a += cell.source_v * cell.siemens;
    }
    source_v_ += short_a / conductance;
    ohm_ += 1.0 / conductance;
  }
}

PackStep Pack::draw_power(double power_w, double ambient_c, double dt_s) {
  update();
  const double root_sq = source_v_ * source_v_ - 4.0 * ohm_ * power_w;
  if (root_sq < 0.0) return flow(0.0, ambient_c, dt_s, PackEvent::brown_out);
  // (e − √(e² − 4 R P)) / 2R loses its digits for small P; this form of the same root does not.
  return flow(2.0 * power_w / (source_v_ + std::sqrt(root_sq)), ambient_c, dt_s, PackEvent::none);
}

PackStep Pack::draw_current(double current_a, double ambient_c, double dt_s) {
  update();
  // Beyond e/R even a short circuit delivers no more.
  if (current_a * ohm_ > source_v_) return flow(0.0, ambient_c, dt_s, PackEvent::brown_out);
  return flow(current_a, ambient_c, dt_s, PackEvent::none);
}

PackStep Pack::flow(double current_a, double ambient_c, double dt_s, PackEvent event) {
  COSIVA_EXPECT(dt_s > 0.0);
  const bool is_empty = std::ranges::any_of(cells_, [](const Cell& cell) { return cell.charge <= 0.0; });
  if (is_empty && current_a > 0.0) {
    current_a = 0.0;
    event = PackEvent::empty;
  }
  current_a_ = current_a;
  voltage_v_ = 0.0;
  for (std::size_t first = 0; first < cells_.size(); first += design_.parallel) {
    double conductance = 0.0;
    double short_a = 0.0;
    for (std::size_t i = first; i < first + design_.parallel; ++i) {
      conductance += cells_[i].siemens;
      short_a += cells_[i].source_v * cells_[i].siemens;
    }
    const double group_v = (short_a - current_a) / conductance;
    voltage_v_ += group_v;
    for (std::size_t i = first; i < first + design_.parallel; ++i) {
      Cell& cell = cells_[i];
      event = std::max(event, advance(cell, (cell.source_v - group_v) * cell.siemens, group_v, ambient_c, dt_s));
    }
  }
  delivered_j_ += voltage_v_ * current_a * dt_s;
  delivered_ah_ += current_a * dt_s / seconds_per_hour;
  if (current_a > 0.0) discharged_since_full_ah_ += current_a * dt_s / seconds_per_hour;
  return {voltage_v_, current_a, event};
}

PackEvent Pack::advance(Cell& cell, double current_a, double voltage_v, double ambient_c, double dt_s) {
  const double kept = current_a < 0.0 ? type().coulombic_efficiency : 1.0;
  cell.charge = std::min(1.0, cell.charge - kept * current_a * dt_s * cell.charge_per_as);
  // One division for both: a division costs more than the rest of a line.
  const double fast_growth = growth_of(cell.row.fast_per_s * dt_s);
  const double slow_growth = growth_of(cell.row.slow_per_s * dt_s);
  const double both = 1.0 / (fast_growth * slow_growth);
  const double fast = both * slow_growth;
  const double slow = both * fast_growth;
  cell.fast_v = fast * cell.fast_v + (1.0 - fast) * cell.row.fast_ohm * cell.heat_factor * current_a;
  cell.slow_v = slow * cell.slow_v + (1.0 - slow) * cell.row.slow_ohm * cell.heat_factor * current_a;

  const double heat_w = current_a * (cell.row.open_circuit_v - voltage_v);
  const double loss_w = type().heat_loss_w_per_k * design_.scale * (cell.temperature_c - ambient_c);
  cell.temperature_c += (heat_w - loss_w) * dt_s * kelvin_per_j_;
  lost_j_ += heat_w * dt_s;

  if (cell.charge <= 0.0) {
    cell.charge = 0.0;
    return PackEvent::empty;
  }
  return voltage_v < type().voltage_floor_v ? PackEvent::floor : PackEvent::none;
}

void Pack::renew(double temperature_c) {
  history_.cycles += discharged_since_full_ah_ / (type().capacity_ah * design_.scale * design_.parallel);
  age();
  for (Cell& cell : cells_) cell.temperature_c = temperature_c;
  set_charge(1.0);
  discharged_since_full_ah_ = 0.0;
}

void Pack::set_charge(double charge) {
  for (Cell& cell : cells_) {
    cell.charge = std::clamp(charge, 0.0, 1.0);
    cell.fast_v = 0.0;
    cell.slow_v = 0.0;
  }
  current_a_ = 0.0;
  voltage_v_ = open_circuit_v();
}

double Pack::charge() const {
  double weakest = 1.0;
  for (std::size_t first = 0; first < cells_.size(); first += design_.parallel) {
    double left_ah = 0.0;
    double whole_ah = 0.0;
    for (std::size_t i = first; i < first + design_.parallel; ++i) {
      left_ah += cells_[i].charge * cells_[i].new_capacity_ah;
      whole_ah += cells_[i].new_capacity_ah;
    }
    weakest = std::min(weakest, left_ah / whole_ah);
  }
  return weakest;
}

double Pack::capacity_ah() const {
  double weakest = 0.0;
  for (std::size_t first = 0; first < cells_.size(); first += design_.parallel) {
    double whole_ah = 0.0;
    for (std::size_t i = first; i < first + design_.parallel; ++i) whole_ah += cells_[i].new_capacity_ah * fade_;
    weakest = first == 0 ? whole_ah : std::min(weakest, whole_ah);
  }
  return weakest;
}

double Pack::temperature_c() const {
  double hottest = cells_.front().temperature_c;
  for (const Cell& cell : cells_) hottest = std::max(hottest, cell.temperature_c);
  return hottest;
}

double Pack::open_circuit_v() const {
  double volt = 0.0;
  for (const Cell& cell : cells_) volt += table_->at(cell.charge).open_circuit_v;
  return volt / design_.parallel;
}

std::string Pack::state_json() const {
  JsonWriter json;
  json.begin_object().field("id", history_.id).field("cycles", history_.cycles).field("voltage_volt", voltage_v_);
  json.field("current_ampere", current_a_).field("delivered_joule", delivered_j_).field("lost_joule", lost_j_);
  json.field("delivered_ampere_hour", delivered_ah_);
  json.field("discharged_since_full_ampere_hour", discharged_since_full_ah_).key("cells").begin_array();
  for (const Cell& cell : cells_) {
    json.begin_array().value(cell.charge).value(cell.fast_v).value(cell.slow_v).value(cell.temperature_c).end_array();
  }
  return json.end_array().end_object().take();
}

Result<void> Pack::restore(std::string_view state_json) {
  const auto json = JsonValue::parse(state_json);
  if (!json) return fail("battery.state", json.error().message, "battery state");
  Pack other = *this;
  const auto number = [&](std::string_view key, double& value) {
    const auto found = json->number(key);
    if (found) value = *found;
    return found.has_value();
  };
  if (json->text("id") != history_.id) return fail("battery.state", "belongs to another battery", "battery state 'id'");
  if (!number("cycles", other.history_.cycles) || !number("voltage_volt", other.voltage_v_) ||
      !number("current_ampere", other.current_a_) || !number("delivered_joule", other.delivered_j_) ||
      !number("lost_joule", other.lost_j_) || !number("delivered_ampere_hour", other.delivered_ah_) ||
      !number("discharged_since_full_ampere_hour", other.discharged_since_full_ah_))
    return fail("battery.state", "a quantity is missing", "battery state");
  const JsonValue* cells = json->find("cells");
  if (cells == nullptr || cells->array() == nullptr || cells->array()->size() != cells_.size())
    return fail("battery.state", "has a different number of cells", "battery state 'cells'");
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const JsonValue::Array* row = (*cells->array())[i].array();
    if (row == nullptr || row->size() != 4)
      return fail("battery.state", "expected four numbers", "battery state 'cells'");
    double* const targets[] = {&other.cells_[i].charge, &other.cells_[i].fast_v, &other.cells_[i].slow_v,
                               &other.cells_[i].temperature_c};
    for (std::size_t k = 0; k < 4; ++k) {
      const double* value = (*row)[k].number();
      if (value == nullptr) return fail("battery.state", "expected four numbers", "battery state 'cells'");
      *targets[k] = *value;
    }
    if (!(other.cells_[i].charge >= 0.0 && other.cells_[i].charge <= 1.0))
      return fail("battery.state", "a charge is out of range", "battery state 'cells'");
  }
  other.age();
  *this = std::move(other);
  return {};
}

void Pack::fold(Digest& digest) const {
  digest.add(std::string_view{history_.id});
  digest.add(history_.cycles);
  digest.add(voltage_v_);
  digest.add(current_a_);
  for (const Cell& cell : cells_) {
    digest.add(cell.charge);
    digest.add(cell.fast_v);
    digest.add(cell.slow_v);
    digest.add(cell.temperature_c);
  }
}

}  // namespace cosiva::battery
