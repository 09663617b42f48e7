// What is asked of the server: each command goes to the part that understands it.
#include <array>
#include <cmath>
#include <utility>

#include "cosiva/virtual/server/core/inside.h"

namespace cosiva::virtual_side {
namespace {

/// A zone's whole configuration may be in it.
constexpr std::size_t command_bytes_max = 64U << 20U;
constexpr std::size_t obstacle_id_bytes_max = 64;
constexpr double obstacle_radius_m_min = 0.02;
constexpr double obstacle_radius_m_max = 1.0;

bool adds_virtual_aiv(const JsonValue& command) {
  const JsonValue* thing = command.find("thing");
  return thing != nullptr && thing->text("kind") == "aiv";
}

bool is_world_command(std::string_view command) { return command == "plant" || command == "radio"; }

bool is_battery_ready(std::string_view command) { return command == "batteryReady"; }

Result<void> no_virtual_aivs() {
  return fail("thing.hall",
              "a virtual AIV cannot be added where several halls share a broker; persons and obstacles can", "kind");
}

Result<std::string> obstacle_id(const std::optional<std::string>& id) {
  if (!id || id->empty() || id->size() > obstacle_id_bytes_max)
    return fail("plant.id", "give the obstacle a name of 1 to 64 bytes, as \"id\"", "id");
  return *id;
}

/// {"addObstacle":…} or {"removeObstacle":…}, as the emulated world reads it.
Result<std::string> plant_json(const JsonValue& plant, const ThingsDesk& objects, double radius_m) {
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
                R"(say what, as {"addObstacle":{"id":"box1","x":0.5,"y":0.2}} or {"removeObstacle":"box1"})", "plant");
  }
  auto id = obstacle_id(added->text("id"));
  if (!id) return id;
  const JsonValue none;
  const JsonValue* x = added->find("x");
  const JsonValue* y = added->find("y");
  const auto at = objects.read_point(x == nullptr ? none : *x, y == nullptr ? none : *y, "x, y");
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

Result<wire::Publish> ServerCore::Inside::world_command(const JsonValue& command) const {
  if (command.text("command") == "plant") {
    const JsonValue* plant = command.find("plant");
    if (plant == nullptr) return fail("plant.missing", "say what to do in the emulated world, as \"plant\"", "plant");
    if (!simulator.zone())
      return fail("plant.zone", "there is no zone yet; wait until the physical side has sent it, then try again");
    auto json = plant_json(*plant, objects, std::max(obstacle_radius_m_min, 0.5 * simulator.zone()->vehicle.width_m));
    if (!json) return tl::unexpected(json.error());
    return wire::Publish{std::string(wire::plant_command_topic), std::move(*json), 1, false};
  }
  const wire::Radio radio{command.text("vehicle").value_or(""), command.number("loss").value_or(-1.0)};
  if (radio.vehicle != "*" && !registry.find(radio.vehicle)) {
    return fail("radio.vehicle",
                "no vehicle '" + radio.vehicle.substr(0, 80) +
                    "' has been heard of; name it as manufacturer/serial number, or * for all",
                "vehicle");
  }
  if (!(radio.loss >= 0.0 && radio.loss <= 1.0))
    return fail("radio.loss", "give the share of messages that is lost, from 0 to 1", "loss");
  return wire::Publish{std::string(wire::plant_radio_topic), wire::to_json(radio), 1, false};
}

Result<void> ServerCore::Inside::check_command(std::string_view json) const {
  const auto command = JsonValue::parse(json, command_bytes_max);
  const std::string verb = command ? command->text("command").value_or("") : std::string{};
  const auto verdict = [](const auto& result) -> Result<void> {
    if (!result) return tl::unexpected(result.error());
    return {};
  };
  if (areas.several() && verb == "add" && adds_virtual_aiv(*command)) return no_virtual_aivs();
  if (ThingsDesk::is_ours(verb)) return verdict(objects.read(*command));
  if (ZoneEdits::is_ours(verb)) return verdict(zones.edits().after(*command, simulator));
  if (is_world_command(verb)) return verdict(world_command(*command));
  if (is_battery_ready(verb)) return verdict(batteries.ready(*command));
  if (Missions::is_ours(verb)) return missions.check(*command);
  if (verb == "switch") return verdict(zones.wanted_by(*command));
  return commands.check(json);
}

void ServerCore::Inside::say_battery_ready(wire::Publish message) {
  traces.add(now, "AIV_Server", "battery test", "battery", "batteryReady: " + message.payload, message.topic,
             message.payload);
  publisher.publish(std::move(message.topic), std::move(message.payload), message.qos, message.retained);
}

void ServerCore::Inside::on_command(std::string_view json) {
  const auto command = JsonValue::parse(json, command_bytes_max);
  const std::string verb = command ? command->text("command").value_or("") : std::string{};
  const auto refuse = [&](const Error& error) { publisher.log('w', "command refused: " + to_string(error)); };
  if (areas.several() && verb == "add" && adds_virtual_aiv(*command)) {
    refuse(no_virtual_aivs().error());
  } else if (ThingsDesk::is_ours(verb)) {
    const auto asked = objects.read(*command);
    if (!asked) return refuse(asked.error());
    world.follow(*asked);
  } else if (ZoneEdits::is_ours(verb)) {
    zones.follow_edit(*command);
  } else if (is_world_command(verb)) {
    auto message = world_command(*command);
    if (!message) return refuse(message.error());
    traces.add(now, "AIV_Server", "emulated world", verb, message->payload, message->topic, message->payload);
    publisher.publish(std::move(message->topic), std::move(message->payload), message->qos, message->retained);
  } else if (is_battery_ready(verb)) {
    auto message = batteries.ready(*command);
    if (!message) return refuse(message.error());
    say_battery_ready(std::move(*message));
  } else if (Missions::is_ours(verb)) {
    const auto checked = missions.check(*command);
    if (!checked) return refuse(checked.error());
    missions.follow(*command);
    state_stale = true;
  } else if (verb == "switch") {
    zones.follow_switch(*command);
  } else {
    commands.issue(json);
  }
  world.update();
}

}  // namespace cosiva::virtual_side
