#include "cosiva/battery/type_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::battery {
namespace {

struct Text {
  std::string_view key;
  std::string BatteryType::*member;
  bool required;
};
constexpr std::array texts{Text{"name", &BatteryType::name, true},
                           Text{"description", &BatteryType::description, false},
                           Text{"source", &BatteryType::source, true}, Text{"licence", &BatteryType::licence, true},
                           Text{"chemistry", &BatteryType::chemistry, false}};

struct Number {
  std::string_view key;
  double BatteryType::*member;
  double min;
  double max;
  bool required;
  bool whole{false};
};
constexpr double tiny = 1e-9;  // for quantities that must be above zero
constexpr std::array numbers{
    Number{"capacity_ampere_hour", &BatteryType::capacity_ah, 1e-4, 1e4, true},
    Number{"coulombic_efficiency_fraction", &BatteryType::coulombic_efficiency, 0.5, 1.0, true},
    Number{"voltage_floor_volt", &BatteryType::voltage_floor_v, 0.1, 100.0, true},
    Number{"voltage_full_volt", &BatteryType::voltage_full_v, 0.1, 100.0, true},
    Number{"heat_capacity_joule_per_kelvin", &BatteryType::heat_capacity_j_per_k, 1e-2, 1e6, true},
    Number{"heat_loss_watt_per_kelvin", &BatteryType::heat_loss_w_per_k, 0.0, 1e3, true},
    Number{"activation_joule_per_mole", &BatteryType::activation_j_per_mol, 0.0, 1e5, true},
    Number{"reference_temperature_celsius", &BatteryType::reference_temperature_c, -40.0, 85.0, true},
    Number{"temperature_min_celsius", &BatteryType::temperature_min_c, -60.0, 100.0, true},
    Number{"temperature_max_celsius", &BatteryType::temperature_max_c, -60.0, 100.0, true},
    Number{"capacity_fade_fraction_per_cycle", &BatteryType::capacity_fade_per_cycle, 0.0, 0.1, true},
    Number{"resistance_growth_fraction_per_cycle", &BatteryType::resistance_growth_per_cycle, 0.0, 0.1, true},
    Number{"capacity_spread_fraction", &BatteryType::capacity_spread, 0.0, 0.5, true},
    Number{"resistance_spread_fraction", &BatteryType::resistance_spread, 0.0, 0.5, true},
    Number{"series_cells", &BatteryType::series_cells, 1.0, 1000.0, false, true},
    Number{"parallel_cells", &BatteryType::parallel_cells, 1.0, 1000.0, false, true}};

struct Table {
  std::string_view key;
  std::vector<double> BatteryType::*member;
  double min;
  double max;
};
constexpr std::array tables{Table{"charge_fraction", &BatteryType::charge, 0.0, 1.0},
                            Table{"open_circuit_volt", &BatteryType::open_circuit_v, 0.1, 100.0},
                            Table{"series_ohm", &BatteryType::series_ohm, tiny, 1e3},
                            Table{"fast_ohm", &BatteryType::fast_ohm, 0.0, 1e3},
                            Table{"slow_ohm", &BatteryType::slow_ohm, 0.0, 1e3},
                            Table{"fast_second", &BatteryType::fast_s, 1e-3, 1e7},
                            Table{"slow_second", &BatteryType::slow_s, 1e-3, 1e7}};
constexpr std::size_t rows_max = 10'000;

std::string readable(double number) {
  JsonWriter json;
  return json.value(number).take();
}

class Reader {
 public:
  Reader(const JsonValue& json, const std::string& origin) : json_{json}, origin_{origin} {}

  Result<BatteryType> read() {
    if (json_.object() == nullptr) return fail("battery.type", "expected a JSON object", origin_);
    if (json_.text("format") != type_format) record("format", "expected \"" + std::string(type_format) + "\"");
    know_all_keys();
    for (const Text& text : texts) read_text(text);
    for (const Number& number : numbers) read_number(number);
    for (const Table& table : tables) read_table(table);
    if (!error_) check();
    if (error_) return tl::unexpected(*error_);
    return type_;
  }

 private:
  void record(std::string_view key, std::string message) {
    if (!error_) error_ = Error{"battery.type", std::move(message), origin_ + ": '" + std::string(key) + "'"};
  }

  /// A quantity's name without its unit is the most frequent and most harmful fault of such a file.
  void know_all_keys() {
    std::vector<std::string_view> known{"format", "$schema"};
    for (const Text& text : texts) known.push_back(text.key);
    for (const Number& number : numbers) known.push_back(number.key);
    for (const Table& table : tables) known.push_back(table.key);
    for (std::size_t i = 0; i < json_.object()->size(); ++i) {
      const std::string& key = (*json_.object())[i].first;
      for (std::size_t j = 0; j < i; ++j)
        if ((*json_.object())[j].first == key) return record(key, "is given twice");
      if (std::ranges::find(known, key) != known.end()) continue;
      // "capacity", "capacity_mah" for "capacity_ampere_hour": the words before the unit are the same.
      const std::string stem = key.substr(0, key.rfind('_'));
      std::string meant;
      for (const std::string_view whole : known) {
        if (!key.empty() && (whole.starts_with(key + "_") || whole.starts_with(stem + "_")))
          meant += (meant.empty() ? "'" : " or '") + std::string(whole) + "'";
      }
      if (!meant.empty()) return record(key, "lacks its unit, or has another: expected " + meant);
      return record(key, "is no key of a battery type");
    }
  }

  void read_text(const Text& text) {
    const JsonValue* found = json_.find(text.key);
    if (found == nullptr) {
      if (text.required) record(text.key, "is missing");
      return;
    }
    if (found->text() == nullptr) return record(text.key, "expected a text");
    if (text.required && found->text()->find_first_not_of(" \t\n") == std::string::npos)
      return record(text.key, "must not be empty");
    type_.*text.member = *found->text();
  }

  void read_number(const Number& number) {
    const JsonValue* found = json_.find(number.key);
    if (found == nullptr) {
      if (number.required) record(number.key, "is missing");
      return;
    }
    if (found->number() == nullptr) return record(number.key, "expected a number");
    const double value = *found->number();
    if (!(value >= number.min && value <= number.max))
      return record(number.key, range_text(value, number.min, number.max));
    if (number.whole && value != std::floor(value)) return record(number.key, "expected a whole number");
    type_.*number.member = value;
  }

  static std::string range_text(double value, double min, double max) {
    std::string phrase = readable(value) + " is out of range: expected ";
    if (min == tiny) return phrase + "more than 0";
    return phrase + readable(min) + " to " + readable(max);
  }

  void read_table(const Table& table) {
    const JsonValue* found = json_.find(table.key);
    if (found == nullptr) return record(table.key, "is missing");
    if (found->array() == nullptr) return record(table.key, "expected a list of numbers, one for each charge");
    if (found->array()->size() > rows_max) return record(table.key, "has more than 10 000 rows");
    std::vector<double>& values = type_.*table.member;
    for (const JsonValue& item : *found->array()) {
      const std::string where = std::string(table.key) + "[" + std::to_string(values.size()) + "]";
      if (item.number() == nullptr) return record(where, "expected a number");
      const double value = *item.number();
      if (!(value >= table.min && value <= table.max)) {
        const bool percent = table.member == &BatteryType::charge && value > 1.0 && value <= 100.0;
        return record(where, range_text(value, table.min, table.max) + (percent ? "; a fraction, not percent" : ""));
      }
      values.push_back(value);
    }
  }

  void check() {
    const std::size_t rows = type_.charge.size();
    if (rows < 2 || type_.charge.front() != 0.0 || type_.charge.back() != 1.0)
      return record("charge_fraction", "must go from 0 to 1, in two rows at least");
    for (const Table& table : tables) {
      const std::size_t there = (type_.*table.member).size();
      if (there != rows)
        return record(table.key, "has " + std::to_string(there) + " rows, 'charge_fraction' " + std::to_string(rows));
    }
    check_growth("charge_fraction", type_.charge);
    check_growth("open_circuit_volt", type_.open_circuit_v);
    if (type_.voltage_floor_v >= type_.voltage_full_v)
      record("voltage_floor_volt", "must be below 'voltage_full_volt'");
    if (type_.temperature_min_c >= type_.temperature_max_c)
      record("temperature_min_celsius", "must be below 'temperature_max_celsius'");
    if (type_.series_cells * type_.parallel_cells > 10'000.0) record("series_cells", "a pack has at most 10 000 cells");
  }

  void check_growth(std::string_view key, std::span<const double> values) {
    for (std::size_t i = 1; i < values.size(); ++i) {
      if (values[i] > values[i - 1]) continue;
      return record(std::string(key) + "[" + std::to_string(i) + "]",
                    readable(values[i]) + " is not above the " + readable(values[i - 1]) + " before it");
    }
  }

  const JsonValue& json_;
  const std::string& origin_;
  BatteryType type_;
  std::optional<Error> error_;
};

}  // namespace

Result<BatteryType> read_type(std::string_view json, const std::string& origin) {
  const auto parsed = JsonValue::parse(json);
  if (!parsed) return fail("battery.type", parsed.error().message, origin);
  return Reader{*parsed, origin}.read();
}

std::string to_json(const BatteryType& type) {
  JsonWriter json{2};
  json.begin_object().field("format", type_format);
  for (const Text& text : texts) json.field(text.key, type.*text.member);
  for (const Number& number : numbers) json.field(number.key, type.*number.member);
  for (const Table& table : tables) {
    // One line each: a column of a table is read across.
    JsonWriter row;
    row.begin_array();
    for (const double value : type.*table.member) row.value(value);
    json.key(table.key).raw(row.end_array().take());
  }
  return json.end_object().take() + "\n";
}

}  // namespace cosiva::battery
