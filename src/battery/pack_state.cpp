#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/battery/pack.h"

namespace cosiva::battery {

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
  if (json->text("id") != history_.id) return fail("battery.state", "is another battery's", "battery state 'id'");
  if (!number("cycles", other.history_.cycles) || !number("voltage_volt", other.voltage_v_) ||
      !number("current_ampere", other.current_a_) || !number("delivered_joule", other.delivered_j_) ||
      !number("lost_joule", other.lost_j_) || !number("delivered_ampere_hour", other.delivered_ah_) ||
      !number("discharged_since_full_ampere_hour", other.discharged_since_full_ah_))
    return fail("battery.state", "a quantity is missing", "battery state");
  const JsonValue* cells = json->find("cells");
  if (cells == nullptr || cells->array() == nullptr || cells->array()->size() != cells_.size())
    return fail("battery.state", "has another number of cells", "battery state 'cells'");
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
