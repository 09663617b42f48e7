#include "cosiva/virtual/server/core/command_router.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/core/world_commands.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::string_view no_virtual_aivs = "virtual_object.area";

template <typename... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};
template <typename... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;

/// What a part found, as one of the commands that are ready to be executed.
template <typename Checked>
Result<CheckedCommand> either(Result<Checked> checked) {
  if (!checked) return tl::unexpected(std::move(checked.error()));
  return CheckedCommand{std::move(*checked)};
}

}  // namespace

Result<void> CommandRouter::check(const DecodedCommand& decoded) const {
  if (!decoded.command()) return tl::unexpected(decoded.command().error().error);
  if (decoded.identity() && master_.command_ids.find(*decoded.identity()) == CommandIds::Known::other) {
    return fail(
        "command.id_taken",
        "the id '" + decoded.identity()->id + "' belongs to another command; give each command an id of its own", "id");
  }
  const OperatorCommand& command = *decoded.command();
  if (const auto* to_vehicles = std::get_if<VehicleCommand>(&command)) return master_.commands.check(*to_vehicles);
  if (const auto found = checked(command); !found) return tl::unexpected(found.error());
  return {};
}

void CommandRouter::run(const DecodedCommand& decoded, bool stored) {
  if (!decoded.command()) return refuse(decoded.command().error());
  if (decoded.identity()) {
    master_.command_ids.add(*decoded.identity());
    context_.state_stale = true;
  }
  const OperatorCommand& command = *decoded.command();
  if (const auto* to_vehicles = std::get_if<VehicleCommand>(&command)) {
    master_.commands.issue(*to_vehicles, stored);
    context_.state_stale = true;  // the intentions are persisted
    world_.update();
    return;
  }
  auto ready = checked(command);
  if (!ready) return refuse(command, ready.error());
  COSIVA_EXPECT(!ready->valueless_by_exception());
  std::visit([this](auto& one) { execute(one); }, *ready);
  world_.update();
}

Result<CheckedCommand> CommandRouter::checked(const OperatorCommand& command) const {
  const auto as_stated = [](const Result<void>& good, const auto& one) -> Result<CheckedCommand> {
    if (!good) return tl::unexpected(good.error());
    return CheckedCommand{one};
  };
  return std::visit(
      Overloaded{
          [](const VehicleCommand&) -> Result<CheckedCommand> { COSIVA_EXPECT(false); },
          [&](const MissionCommand& one) { return as_stated(master_.mission_requests.check(one), one); },
          [&](const SectionCommand& one) { return as_stated(master_.mission_requests.check(one), one); },
          [&](const MoveCommand& one) { return either(augmented_.objects.read(one)); },
          [&](const RemoveCommand& one) { return either(augmented_.objects.read(one)); },
          [&](const EditCommand& one) -> Result<CheckedCommand> {
            auto after = zones_.edits().after(one, context_.simulator);
            if (!after) return tl::unexpected(std::move(after.error()));
            return CheckedCommand{CheckedEdit{one.kind, std::move(*after)}};
          },
          [&](const SwitchCommand& one) { return as_stated(zones_.check(one), one); },
          [&](const RetireCommand& one) { return either(instruments_.presence.departure(one, context_.now)); },
          [&](const auto& one) { return checked(one); },
      },
      command);
}

Result<CheckedCommand> CommandRouter::checked(const AddCommand& command) const {
  if (context_.areas.several() && command.object.kind == "aiv") {
    return fail(std::string(no_virtual_aivs),
                "a virtual AIV cannot be added where several control areas use one broker; persons and obstacles can",
                "kind");
  }
  return either(augmented_.objects.read(command));
}

Result<CheckedCommand> CommandRouter::checked(const PlantCommand& command) const {
  auto message = read_world_command(command, context_, augmented_);
  if (!message) return tl::unexpected(std::move(message.error()));
  const std::string payload = message->payload;
  return CheckedCommand{MessageCommand{&RemoteAgents::emulated_world, "plant", payload, std::move(*message)}};
}

Result<CheckedCommand> CommandRouter::checked(const RadioCommand& command) const {
  auto message = read_world_command(command, context_);
  if (!message) return tl::unexpected(std::move(message.error()));
  const std::string payload = message->payload;
  return CheckedCommand{MessageCommand{&RemoteAgents::emulated_world, "radio", payload, std::move(*message)}};
}

Result<CheckedCommand> CommandRouter::checked(const BatteryReadyCommand& command) const {
  auto message = instruments_.batteries.ready(command);
  if (!message) return tl::unexpected(std::move(message.error()));
  const std::string payload = message->payload;
  return CheckedCommand{
      MessageCommand{&RemoteAgents::battery_test, "battery", "batteryReady: " + payload, std::move(*message)}};
}

void CommandRouter::refuse(const DecodedCommand::Fault& fault) {
  using By = DecodedCommand::Fault::By;
  switch (fault.by) {
    case By::vehicles: master_.commands.issue(tl::unexpected(fault.error)); break;
    case By::zone_switch: zones_.refuse(fault.origin, to_string(fault.error)); break;
    case By::log: context_.publisher.log('w', "command refused: " + to_string(fault.error)); return;
  }
  world_.update();
}

void CommandRouter::refuse(const OperatorCommand& command, const Error& error) {
  const auto* to_zone = std::get_if<SwitchCommand>(&command);
  if (to_zone != nullptr)
    zones_.refuse(to_zone->zone.origin, to_string(error));
  else
    context_.publisher.log('w', "command refused: " + to_string(error));
  // Recorded runs contain an update after exactly these refusals.
  if (to_zone != nullptr || std::holds_alternative<EditCommand>(command) || error.code == no_virtual_aivs)
    world_.update();
}

void CommandRouter::execute(const VirtualObjectCommand& command) { world_.follow(command); }

void CommandRouter::execute(const CheckedEdit& command) { zones_.apply_edit(command.kind, command.after); }

void CommandRouter::execute(const SwitchCommand& command) { zones_.switch_to(command.zone); }

void CommandRouter::execute(MessageCommand& command) {
  AgentProxy& receiver = context_.agents.*command.receiver;
  context_.publisher.send(receiver, command.kind, command.summary, std::move(command.message));
}

void CommandRouter::execute(const MissionCommand& command) {
  master_.mission_requests.follow(command);
  for (const std::string& name : command.vehicle_names) {
    for (const AivProxy& proxy : context_.registry)
      if (name == "*" || name == proxy.name()) master_.intentions.on_mission(proxy.name());
  }
  context_.state_stale = true;
}

void CommandRouter::execute(const Departure& command) {
  vehicles_.depart(command.vehicle, "operator", "an operator has retired it");
}

void CommandRouter::execute(const SectionCommand& command) {
  master_.mission_requests.follow(command);
  context_.state_stale = true;
}

}  // namespace cosiva::virtual_side
