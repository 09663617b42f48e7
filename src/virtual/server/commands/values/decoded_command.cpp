#include "cosiva/virtual/server/commands/values/decoded_command.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace cosiva::virtual_side {
namespace {

using Fault = DecodedCommand::Fault;
using Decoded = tl::expected<OperatorCommand, Fault>;

/// A zone's whole configuration may be in a command.
constexpr std::size_t command_bytes_max = 64U << 20U;
constexpr double limit_mps_max = 5.0;
constexpr std::size_t vehicles_named_max = 256;
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

constexpr std::array kinds{OperatorCommandKind::stop,     OperatorCommandKind::slow,    OperatorCommandKind::medium,
                           OperatorCommandKind::fast,     OperatorCommandKind::limit,   OperatorCommandKind::restart,
                           OperatorCommandKind::cancel,   OperatorCommandKind::exclude, OperatorCommandKind::include,
                           OperatorCommandKind::self_test};

std::string cut(std::string_view text) { return std::string(text.substr(0, 80)); }

double number_or_nan(const JsonValue& json) { return json.number() == nullptr ? no_number : *json.number(); }

/// A field that counts as left out where it is null.
OptionalNumber number_of(const JsonValue& json, std::string_view field) {
  const JsonValue* found = json.find(field);
  return found == nullptr || found->is_null() ? std::nullopt : OptionalNumber{number_or_nan(*found)};
}

/// A coordinate counts as stated even where it is null.
OptionalNumber coordinate_of(const JsonValue& json, std::string_view field) {
  const JsonValue* found = json.find(field);
  return found == nullptr ? std::nullopt : OptionalNumber{number_or_nan(*found)};
}

/// A field that counts as left out where it is null; empty where it is no text.
std::optional<std::string> text_of(const JsonValue& json, std::string_view field) {
  const JsonValue* found = json.find(field);
  if (found == nullptr || found->is_null()) return std::nullopt;
  return found->text() == nullptr ? std::string{} : *found->text();
}

tl::unexpected<Fault> fault(std::string code, std::string message, std::string location) {
  return tl::unexpected(Fault{Error{std::move(code), std::move(message), std::move(location)}});
}

Result<VehicleCommand> vehicle_command(const Result<JsonValue>& value) {
  if (!value || value->object() == nullptr) {
    return fail("command.syntax", "a command is a JSON object like {\"command\":\"stop\",\"vehicle\":\"*\"}" +
                                      (value ? std::string{} : "; this is none: " + value.error().message));
  }
  VehicleCommand command;
  command.id = cut(value->text("id").value_or(""));
  command.action_id = cut(value->text("actionId").value_or(""));
  const auto requested = value->text("command");
  if (!requested)
    return fail(
        "command.missing",
        "state which command: stop, slow, medium, fast, limit, restart, cancel, exclude, include, retire or self-test",
        "command");
  command.command_text = cut(*requested);
  if (const JsonValue* list = value->find("vehicles"); list != nullptr && !list->is_null()) {
    if (list->array() == nullptr || list->array()->empty() || list->array()->size() > vehicles_named_max)
      return fail("command.vehicle", "give at least one and at most 256 vehicles, as [\"CoSiVA/AIV1\",…]", "vehicles");
    for (const JsonValue& name : *list->array())
      command.vehicle_names.push_back(name.text() == nullptr ? std::string{} : cut(*name.text()));
    command.several = true;
  } else {
    const auto vehicle = value->text("vehicle");
    if (!vehicle)
      return fail("command.vehicle", "state which vehicle, as manufacturer/serial number, or * for all", "vehicle");
    command.vehicle_names.push_back(cut(*vehicle));
    command.several = *vehicle == "*";
  }
  const auto known = std::ranges::find(kinds, *requested, [](OperatorCommandKind v) { return to_string(v); });
  if (known != kinds.end()) command.kind = *known;
  if (command.kind == OperatorCommandKind::limit) {
    command.speed_mps = value->number("speed").value_or(0.0);
    if (!(command.speed_mps > 0.0 && command.speed_mps <= limit_mps_max))
      return fail("command.speed", "state the maximum speed, above 0 and up to 5 m/s, as \"speed\":0.25", "speed");
  }
  return command;
}

std::vector<std::optional<Point2>> path_of(const JsonValue& json) {
  std::vector<std::optional<Point2>> path;
  if (json.array() == nullptr) return path;
  for (const JsonValue& point : *json.array()) {
    const JsonValue::Array* pair = point.array();
    if (pair == nullptr || pair->size() != 2)
      path.emplace_back();
    else
      path.emplace_back(Point2{number_or_nan((*pair)[0]), number_or_nan((*pair)[1])});
  }
  return path;
}

VirtualObjectFields fields_of(const JsonValue& object) {
  VirtualObjectFields fields;
  fields.kind = object.text("kind").value_or("");
  fields.x_m = coordinate_of(object, "x");
  fields.y_m = coordinate_of(object, "y");
  fields.section = text_of(object, "section");
  fields.section_is_text = !fields.section || object.text("section").has_value();
  fields.s_m = number_of(object, "s");
  fields.radius_m = number_of(object, "radius");
  if (const JsonValue* path = object.find("path"); path != nullptr && !path->is_null()) fields.path = path_of(*path);
  fields.speed_mps = number_of(object, "speed");
  fields.repeat = text_of(object, "repeat");
  return fields;
}

Decoded object_command(const JsonValue& json, std::string_view name) {
  if (name == "remove") {
    auto id = json.text("id");
    if (!id) return fault("virtual_object.id", "give the id of the virtual object to remove, or * for all", "id");
    return RemoveCommand{std::move(*id)};
  }
  const JsonValue* object = json.find("virtualObject");
  if (object == nullptr || object->object() == nullptr)
    return fault("virtual_object.missing",
                 R"(state what to add, as {"virtualObject":{"kind":"person","x":0.5,"y":0.2}})", "virtualObject");
  VirtualObjectFields fields = fields_of(*object);
  if (name == "move") {
    fields.id = object->text("id");
    return MoveCommand{std::move(fields)};
  }
  fields.id = text_of(*object, "id");
  return AddCommand{std::move(fields)};
}

Decoded mission_command(const JsonValue& json, bool goes) {
  MissionCommand command{goes, {}, json.text(goes ? "to" : "loop").value_or("")};
  if (const JsonValue* list = json.find("vehicles"); list != nullptr && list->array() != nullptr) {
    for (const JsonValue& name : *list->array())
      command.vehicle_names.push_back(name.text() == nullptr ? "" : *name.text());
  } else {
    command.vehicle_names.push_back(json.text("vehicle").value_or(""));
  }
  return command;
}

Decoded edit_command(const JsonValue& json, EditCommand::Kind kind) {
  const JsonValue* changes = json.find("edit");
  return EditCommand{kind, changes == nullptr ? JsonValue{} : *changes};
}

Decoded switch_command(const JsonValue& json) {
  if (const JsonValue* refused = json.find("refused")) {
    Error why{refused->text("code").value_or(""), refused->text("message").value_or(""),
              refused->text("location").value_or("")};
    return tl::unexpected(Fault{std::move(why), Fault::By::zone_switch, refused->text("origin").value_or("")});
  }
  const JsonValue* zone = json.find("zone");
  if (zone == nullptr) {
    return tl::unexpected(
        Fault{Error{"switch.zone", R"(state which zone, as {"zone":{"format":…,"origin":…,"text":…}})", "zone"},
              Fault::By::zone_switch});
  }
  auto configuration = zone::zone_configuration_from_json(*zone);
  if (!configuration) {
    return tl::unexpected(
        Fault{std::move(configuration.error()), Fault::By::zone_switch, zone->text("origin").value_or("")});
  }
  return SwitchCommand{std::move(*configuration)};
}

Decoded plant_command(const JsonValue& json) {
  const JsonValue* plant = json.find("plant");
  if (plant == nullptr) return fault("plant.missing", "state what to do in the emulated world, as \"plant\"", "plant");
  PlantCommand command;
  if (const JsonValue* removed = plant->find("removeObstacle")) {
    command.act = PlantCommand::Act::remove;
    if (removed->text() != nullptr) command.id = *removed->text();
    return command;
  }
  if (const JsonValue* fault = plant->find("setFault")) {
    command.act = PlantCommand::Act::fault;
    command.fault = {fault->text("vehicle").value_or(""), fault->text("fault").value_or(""), number_of(*fault, "for_s"),
                     number_of(*fault, "sensor"),         number_of(*fault, "reading"),      text_of(*fault, "motor")};
    return command;
  }
  if (const JsonValue* unit = plant->find("setUnit")) {
    command.act = PlantCommand::Act::unit;
    command.unit = {unit->text("crossing").value_or(""), unit->flag("on")};
    return command;
  }
  const JsonValue* added = plant->find("addObstacle");
  if (added == nullptr || added->object() == nullptr) return command;
  command.act = PlantCommand::Act::add;
  command.id = added->text("id");
  command.x_m = coordinate_of(*added, "x");
  command.y_m = coordinate_of(*added, "y");
  command.radius_m = number_of(*added, "radius");
  return command;
}

Decoded battery_ready_command(const JsonValue& json) {
  BatteryReadyCommand command;
  command.vehicle = json.text("vehicle").value_or("");
  command.battery = json.text("battery").value_or("");
  command.type = text_of(json, "type");
  command.type_is_text = !command.type || json.text("type").has_value();
  command.cycles = number_of(json, "cycles");
  command.rest_s = number_of(json, "rest_s");
  command.temperature_c = number_of(json, "temperature");
  command.charge_percent = number_of(json, "charge");
  return command;
}

std::optional<CommandIdentity> identity_of(const JsonValue& json, std::string_view text) {
  if (json.flag("once") != std::optional{true}) return std::nullopt;
  auto id = json.text("id");
  if (!id || id->empty() || id->size() > CommandIdentity::id_bytes_max) return std::nullopt;
  Digest content;
  content.add(text);
  return CommandIdentity{std::move(*id), content.value()};
}

/// @param identity  set where the command has one
Decoded decode(std::string_view text, std::optional<CommandIdentity>& identity) {
  auto json = JsonValue::parse(text, command_bytes_max);
  if (json) identity = identity_of(*json, text);
  const std::string name = json ? json->text("command").value_or("") : std::string{};
  if (name == "add" || name == "move" || name == "remove") return object_command(*json, name);
  if (name == "edit") return edit_command(*json, EditCommand::Kind::edit);
  if (name == "undo") return edit_command(*json, EditCommand::Kind::undo);
  if (name == "redo") return edit_command(*json, EditCommand::Kind::redo);
  if (name == "saved") return edit_command(*json, EditCommand::Kind::saved);
  if (name == "go" || name == "circulate") return mission_command(*json, name == "go");
  if (name == "retire") return RetireCommand{json->text("vehicle").value_or("")};
  if (name == "close" || name == "open") return SectionCommand{name == "close", json->text("section").value_or("")};
  if (name == "plant") return plant_command(*json);
  if (name == "radio") return RadioCommand{json->text("vehicle").value_or(""), json->number("loss").value_or(-1.0)};
  if (name == "switch") return switch_command(*json);
  if (name == "batteryReady") return battery_ready_command(*json);
  // A command to vehicles contains no zone, so its length is limited; a text that is too long is not parsed.
  if (text.size() > DecodedCommand::vehicle_command_bytes_max)
    json = JsonValue::parse(text, DecodedCommand::vehicle_command_bytes_max);
  auto command = vehicle_command(json);
  if (!command) return tl::unexpected(Fault{std::move(command.error()), Fault::By::vehicles});
  return std::move(*command);
}

}  // namespace

DecodedCommand::DecodedCommand(std::string_view json, Zone zone) : command_{decode(json, identity_)} {
  if (zone != Zone::built || !command_) return;
  auto* to_zone = std::get_if<SwitchCommand>(&*command_);
  if (to_zone == nullptr) return;
  auto rtm = zone::Rtm::initialise(to_zone->zone);
  if (rtm)
    to_zone->built = std::make_shared<const zone::Rtm>(std::move(*rtm));
  else
    to_zone->built = tl::unexpected(std::move(rtm.error()));
}

bool needs_zone(const DecodedCommand& decoded) {
  if (!decoded.command()) return false;
  const OperatorCommand& command = *decoded.command();
  return std::holds_alternative<MissionCommand>(command) || std::holds_alternative<SectionCommand>(command) ||
         std::holds_alternative<AddCommand>(command) || std::holds_alternative<MoveCommand>(command) ||
         std::holds_alternative<EditCommand>(command) || std::holds_alternative<PlantCommand>(command);
}

bool is_stop(const DecodedCommand& decoded) {
  if (!decoded.command()) return false;
  const auto* command = std::get_if<VehicleCommand>(&*decoded.command());
  return command != nullptr && command->kind == OperatorCommandKind::stop;
}

}  // namespace cosiva::virtual_side
