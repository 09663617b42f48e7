#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/vehicle/virtual_aiv.h"

namespace cosiva::virtual_side {

/// The virtual AIVs that this server hosts (A3). Their messages go to the broker and return from there like those of
/// any vehicle; orders reach them on the same path. The server passes the zone, the heartbeat, the link state and
/// VirtualObstacles to them directly.
///
/// Invariant: each hosted vehicle is a virtual AIV of the registry and is hosted once; between two calls no effect of a
/// hosted AIV waits to be published.
class VirtualFleet {
 public:
  /// @param rules  the rules of their speed choice; must outlive the fleet
  /// @param v2x    whether they exchange V2X messages with vehicles nearby
  /// @param open   whether virtual AIVs may be added
  VirtualFleet(Registry& registry, MessagePublisher& publisher, const aiv::SpeedRules& rules, bool v2x,
               bool open = true)
      : registry_{registry}, publisher_{publisher}, rules_{rules}, v2x_{v2x}, open_{open} {}
  VirtualFleet(const VirtualFleet&) = delete;  // other components hold references to the fleet
  VirtualFleet& operator=(const VirtualFleet&) = delete;

  struct Host {
    VehicleIndex vehicle;
    SimTime since;
    VirtualAiv aiv;
    std::vector<std::string> listens{};  ///< topics of the vehicles nearby (wire::Listen)
  };

  void add(VehicleIndex vehicle, SimTime now, bool link_up, const std::shared_ptr<const zone::Rtm>& rtm,
           zone::TrackPosition start);
  void remove(VehicleIndex vehicle, SimTime now);
  [[nodiscard]] const Host* find(VehicleIndex vehicle) const;
  /// The track position on this circuit, even if the vehicle has yet to change to that circuit.
  [[nodiscard]] static zone::TrackPosition position_of(const Host& host, const zone::Circuit& circuit);
  [[nodiscard]] const std::deque<Host>& hosts() const { return hosts_; }
  [[nodiscard]] bool empty() const { return hosts_.empty(); }
  [[nodiscard]] bool open() const { return open_; }

  void link(SimTime now, bool up);
  void zone(SimTime now, const std::shared_ptr<const zone::Rtm>& rtm);
  /// To all hosted AIVs, such as a heartbeat.
  void message(SimTime now, const std::string& topic, const std::string& payload);
  /// To one hosted AIV.
  void message(SimTime now, VehicleIndex vehicle, const std::string& topic, const std::string& payload);
  /// An order or instant actions from the broker. Returns false if the message is for none of the hosted AIVs.
  bool from_broker(SimTime now, const wire::Input& input);
  /// Passes a V2X message to the hosted AIVs that listen to its topic, except to its sender.
  void talk(SimTime now, const wire::Input& input);
  void tick(SimTime now);
  void farewell(SimTime now);
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void host(VehicleIndex vehicle, SimTime now, const VirtualAiv::Origin& origin);
  Host* find_host(VehicleIndex vehicle);
  void send(Host& host);

  Registry& registry_;
  MessagePublisher& publisher_;
  const aiv::SpeedRules& rules_;
  bool v2x_;
  bool open_;
  std::deque<Host> hosts_;
  wire::Effects effects_;
};

}  // namespace cosiva::virtual_side
