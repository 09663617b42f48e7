// What is added only virtually (A3): persons, obstacles, virtual AIVs.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/virtual/server/core/inside.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

/// A virtual AIV's last place is up to a second old; somebody may stand there by now.
constexpr double recalled_shift_m = 1.0;
constexpr double recalled_step_m = 0.05;

}  // namespace

void ServerCore::Inside::follow(const ThingCommand& asked) {
  state_stale = true;
  Augmented& world = simulator.augmented();
  const auto tell = [&](std::string_view what) {
    traces.add(now, "AIV_Server", "Simulator", what, asked.id == "*" ? std::string("everything") : asked.id);
  };
  switch (asked.act) {
    case ThingCommand::Act::add:
      tell("add");
      if (asked.is_aiv)
        add_aiv(asked.id, asked.place);
      else
        world.add({asked.id, asked.kind, 0, asked.radius_m, asked.walk, now, now});
      break;
    case ThingCommand::Act::move:
      tell("move");
      world.move(asked.id, asked.walk, now);
      break;
    case ThingCommand::Act::remove:
      tell("remove");
      if (asked.id == "*") {
        world.clear();
        recalled_aivs.clear();
        while (!hosted.empty()) remove_aiv(hosted.hosts().back().vehicle);
      } else if (asked.is_aiv) {
        remove_aiv(objects.find_aiv(asked.id)->vehicle);
      } else {
        world.remove(asked.id);
      }
      break;
  }
}

bool ServerCore::Inside::add_aiv(const std::string& serial, zone::Place place) {
  const auto vehicle = vehicles.begin_life({std::string(wire::virtual_manufacturer), serial});
  if (!vehicle) return false;
  hosted.add(*vehicle, now, link.up(), *simulator.configuration(), place);
  simulator.monitor().set_augmented(hosted.hosts().size());
  publisher.log('i', registry[*vehicle].name + ": added at " + simulator.circuit()->part(place.section).name + ", " +
                         std::to_string(place.s_m) + " m");
  return true;
}

void ServerCore::Inside::remove_aiv(VehicleIndex vehicle) {
  hosted.remove(vehicle, now);
  simulator.monitor().set_augmented(hosted.hosts().size());
  const std::string& name = registry[vehicle].name;
  vehicles.retire(vehicle, name + " has been taken away");
  publisher.log('i', name + ": taken away");
}

void ServerCore::Inside::place_recalled_aivs() {
  if (!simulator.zone()) return;
  const zone::Circuit& circuit = *simulator.circuit();
  for (const RecalledAiv& aiv : std::exchange(recalled_aivs, {})) {
    if (objects.find_aiv(aiv.serial) != nullptr) continue;
    std::optional<zone::Place> found;
    if (const auto section = circuit.find(aiv.section)) {
      const zone::Place was{*section, std::clamp(aiv.s_m, 0.0, circuit.section(*section).length_m())};
      // Where it stood it may stand again, a crossing included: it had been let into it.
      if (objects.has_room(was)) found = was;
      for (double d = recalled_step_m; !found && d <= recalled_shift_m; d += recalled_step_m) {
        for (const double shift : {d, -d}) {
          const zone::Place near = circuit.advance(was, shift);
          if (!found && objects.check_place(near)) found = near;
        }
      }
    }
    if (!found) found = objects.roomiest();
    if (!found || !add_aiv(aiv.serial, *found))
      publisher.log('w', "virtual AIV " + aiv.serial + " is remembered, but no way has room for it; add it again");
  }
  state_stale = true;
}

void ServerCore::Inside::silence_orphans() {
  // Virtual AIVs of a life that was ended without goodbye, and forgotten: nobody else can say that they are gone.
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    AivProxy& proxy = registry[v];
    if (!proxy.augmented || !proxy.retired || proxy.connection != wire::ConnectionState::online) continue;
    proxy.connection = wire::ConnectionState::offline;
    wire::Connection gone{{0, now, "2.1.0", proxy.id.manufacturer, proxy.id.serial_number},
                          wire::ConnectionState::offline};
    publisher.publish(wire::vda_topic(proxy.id, "connection", registry.interface_name()), wire::vda5050::encode(gone),
                      1, true);
  }
}

void ServerCore::Inside::update_virtual_world() {
  if (!link.up()) return;
  const std::uint64_t before = pauses.changes();
  virtual_obstacles.update();
  state_stale = state_stale || pauses.changes() != before;
}

void ServerCore::Inside::look_for_passed_obstacles() {
  SeenObstacles& seen = simulator.seen();
  if (seen.empty() || !simulator.zone()) return;
  const zone::VehicleShape& shape = simulator.zone()->vehicle;
  for (const AivProxy& proxy : registry) {
    if (!proxy.here() || proxy.augmented || !proxy.online() || proxy.lost(now, options.lost_after)) continue;
    const Pose2 X_MB = simulator.image(*proxy.twin, now).X_MB;
    if (seen.pass(proxy.name, now, X_MB, shape.length_m, shape.width_m) == 0) continue;
    traces.add(now, proxy.name, "Simulator", "passed", "an obstacle is gone: it drove over its place");
  }
}

}  // namespace cosiva::virtual_side
