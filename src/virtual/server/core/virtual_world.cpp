#include "cosiva/virtual/server/core/virtual_world.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

/// The restored position of a virtual AIV is up to a second old; another vehicle may occupy that position now.
constexpr double restored_shift_m = 1.0;
constexpr double restored_step_m = 0.05;

}  // namespace

void VirtualWorld::follow(const VirtualObjectCommand& command) {
  context_.state_stale = true;
  Augmented& world = context_.simulator.augmented();
  const auto trace = [&](std::string_view what) {
    context_.traces.add(context_.now, "AIV_Server", "Simulator", what,
                        command.id == "*" ? std::string("everything") : command.id);
  };
  switch (command.act) {
    case VirtualObjectCommand::Act::add:
      trace("add");
      if (command.is_aiv)
        add_aiv(command.id, command.position);
      else
        world.add({command.id, command.kind, 0, command.radius_m, command.walk, context_.now, context_.now});
      break;
    case VirtualObjectCommand::Act::move:
      trace("move");
      world.move(command.id, command.walk, context_.now);
      break;
    case VirtualObjectCommand::Act::remove:
      trace("remove");
      remove(command.id, command.is_aiv);
      break;
  }
}

void VirtualWorld::remove(const std::string& id, bool is_aiv) {
  if (id == "*") {
    context_.simulator.augmented().clear();
    augmented_.restored.clear();
    while (!augmented_.hosted.empty()) remove_aiv(augmented_.hosted.hosts().back().vehicle);
  } else if (is_aiv) {
    if (const VirtualFleet::Host* host = augmented_.objects.find_aiv(id))
      remove_aiv(host->vehicle);
    else
      augmented_.restored.remove(id);
  } else {
    context_.simulator.augmented().remove(id);
  }
}

bool VirtualWorld::add_aiv(const std::string& serial, zone::TrackPosition position) {
  const auto vehicle = vehicles_.begin_life({std::string(wire::virtual_manufacturer), serial});
  if (!vehicle) return false;
  COSIVA_EXPECT(context_.registry[*vehicle].augmented() && !context_.registry[*vehicle].retired() &&
                augmented_.hosted.find(*vehicle) == nullptr);
  augmented_.hosted.add(*vehicle, context_.now, context_.link.up(), context_.simulator.rtm(), position);
  context_.simulator.monitor().set_augmented(augmented_.hosted.hosts().size());
  context_.publisher.log('i', context_.registry[*vehicle].name() + ": added at " +
                                  context_.simulator.circuit()->part(position.section).name + ", " +
                                  std::to_string(position.s_m) + " m");
  return true;
}

void VirtualWorld::remove_aiv(VehicleIndex vehicle) {
  augmented_.hosted.remove(vehicle, context_.now);
  COSIVA_EXPECT(augmented_.hosted.find(vehicle) == nullptr);
  context_.simulator.monitor().set_augmented(augmented_.hosted.hosts().size());
  const std::string& name = context_.registry[vehicle].name();
  vehicles_.retire(vehicle, name + " has been removed");
  context_.publisher.log('i', name + ": removed");
}

void VirtualWorld::put_restored() {
  if (augmented_.restored.aivs().empty() || !context_.simulator.zone()) return;
  for (const RestoredAivs::Aiv& aiv : augmented_.restored.take()) {
    if (augmented_.objects.find_aiv(aiv.serial) != nullptr) continue;
    auto found = room_near(aiv);
    if (!found) found = augmented_.objects.roomiest();
    if (!found || !add_aiv(aiv.serial, *found))
      context_.publisher.log(
          'w', "virtual AIV " + aiv.serial + " cannot be restored, as no section has room for it; add it again");
  }
  context_.state_stale = true;
}

std::optional<zone::TrackPosition> VirtualWorld::room_near(const RestoredAivs::Aiv& aiv) const {
  const zone::Circuit& circuit = *context_.simulator.circuit();
  const auto section = circuit.find(aiv.section);
  if (!section) return std::nullopt;
  const zone::TrackPosition was{*section, std::clamp(aiv.s_m, 0.0, circuit.section(*section).length_m())};
  // The AIV may return to its previous position even inside a crossing: the crossing had been granted.
  if (augmented_.objects.has_room(was)) return was;
  for (double d = restored_step_m; d <= restored_shift_m; d += restored_step_m) {
    for (const double shift : {d, -d}) {
      const zone::TrackPosition near = circuit.advance(was, shift);
      if (augmented_.objects.check_position(near)) return near;
    }
  }
  return std::nullopt;
}

void VirtualWorld::write_state(JsonWriter& json) const {
  json.key("aivs").begin_array();
  const auto write_aiv = [&json](const std::string& serial, const std::string& section, double s_m) {
    json.begin_object().field("id", serial).field("section", section).field("s", s_m).end_object();
  };
  for (const VirtualFleet::Host& host : augmented_.hosted.hosts()) {
    const zone::TrackPosition position = VirtualFleet::position_of(host, *context_.simulator.circuit());
    write_aiv(context_.registry[host.vehicle].id().serial_number,
              context_.simulator.circuit()->part(position.section).name,
              std::nearbyint(position.s_m * 1000.0) / 1000.0);
  }
  for (const RestoredAivs::Aiv& aiv : augmented_.restored.aivs()) write_aiv(aiv.serial, aiv.section, aiv.s_m);
  json.end_array();
}

void VirtualWorld::sign_off_orphans() {
  for (AivProxy& proxy : context_.registry) {
    if (!proxy.augmented() || !proxy.retired() || proxy.connection.state() != wire::ConnectionState::online) continue;
    proxy.connection.on_offline(context_.now);
    wire::Connection disconnected{{0, context_.now, "2.1.0", proxy.id().manufacturer, proxy.id().serial_number},
                                  wire::ConnectionState::offline};
    context_.publisher.publish(wire::vda_topic(proxy.id(), "connection", context_.registry.interface_name()),
                               wire::vda5050::encode(disconnected), 1, true);
  }
}

void VirtualWorld::update() {
  if (!context_.link.up()) return;
  const std::uint64_t before = augmented_.pauses.changes();
  augmented_.virtual_obstacles.update();
  context_.state_stale = context_.state_stale || augmented_.pauses.changes() != before;
}

void VirtualWorld::remove_passed_obstacles() {
  DetectedObstacles& detected = context_.simulator.detected();
  if (detected.empty() || !context_.simulator.zone()) return;
  const zone::VehicleShape& shape = context_.simulator.zone()->vehicle;
  for (const AivProxy& proxy : context_.registry) {
    if (!proxy.here() || proxy.augmented() || !proxy.online() || proxy.lost(context_.now, context_.options.lost_after))
      continue;
    const Pose2 X_MB = context_.simulator.image(*proxy.twin(), context_.now).X_MB;
    if (detected.pass(proxy.name(), context_.now, X_MB, shape.length_m, shape.width_m) == 0) continue;
    context_.traces.add(context_.now, proxy.name(), "Simulator", "passed",
                        "an obstacle is removed: the vehicle drove over its position");
  }
}

}  // namespace cosiva::virtual_side
