#include "cosiva/virtual/server/core/world_commands.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/crossing_status.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::size_t obstacle_id_bytes_max = 64;
constexpr double obstacle_radius_m_min = 0.02;
constexpr double obstacle_radius_m_max = 1.0;

Result<std::string> obstacle_id(const std::optional<std::string>& id) {
  if (!id || id->empty() || id->size() > obstacle_id_bytes_max)
    return fail("plant.id", "give the obstacle a name of 1 to 64 bytes, as \"id\"", "id");
  return *id;
}

/// The number of a vehicle of the emulated world: 2 of "CoSiVA/AIV2".
Result<std::uint32_t> emulated_number(const std::string& vehicle, const ServerContext& context) {
  const std::string prefix = std::string(wire::our_manufacturer) + "/AIV";
  std::uint32_t number = 0;
  const char* end = vehicle.data() + vehicle.size();
  const bool known = context.registry.find(vehicle) && vehicle.starts_with(prefix);
  if (known) {
    const auto [parsed, error] = std::from_chars(vehicle.data() + prefix.size(), end, number);
    if (error == std::errc{} && parsed == end && number > 0) return number;
  }
  return fail("plant.vehicle",
              "'" + vehicle.substr(0, 80) + "' is no vehicle of the emulated world; name one such as CoSiVA/AIV1",
              "vehicle");
}

/// {"setFault":…}, as the emulated world reads it.
Result<std::string> fault_json(const PlantCommand::Fault& fault, const ServerContext& context) {
  static constexpr std::array kinds{"stuck_sensor", "dead_motor", "failed_reader", "brown_out", "none"};
  const auto number = emulated_number(fault.vehicle, context);
  if (!number) return tl::unexpected(number.error());
  if (std::ranges::find(kinds, fault.kind) == kinds.end())
    return fail("plant.fault", "give the fault: stuck_sensor, dead_motor, failed_reader, brown_out or none", "fault");
  JsonWriter json;
  json.begin_object().key("setFault").begin_object().field("vehicle", *number).field("fault", fault.kind);
  for (const auto& [name, value] :
       {std::pair{"for_s", fault.for_s}, {"sensor", fault.sensor}, {"reading", fault.reading}}) {
    if (!value) continue;
    if (!std::isfinite(*value)) return fail("plant.fault", "give a number", name);
    json.field(name, *value);
  }
  if (fault.motor) json.field("motor", *fault.motor);
  json.end_object().end_object();
  return json.take();
}

/// {"addObstacle":…} or {"removeObstacle":…}, as the emulated world reads it.
Result<std::string> plant_json(const PlantCommand& command, const AugmentedParts& augmented, double radius_m) {
  JsonWriter json;
  if (command.act == PlantCommand::Act::remove) {
    auto id = obstacle_id(command.id);
    if (!id) return id;
    json.begin_object().field("removeObstacle", *id).end_object();
    return json.take();
  }
  if (command.act == PlantCommand::Act::none) {
    return fail("plant.missing",
                R"(state what to do, as {"addObstacle":{"id":"box1","x":0.5,"y":0.2}} or {"removeObstacle":"box1"})",
                "plant");
  }
  auto id = obstacle_id(command.id);
  if (!id) return id;
  const auto at = augmented.objects.read_point(command.x_m, command.y_m, "x, y");
  if (!at) return tl::unexpected(at.error());
  if (command.radius_m) {
    radius_m = *command.radius_m;
    if (!(radius_m >= obstacle_radius_m_min && radius_m <= obstacle_radius_m_max))
      return fail("plant.radius", "give a radius from 0.02 m to 1 m", "radius");
  }
  json.begin_object().key("addObstacle").begin_object();
  json.field("id", *id).field("x", at->x_m).field("y", at->y_m).field("radius", radius_m).end_object().end_object();
  return json.take();
}

/// The message to the emulated crossing units.
Result<wire::Publish> unit_switch(const PlantCommand::Unit& unit, const zone::TrafficZone& zone) {
  if (std::ranges::find(zone.crossings, unit.crossing, &zone::Crossing::name) == zone.crossings.end())
    return fail("plant.unit", "the zone has no crossing '" + unit.crossing.substr(0, 80) + "'", "crossing");
  if (!unit.on) return fail("plant.unit", "give \"on\": true or false", "on");
  return wire::Publish{std::string(wire::plant_unit_topic), wire::to_json(wire::UnitSwitch{unit.crossing, *unit.on}), 1,
                       false};
}

}  // namespace

Result<wire::Publish> read_world_command(const PlantCommand& command, const ServerContext& context,
                                         const AugmentedParts& augmented) {
  if (!context.simulator.zone())
    return fail("plant.zone", "there is no zone yet; wait until the physical side has sent it, then try again");
  if (command.act == PlantCommand::Act::unit) return unit_switch(command.unit, *context.simulator.zone());
  auto json = command.act == PlantCommand::Act::fault
                  ? fault_json(command.fault, context)
                  : plant_json(command, augmented,
                               std::max(obstacle_radius_m_min, 0.5 * context.simulator.zone()->vehicle.width_m));
  if (!json) return tl::unexpected(json.error());
  return wire::Publish{std::string(wire::plant_command_topic), std::move(*json), 1, false};
}

Result<wire::Publish> read_world_command(const RadioCommand& command, const ServerContext& context) {
  const wire::Radio radio{command.vehicle, command.loss_ratio};
  if (radio.vehicle != "*" && !context.registry.find(radio.vehicle)) {
    return fail("radio.vehicle",
                "no vehicle '" + radio.vehicle.substr(0, 80) +
                    "' is known; name it as manufacturer/serial number, or * for all",
                "vehicle");
  }
  if (!(radio.loss >= 0.0 && radio.loss <= 1.0))
    return fail("radio.loss", "give the ratio of lost messages, from 0 to 1", "loss");
  return wire::Publish{std::string(wire::plant_radio_topic), wire::to_json(radio), 1, false};
}

}  // namespace cosiva::virtual_side
