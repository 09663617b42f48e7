#include "cosiva/physical/plant/plant_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/physical/boards/line_tracker.h"

namespace cosiva::physical {
namespace {

constexpr std::uint32_t vehicles_max = 1000;

tl::unexpected<Error> bad(const std::string& field, const std::string& expected) {
  return fail("plant.options", field + " must be " + expected, "plant options");
}

/// Reads the members, keeps the default where one is missing, and stores the first invalid one.
class Reader {
 public:
  explicit Reader(const JsonValue& object) : object_{object} {}

  void number(const char* name, double& value, double max) {
    const JsonValue* member = object_.find(name);
    if (member == nullptr) return;
    const double* given = member->number();
    if (given == nullptr || !std::isfinite(*given) || *given < 0.0 || *given > max)
      record(name, "a number from 0 to " + std::to_string(max));
    else
      value = *given;
  }
  void milliseconds(const char* name, SimDuration& value) {
    double ms = to_milliseconds(value);
    number(name, ms, 10'000.0);
    value = SimDuration{static_cast<std::int64_t>(std::nearbyint(ms * 1e6))};
  }
  void flag(const char* name, bool& value) {
    const JsonValue* member = object_.find(name);
    if (member == nullptr) return;
    if (member->flag() == nullptr)
      record(name, "true or false");
    else
      value = *member->flag();
  }
  void count(const char* name, std::uint32_t& value, std::uint32_t max) {
    double number_given = value;
    number(name, number_given, max);
    if (number_given < 1.0 || number_given != std::floor(number_given))
      record(name, "a whole number from 1 to " + std::to_string(max));
    else
      value = static_cast<std::uint32_t>(number_given);
  }
  /// 64 bits do not fit a JSON number, so the value travels as text; a small plain number is accepted too.
  void seed(const char* name, std::uint64_t& value) {
    const JsonValue* member = object_.find(name);
    if (member == nullptr) return;
    constexpr double exact_max = 9007199254740992.0;
    if (const double* plain = member->number(); plain != nullptr && *plain >= 0.0 && *plain <= exact_max) {
      value = static_cast<std::uint64_t>(*plain);
      return;
    }
    const std::string* text = member->text();
    if (text == nullptr || text->empty() || text->size() > 20 ||
        text->find_first_not_of("0123456789") != std::string::npos)
      return record(name, "a whole number, as text when above 2^53");
    std::uint64_t sum = 0;
    for (const char digit : *text) {
      const auto d = static_cast<std::uint64_t>(digit - '0');
      if (sum > (std::numeric_limits<std::uint64_t>::max() - d) / 10) return record(name, "below 2^64");
      sum = 10 * sum + d;
    }
    value = sum;
  }
  void record(const std::string& name, const std::string& expected) {
    if (!error_) error_ = bad("'" + name + "'", expected).value();
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  const JsonValue& object_;
  std::optional<Error> error_;
};

std::optional<Error> read_noise(const JsonValue& json, PlantNoise& noise) {
  Reader reader{json};
  reader.number("odometry_scale_sd", noise.odometry_scale_sd, 0.2);
  reader.number("odometry_noise_m_per_sqrt_m", noise.odometry_noise_m_per_sqrt_m, 1.0);
  reader.number("slip_per_mps2", noise.slip_per_mps2, 0.3);
  reader.number("line_offset_sd_m", noise.line_offset_sd_m, 0.05);
  reader.number("tag_range_m", noise.tag_range_m, 1.0);
  reader.number("tag_miss", noise.tag_miss, 1.0);
  reader.milliseconds("tag_latency_min_ms", noise.tag_latency_min);
  reader.milliseconds("tag_latency_max_ms", noise.tag_latency_max);
  reader.number("range_sd_m", noise.range_sd_m, 1.0);
  reader.number("range_dropout", noise.range_dropout, 1.0);
  if (noise.tag_latency_min > noise.tag_latency_max) reader.record("tag_latency_min_ms", "at most tag_latency_max_ms");
  return reader.error();
}

void write_noise(JsonWriter& json, const PlantNoise& noise) {
  json.begin_object()
      .field("odometry_scale_sd", noise.odometry_scale_sd)
      .field("odometry_noise_m_per_sqrt_m", noise.odometry_noise_m_per_sqrt_m)
      .field("slip_per_mps2", noise.slip_per_mps2)
      .field("line_offset_sd_m", noise.line_offset_sd_m)
      .field("tag_range_m", noise.tag_range_m)
      .field("tag_miss", noise.tag_miss)
      .field("tag_latency_min_ms", to_milliseconds(noise.tag_latency_min))
      .field("tag_latency_max_ms", to_milliseconds(noise.tag_latency_max))
      .field("range_sd_m", noise.range_sd_m)
      .field("range_dropout", noise.range_dropout)
      .end_object();
}

bool is_line_tracking(std::string_view name) { return std::ranges::count(line_tracking_names(), name) > 0; }

std::string one_of_line_trackings() {
  std::string text;
  for (const std::string& name : line_tracking_names()) text += (text.empty() ? "one of " : ", ") + name;
  return text;
}

/// A vehicle's number from 1 to `vehicles`; nothing: the text is none.
std::optional<std::uint32_t> vehicle_number(std::string_view text, std::uint32_t vehicles) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number < 1 || number > vehicles) return std::nullopt;
  return number;
}

}  // namespace

VehicleEquipment PlantOptions::equipment_of(std::uint32_t vehicle) const {
  return vehicle <= equipment.size() ? equipment[vehicle - 1] : VehicleEquipment{};
}

Result<std::vector<VehicleEquipment>> read_equipment(std::uint32_t vehicles,
                                                     const std::vector<std::string>& line_tracking,
                                                     const std::vector<std::string>& without_rali) {
  std::vector<VehicleEquipment> equipment(line_tracking.empty() && without_rali.empty() ? 0 : vehicles);
  const std::string numbers = "a vehicle's number from 1 to " + std::to_string(vehicles);
  for (const std::string& given : line_tracking) {
    const std::size_t equals = given.find('=');
    const std::string name = equals == std::string::npos ? given : given.substr(equals + 1);
    if (!is_line_tracking(name))
      return fail("plant.line_tracking", "'" + name + "' is no algorithm; expected " + one_of_line_trackings(), given);
    const auto number = equals == std::string::npos ? std::nullopt : vehicle_number(given.substr(0, equals), vehicles);
    if (equals != std::string::npos && !number) return fail("plant.line_tracking", "expected " + numbers, given);
    for (std::uint32_t v = 1; v <= vehicles; ++v)
      if (!number || *number == v) equipment[v - 1].line_tracking = name;
  }
  for (const std::string& given : without_rali) {
    const auto number = vehicle_number(given, vehicles);
    if (!number && given != "all") return fail("plant.rali", "expected " + numbers + ", or all", given);
    for (std::uint32_t v = 1; v <= vehicles; ++v)
      if (!number || *number == v) equipment[v - 1].rali = false;
  }
  return equipment;
}

std::string to_json(const PlantOptions& options) {
  JsonWriter json;
  json.begin_object();
  zone::write_json(json.key("zone"), options.zone);
  json.field("vehicles", options.vehicles)
      .field("seed", std::to_string(options.seed))
      .field("cycle_ms", to_milliseconds(options.cycle))
      .key("noise");
  write_noise(json, options.noise);
  json.field("publish_zone", options.publish_zone).field("publish_ground_truth", options.publish_ground_truth);
  if (!options.equipment.empty()) {
    json.key("equipment").begin_array();
    for (const VehicleEquipment& of : options.equipment)
      json.begin_object().field("line_tracking", of.line_tracking).field("rali", of.rali).end_object();
    json.end_array();
  }
  json.end_object();
  return json.take();
}

Result<PlantOptions> plant_options_from_json(std::string_view text) {
  const auto json = JsonValue::parse(text);
  if (!json) return tl::unexpected(json.error());
  if (json->object() == nullptr) return bad("the document", "an object");
  PlantOptions options;
  const JsonValue* zone = json->find("zone");
  auto configuration = zone::zone_configuration_from_json(zone == nullptr ? JsonValue{} : *zone);
  if (!configuration) return tl::unexpected(configuration.error());
  options.zone = std::move(*configuration);
  Reader reader{*json};
  reader.count("vehicles", options.vehicles, vehicles_max);
  reader.seed("seed", options.seed);
  reader.milliseconds("cycle_ms", options.cycle);
  if (options.cycle < std::chrono::milliseconds{1}) reader.record("cycle_ms", "at least 1");
  reader.flag("publish_zone", options.publish_zone);
  reader.flag("publish_ground_truth", options.publish_ground_truth);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (const JsonValue* noise = json->find("noise")) {
    if (noise->object() == nullptr) return bad("'noise'", "an object");
    if (const auto error = read_noise(*noise, options.noise)) return tl::unexpected(*error);
  }
  if (const JsonValue* equipment = json->find("equipment")) {
    if (equipment->array() == nullptr || equipment->array()->size() > options.vehicles)
      return bad("'equipment'", "a list with at most one entry for each vehicle");
    for (const JsonValue& entry : *equipment->array()) {
      VehicleEquipment of;
      of.line_tracking = entry.text("line_tracking").value_or(of.line_tracking);
      of.rali = entry.flag("rali").value_or(of.rali);
      if (!is_line_tracking(of.line_tracking)) return bad("'line_tracking'", one_of_line_trackings());
      options.equipment.push_back(std::move(of));
    }
  }
  return options;
}

}  // namespace cosiva::physical
