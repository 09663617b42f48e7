#include "cosiva/physical/plant/vehicle_faults.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

using Kind = VehicleFault::Kind;

constexpr std::array kinds_in_order{Kind::stuck_sensor, Kind::dead_motor, Kind::failed_reader, Kind::brown_out};
constexpr double for_s_max = 86'400.0;
constexpr double brown_out_s_max = 10.0;

tl::unexpected<Error> bad(const std::string& expected, const std::string& field) {
  return fail("plant.fault", "expected " + expected, field);
}

/// A whole number from 0 to `max`, where the field is given.
Result<void> read_whole(const JsonValue& json, const char* field, double max, double& value) {
  const JsonValue* given = json.find(field);
  if (given == nullptr) return {};
  const double* number = given->number();
  if (number == nullptr || !(*number >= 0.0 && *number <= max) || std::floor(*number) != *number)
    return bad("a whole number from 0 to " + std::to_string(static_cast<int>(max)), field);
  value = *number;
  return {};
}

}  // namespace

std::string_view to_string(VehicleFault::Kind kind) {
  switch (kind) {
    case Kind::stuck_sensor: return "stuck_sensor";
    case Kind::dead_motor: return "dead_motor";
    case Kind::failed_reader: return "failed_reader";
    case Kind::brown_out: return "brown_out";
  }
  return "?";
}

Result<std::optional<VehicleFault>> vehicle_fault_from_json(const JsonValue& json) {
  const auto word = json.text("fault");
  if (word == "none") return std::nullopt;
  const auto kind = std::ranges::find(kinds_in_order, word.value_or(""), [](Kind k) { return to_string(k); });
  if (kind == kinds_in_order.end()) return bad("stuck_sensor, dead_motor, failed_reader, brown_out or none", "fault");
  VehicleFault fault;
  fault.kind = *kind;
  const double s_max = fault.kind == Kind::brown_out ? brown_out_s_max : for_s_max;
  if (const JsonValue* given = json.find("for_s"); given != nullptr || fault.kind == Kind::brown_out) {
    const double* for_s = given == nullptr ? nullptr : given->number();
    if (for_s == nullptr || !(*for_s > 0.0 && *for_s <= s_max))
      return bad("seconds above 0, up to " + std::to_string(static_cast<int>(s_max)), "for_s");
    fault.duration = from_seconds(*for_s);
  }
  auto sensor = static_cast<double>(fault.sensor);
  double reading = fault.reading;
  for (const auto& read :
       {read_whole(json, "sensor", LT_SENSORS - 1, sensor), read_whole(json, "reading", 255.0, reading)})
    if (!read) return tl::unexpected(read.error());
  fault.sensor = static_cast<std::size_t>(sensor);
  fault.reading = static_cast<std::uint8_t>(reading);
  const std::string motor = json.text("motor").value_or("left");
  if (motor != "left" && motor != "right") return bad("left or right", "motor");
  fault.motor = motor == "left" ? DeadMotor::left : DeadMotor::right;
  return fault;
}

void VehicleFaults::begin(SimTime now, const VehicleFault& fault) {
  auto& end = ends_[static_cast<std::size_t>(fault.kind)];
  if (!end) ++count_;
  end = fault.duration ? now + *fault.duration : SimTime::max();
  COSIVA_EXPECT(count_ <= kinds);
}

std::optional<VehicleFault::Kind> VehicleFaults::take_ended(SimTime now) {
  for (const Kind kind : kinds_in_order) {
    auto& end = ends_[static_cast<std::size_t>(kind)];
    if (!end || *end > now) continue;
    end.reset();
    --count_;
    return kind;
  }
  return std::nullopt;
}

void VehicleFaults::end_all() {
  for (auto& end : ends_)
    if (end) end = SimTime::min();
}

void VehicleFaults::archive(Archive& archive) { archive(ends_, count_); }

}  // namespace cosiva::physical
