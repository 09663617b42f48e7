#include "cosiva/virtual/server/core/command_router.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/core/world_commands.h"

namespace cosiva::virtual_side {
namespace {

/// A zone's whole configuration may be in a command.
constexpr std::size_t command_bytes_max = 64U << 20U;

constexpr std::string_view no_virtual_aivs = "virtual_object.area";

bool adds_virtual_aiv(const JsonValue& command) {
  const JsonValue* object = command.find("virtualObject");
  return object != nullptr && object->text("kind") == "aiv";
}

}  // namespace

CommandRouter::Kind CommandRouter::kind_of(std::string_view name) {
  if (VirtualObjectCommands::handles(name)) return Kind::object;
  if (ZoneEdits::handles(name)) return Kind::edit;
  if (MissionRequests::handles(name)) return Kind::mission;
  if (is_world_command(name)) return Kind::world;
  if (name == "switch") return Kind::zone_switch;
  return name == "batteryReady" ? Kind::battery : Kind::vehicles;
}

CommandRouter::Request CommandRouter::parse(std::string_view json) {
  Request request{JsonValue::parse(json, command_bytes_max), {}};
  if (request.json) request.name = request.json->text("command").value_or("");
  request.kind = kind_of(request.name);
  // A command to vehicles contains no zone, so its length is limited.
  if (request.kind == Kind::vehicles && json.size() > Commands::bytes_max)
    request.json = JsonValue::parse(json, Commands::bytes_max);
  return request;
}

Result<void> CommandRouter::check(std::string_view json) const {
  const Request request = parse(json);
  if (request.kind == Kind::vehicles) return master_.commands.check(request.json);
  const auto command = read(request);
  if (!command) return tl::unexpected(command.error());
  return {};
}

void CommandRouter::run(std::string_view json) {
  const Request request = parse(json);
  if (request.kind == Kind::vehicles) {
    master_.commands.issue(request.json);
    world_.update();
    return;
  }
  auto command = read(request);
  if (!command) return refuse(request, command.error());
  COSIVA_EXPECT(request.json && !command->valueless_by_exception());
  std::visit([this](auto& one) { execute(one); }, *command);
  world_.update();
}

Result<OperatorCommand> CommandRouter::read(const Request& request) const {
  const JsonValue& json = *request.json;
  switch (request.kind) {
    case Kind::object: return read_object(request);
    case Kind::edit: {
      auto after = zones_.edits().after(json, context_.simulator);
      if (!after) return tl::unexpected(after.error());
      return EditCommand{request.name, std::move(*after)};
    }
    case Kind::zone_switch: {
      auto wanted = zones_.wanted_by(json);
      if (!wanted) return tl::unexpected(wanted.error());
      return SwitchCommand{std::move(*wanted)};
    }
    case Kind::mission: {
      const auto checked = master_.mission_requests.check(json);
      if (!checked) return tl::unexpected(checked.error());
      return MissionCommand{json};
    }
    case Kind::world:
    case Kind::battery:
    case Kind::vehicles: break;
  }
  return read_message(request);
}

Result<OperatorCommand> CommandRouter::read_object(const Request& request) const {
  if (context_.areas.several() && request.name == "add" && adds_virtual_aiv(*request.json)) {
    return fail(std::string(no_virtual_aivs),
                "a virtual AIV cannot be added where several control areas use one broker; persons and obstacles can",
                "kind");
  }
  auto object = augmented_.objects.read(*request.json);
  if (!object) return tl::unexpected(object.error());
  return std::move(*object);
}

Result<OperatorCommand> CommandRouter::read_message(const Request& request) const {
  COSIVA_EXPECT(request.kind == Kind::world || request.kind == Kind::battery);
  const bool is_for_world = request.kind == Kind::world;
  auto message = is_for_world ? read_world_command(*request.json, context_, augmented_)
                              : instruments_.batteries.ready(*request.json);
  if (!message) return tl::unexpected(message.error());
  const std::string payload = message->payload;
  if (is_for_world) return MessageCommand{"emulated world", request.name, payload, std::move(*message)};
  return MessageCommand{"battery test", "battery", "batteryReady: " + payload, std::move(*message)};
}

void CommandRouter::refuse(const Request& request, const Error& error) {
  const bool is_switch = request.kind == Kind::zone_switch;
  if (is_switch) {
    const JsonValue* zone = request.json->find("zone");
    zones_.refuse(zone == nullptr ? std::string{} : zone->text("origin").value_or(""), to_string(error));
  } else {
    context_.publisher.log('w', "command refused: " + to_string(error));
  }
  // Recorded runs contain an update after exactly these refusals.
  if (is_switch || request.kind == Kind::edit || error.code == no_virtual_aivs) world_.update();
}

void CommandRouter::execute(const VirtualObjectCommand& command) { world_.follow(command); }

void CommandRouter::execute(const EditCommand& command) { zones_.apply_edit(command.name, command.after); }

void CommandRouter::execute(const SwitchCommand& command) { zones_.switch_to(command.zone); }

void CommandRouter::execute(MessageCommand& command) {
  wire::Publish& message = command.message;
  context_.traces.add(context_.now, "AIV_Server", command.trace_to, command.trace_kind, command.trace_content,
                      message.topic, message.payload);
  context_.publisher.publish(std::move(message.topic), std::move(message.payload), message.qos, message.retained);
}

void CommandRouter::execute(const MissionCommand& command) {
  master_.mission_requests.follow(command.json);
  context_.state_stale = true;
}

}  // namespace cosiva::virtual_side
