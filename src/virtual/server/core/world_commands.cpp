#include "cosiva/virtual/server/core/world_commands.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "cosiva/base/json_writer.h"

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

/// {"addObstacle":…} or {"removeObstacle":…}, as the emulated world reads it.
Result<std::string> plant_json(const JsonValue& plant, const AugmentedParts& augmented, double radius_m) {
  JsonWriter json;
  if (const JsonValue* removed = plant.find("removeObstacle")) {
    auto id = obstacle_id(removed->text() == nullptr ? std::nullopt : std::optional{*removed->text()});
    if (!id) return id;
    json.begin_object().field("removeObstacle", *id).end_object();
    return json.take();
  }
  const JsonValue* added = plant.find("addObstacle");
  if (added == nullptr || added->object() == nullptr) {
    return fail("plant.missing",
                R"(state what to do, as {"addObstacle":{"id":"box1","x":0.5,"y":0.2}} or {"removeObstacle":"box1"})",
                "plant");
  }
  auto id = obstacle_id(added->text("id"));
  if (!id) return id;
  const JsonValue none;
  const JsonValue* x = added->find("x");
  const JsonValue* y = added->find("y");
  const auto at = augmented.objects.read_point(x == nullptr ? none : *x, y == nullptr ? none : *y, "x, y");
  if (!at) return tl::unexpected(at.error());
  if (const JsonValue* given = added->find("radius"); given != nullptr && !given->is_null()) {
    const double* number = given->number();
    if (number == nullptr || !(*number >= obstacle_radius_m_min && *number <= obstacle_radius_m_max))
      return fail("plant.radius", "give a radius from 0.02 m to 1 m", "radius");
    radius_m = *number;
  }
  json.begin_object().key("addObstacle").begin_object();
  json.field("id", *id).field("x", at->x_m).field("y", at->y_m).field("radius", radius_m).end_object().end_object();
  return json.take();
}

}  // namespace

bool is_world_command(std::string_view name) { return name == "plant" || name == "radio"; }

Result<wire::Publish> read_world_command(const JsonValue& command, const ServerContext& context,
                                         const AugmentedParts& augmented) {
  if (command.text("command") == "plant") {
    const JsonValue* plant = command.find("plant");
    if (plant == nullptr) return fail("plant.missing", "state what to do in the emulated world, as \"plant\"", "plant");
    if (!context.simulator.zone())
      return fail("plant.zone", "there is no zone yet; wait until the physical side has sent it, then try again");
    auto json =
        plant_json(*plant, augmented, std::max(obstacle_radius_m_min, 0.5 * context.simulator.zone()->vehicle.width_m));
    if (!json) return tl::unexpected(json.error());
    return wire::Publish{std::string(wire::plant_command_topic), std::move(*json), 1, false};
  }
  const wire::Radio radio{command.text("vehicle").value_or(""), command.number("loss").value_or(-1.0)};
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
