#include "cosiva/battery/fit/log_columns.h"

#include <algorithm>
#include <span>
#include <utility>

#include "cosiva/base/text.h"

namespace cosiva::battery {
namespace {

/// Around fields, and quotes.
constexpr std::string_view blanks = " \t\r\"";

/// A quantity: its machine-readable name, its label, its stem without a unit, and testers' names for it.
struct Quantity {
  std::string_view name;
  std::string_view label;
  std::string_view stem;
  std::array<std::string_view, 4> others;
};
constexpr std::array quantities{
    Quantity{"test_time_second", "Test Time / s", "test_time", {"testtime", "totaltime", "time", "elapsedtime"}},
    Quantity{"voltage_volt", "Voltage / V", "voltage", {"voltage", "cellvoltage", "ecell", "u"}},
    Quantity{"current_ampere", "Current / A", "current", {"current", "cellcurrent", "i", "imeasured"}}};
constexpr std::array temperatures{Quantity{"temperature_t1_celsius",
                                           "Temperature T1 / degC",
                                           "temperature_t1",
                                           {"temperaturet1", "temperature", "celltemperature", "auxtemperature1"}},
                                  Quantity{"ambient_temperature_celsius",
                                           "Ambient Temperature / degC",
                                           "ambient",
                                           {"ambienttemperature", "chambertemperature", "", ""}}};
constexpr Quantity discharged{"discharging_capacity_ah",
                              "Discharging Capacity / Ah",
                              "discharging_capacity",
                              {"dischargingcapacity", "dischargecapacity", "", ""}};
constexpr Quantity charged{"charging_capacity_ah",
                           "Charging Capacity / Ah",
                           "charging_capacity",
                           {"chargingcapacity", "chargecapacity", "", ""}};
constexpr std::array steps{"step_index", "step_count", "step_id", "stepindex", "stepid", "step", "stepnumber"};

struct Unit {
  std::string_view name;
  double scale;
  double offset;
};
constexpr std::array seconds{Unit{"s", 1.0, 0.0},    Unit{"sec", 1.0, 0.0},    Unit{"second", 1.0, 0.0},
                             Unit{"ms", 1e-3, 0.0},  Unit{"min", 60.0, 0.0},   Unit{"minute", 60.0, 0.0},
                             Unit{"h", 3600.0, 0.0}, Unit{"hour", 3600.0, 0.0}};
constexpr std::array volts{Unit{"v", 1.0, 0.0}, Unit{"volt", 1.0, 0.0}, Unit{"mv", 1e-3, 0.0}};
constexpr std::array amperes{Unit{"a", 1.0, 0.0}, Unit{"amp", 1.0, 0.0}, Unit{"ampere", 1.0, 0.0},
                             Unit{"ma", 1e-3, 0.0}};
constexpr std::array degrees{Unit{"c", 1.0, 0.0}, Unit{"degc", 1.0, 0.0}, Unit{"celsius", 1.0, 0.0},
                             Unit{"\xC2\xB0"
                                  "c",
                                  1.0, 0.0},
                             Unit{"k", 1.0, -273.15}};
constexpr std::array ampere_hours{Unit{"ah", 1.0, 0.0}, Unit{"mah", 1e-3, 0.0}};

/// "Test_Time(s)", "Test Time / s" and "Test Time [s]" are "testtime" in "s".
struct Name {
  std::string quantity;
  std::string unit;
};
Name taken_apart(std::string_view written) {
  const std::size_t fiducial = written.find_last_of("([/");
  Name name;
  const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  for (const char c : written.substr(0, fiducial))
    if (c != ' ' && c != '_' && c != '-' && c != '.') name.quantity += small(c);
  if (fiducial == std::string_view::npos) return name;
  for (const char c : written.substr(fiducial + 1))
    if (c != ' ' && c != ')' && c != ']') name.unit += small(c);
  return name;
}

/// The format's own name first, then testers' names in the order of the list.
std::optional<ColumnUnit> found(const std::vector<std::string>& header, const Quantity& quantity,
                                std::span<const Unit> units) {
  for (std::size_t i = 0; i < header.size(); ++i)
    if (header[i] == quantity.name || header[i] == quantity.label) return ColumnUnit{i};
  for (const std::string_view other : quantity.others) {
    if (other.empty()) continue;
    for (std::size_t i = 0; i < header.size(); ++i) {
      const Name name = taken_apart(header[i]);
      if (name.quantity != other || name.unit.empty()) continue;
      const auto unit = std::ranges::find(units, std::string_view{name.unit}, &Unit::name);
      if (unit != units.end()) return ColumnUnit{i, unit->scale, unit->offset};
    }
  }
  return std::nullopt;
}

std::span<const Unit> units_of(std::size_t k) {
  if (k == 0) return seconds;
  if (k == 1) return volts;
  return amperes;
}

/// The error for a missing column; `place` is the header's.
tl::unexpected<Error> missing(const std::vector<std::string>& header, const Quantity& quantity,
                              const std::string& location) {
  const std::string wanted{quantity.name};
  for (const std::string& name : header) {
    const std::string apart = taken_apart(name).quantity;
    if (name.starts_with(quantity.stem) ||
        std::ranges::find(quantity.others, std::string_view{apart}) != quantity.others.end()) {
      std::string text = "column '" + name;
      text.append("' lacks its unit or has another: expected '").append(wanted).append("'");
      return fail("log.column", std::move(text), location);
    }
  }
  const auto is_number = [](const std::string& field) { return number_of<double>(field).has_value(); };
  if (std::ranges::count_if(header, is_number) >= 3)
    return fail("log.column",
                "column '" + wanted +
                    "' is missing: this line holds numbers, not names. Add a line with the columns' " +
                    "names before it",
                location);
  constexpr std::size_t shown_max = 12;
  std::string there;
  for (std::size_t i = 0; i < std::min(header.size(), shown_max); ++i) there += (i == 0 ? "" : ", ") + header[i];
  if (header.size() > shown_max) there += " and " + std::to_string(header.size() - shown_max) + " more";
  return fail("log.column", "column '" + wanted + "' is missing; there are " + there, location);
}

/// The most frequent separator; a comma if there is none.
char separator_of(std::string_view line) {
  char best = ',';
  for (const char c : {';', '\t'})
    if (std::ranges::count(line, c) > std::ranges::count(line, best)) best = c;
  return best;
}

}  // namespace

std::vector<std::string_view> cut_fields(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  bool is_quoted = false;
  std::size_t from = 0;
  // A tab that separates fields is not trimmed.
  const std::string_view around = separator == '\t' ? " \r\"" : blanks;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') is_quoted = !is_quoted;
    if (line[i] != separator || is_quoted) continue;
    fields.push_back(trimmed(line.substr(from, i - from), around));
    from = i + 1;
  }
  fields.push_back(trimmed(line.substr(from), around));
  return fields;
}

std::optional<double> field_number(std::string_view field, char separator) {
  if (field.starts_with('+')) field.remove_prefix(1);
  if (separator == ',' || std::ranges::count(field, ',') != 1 || field.find('.') != std::string_view::npos)
    return number_of<double>(field);
  std::string with_point{field};
  std::ranges::replace(with_point, ',', '.');
  return number_of<double>(with_point);
}

std::string field_hint(std::string_view field) {
  if (field.find(':') != std::string_view::npos) return ": seconds are wanted, not hours:minutes:seconds or a date";
  if (field.find(',') != std::string_view::npos) return ": write it without separators between thousands";
  return {};
}

Result<LogColumns> read_columns(std::string_view line, const std::string& location) {
  LogColumns columns;
  columns.separator = separator_of(line);
  for (const std::string_view name : cut_fields(line, columns.separator)) columns.names.emplace_back(name);
  for (const char c : line)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r')
      return fail("log.column", "is not a text table", location);
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const auto at = found(columns.names, quantities[k], units_of(k));
    if (!at) return missing(columns.names, quantities[k], location);
    columns.columns[k] = *at;
    const std::string& name = columns.names[at->at];
    if (name != quantities[k].name && name != quantities[k].label)
      columns.diagnostic +=
          (columns.diagnostic.empty() ? "" : ", ") + ("'" + name + "' as ") + std::string(quantities[k].name);
  }
  for (const Quantity& temperature : temperatures)
    if (!columns.temperature) columns.temperature = found(columns.names, temperature, degrees);
  columns.discharged = found(columns.names, discharged, ampere_hours);
  columns.charged = found(columns.names, charged, ampere_hours);
  for (const std::string_view step : steps) {
    for (std::size_t i = 0; i < columns.names.size() && !columns.step; ++i)
      if (columns.names[i] == step || taken_apart(columns.names[i]).quantity == step) columns.step = i;
  }
  return columns;
}

}  // namespace cosiva::battery
