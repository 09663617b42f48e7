#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/vehicle/virtual_aiv.h"

namespace cosiva::virtual_side {

/// The virtual AIVs that live in this server (A3). What they say goes to the broker, and comes back from there like any
/// vehicle's; orders reach them the same way. Zone, heartbeat, link and Ahead are handed to them directly.
class VirtualFleet {
 public:
  /// @param rules  by what they choose their speeds; must outlive the fleet
  /// @param v2x    they talk with those near them
  VirtualFleet(Registry& registry, MessagePublisher& publisher, const aiv::SpeedRules& rules, bool v2x)
      : registry_{registry}, publisher_{publisher}, rules_{rules}, v2x_{v2x} {}
  VirtualFleet(const VirtualFleet&) = delete;  // other parts refer to it
  VirtualFleet& operator=(const VirtualFleet&) = delete;

  struct Host {
    VehicleIndex vehicle;
    SimTime since;
    VirtualAiv aiv;
    std::vector<std::string> listens{};  ///< topics of those near it (wire::Listen)
  };

  void add(VehicleIndex vehicle, SimTime now, bool link_up, const zone::ZoneConfiguration& zone,
           zone::TrackPosition start);
  void remove(VehicleIndex vehicle, SimTime now);
  [[nodiscard]] const Host* find(VehicleIndex vehicle) const;
  /// On this circuit, be it one that the vehicle has yet to change to.
  [[nodiscard]] static zone::TrackPosition position_of(const Host& host, const zone::Circuit& circuit);
  [[nodiscard]] const std::deque<Host>& hosts() const { return hosts_; }
  [[nodiscard]] bool empty() const { return hosts_.empty(); }

  void link(SimTime now, bool up);
  void zone(SimTime now, const zone::ZoneConfiguration& zone);
  /// To all of them, such as a heartbeat.
  void message(SimTime now, const std::string& topic, const std::string& payload);
  /// To one of them.
  void message(SimTime now, VehicleIndex vehicle, const std::string& topic, const std::string& payload);
  /// An order or instant actions from the broker; false: it is for none of them.
  bool from_broker(SimTime now, const wire::Input& input);
  /// What vehicles say to those near them, to those of ours that listen there and did not say it.
  void talk(SimTime now, const wire::Input& input);
  void tick(SimTime now);
  void farewell(SimTime now);
  void fold(Digest& digest) const;

 private:
  Host* find_host(VehicleIndex vehicle);
  void send(Host& host);

  Registry& registry_;
  MessagePublisher& publisher_;
  const aiv::SpeedRules& rules_;
  bool v2x_;
  std::deque<Host> hosts_;
  wire::Effects effects_;
};

}  // namespace cosiva::virtual_side
