#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// An AIV that exists on the virtual side only (A3): the agent of the physical ones, unchanged, behind simulated
/// boards. It drives exactly what it is told along the circuit, reads tags and beacons as PRAV would, and feels
/// everything else through Ahead, as physical AIVs feel it. Deterministic; it has no chance of its own.
class VirtualAiv {
 public:
  /// @param number  of its boards' ports; any, unique in the server
  /// @param zone    one that a circuit factory made a zone of already (checked)
  /// @param start   where it stands at first; on this zone's circuit
  /// @param interface_name  of its VDA 5050 topics; empty: wire::default_interface
  /// @param rules   by what it chooses its speed; custom ones can be used (checked)
  /// @param v2x     it talks with those near it
  VirtualAiv(std::string serial, std::uint32_t number, zone::ZoneConfiguration zone, zone::TrackPosition start,
             std::string interface_name = {}, aiv::SpeedRules rules = {}, bool v2x = true);
  ~VirtualAiv();
  VirtualAiv(VirtualAiv&&) noexcept;
  VirtualAiv& operator=(VirtualAiv&&) noexcept;

  [[nodiscard]] const wire::VehicleId& id() const;

  /// The server's link: ONLINE and its factsheet follow, or silence.
  void link(SimTime now, bool up, wire::Effects& effects);
  /// A message on a topic that the on-board program subscribes to.
  void message(SimTime now, const std::string& topic, const std::string& payload, wire::Effects& effects);
  /// With another configuration of the same ways (zone::same_geometry) it goes on driving. On other ways it comes to
  /// rest, and is then on the new floor, its pose as it was: beside the line, until it is sent off and seeks it.
  void zone(SimTime now, const zone::ZoneConfiguration& zone, wire::Effects& effects);
  /// Every 20 ms: body, boards, on-board program. Only Publish and Log come out.
  void tick(SimTime now, wire::Effects& effects);
  /// It is taken away: OFFLINE.
  void farewell(SimTime now, wire::Effects& effects);

  [[nodiscard]] Pose2 X_MB() const;  // NOLINT(readability-identifier-naming): frames are written so everywhere
  [[nodiscard]] double speed_mps() const;
  /// Off the line: the nearest.
  [[nodiscard]] zone::TrackPosition put() const;
  void fold(Digest& digest) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::virtual_side
