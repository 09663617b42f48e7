#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// An AIV that exists on the virtual side only (A3): the unchanged agent of physical AIVs with simulated boards. The
/// virtual AIV executes its commands exactly, reads tags and beacons like PRAV, and perceives everything else through
/// VirtualObstacles, as physical AIVs do. Deterministic, without random numbers. Invariant: a zone is in force.
class VirtualAiv {
 public:
  /// @param number  of its boards' ports; any, unique in the server
  /// @param rtm     of the zone in force; not null (checked)
  /// @param start   the initial track position on this zone's circuit
  /// @param interface_name  of its VDA 5050 topics; empty: wire::default_interface
  /// @param rules   the rules of its speed choice; custom ones can be used (checked)
  /// @param v2x     whether it exchanges V2X messages with vehicles nearby
  VirtualAiv(std::string serial, std::uint32_t number, const std::shared_ptr<const zone::Rtm>& rtm,
             zone::TrackPosition start, std::string interface_name = {}, aiv::SpeedRules rules = {}, bool v2x = true);
  ~VirtualAiv();
  VirtualAiv(VirtualAiv&&) noexcept;
  VirtualAiv& operator=(VirtualAiv&&) noexcept;

  [[nodiscard]] const wire::VehicleId& id() const;

  /// The state of the server's link. If up, ONLINE and the factsheet are published; otherwise nothing is.
  void link(SimTime now, bool up, wire::Effects& effects);
  /// A message on a topic that the on-board program subscribes to.
  void message(SimTime now, const std::string& topic, const std::string& payload, wire::Effects& effects);
  /// The zone is in force from now on. With another configuration of the same geometry (zone::same_geometry) the
  /// virtual AIV continues to drive. With another geometry it stops; its pose is then unchanged on the new floor, off
  /// the path, until it gets an order and seeks the path.
  /// @param rtm  not null (checked)
  void zone(SimTime now, const std::shared_ptr<const zone::Rtm>& rtm, wire::Effects& effects);
  /// Called every 20 ms: body, boards, on-board program. Emits only Publish and Log.
  void tick(SimTime now, wire::Effects& effects);
  /// Called at removal: publishes OFFLINE.
  void farewell(SimTime now, wire::Effects& effects);

  [[nodiscard]] Pose2 X_MB() const;  // NOLINT(readability-identifier-naming): frames are written so everywhere
  [[nodiscard]] double speed_mps() const;
  /// Off the path: the nearest track position.
  [[nodiscard]] zone::TrackPosition track_position() const;
  void fold(Digest& digest) const;
  /// What the virtual AIV was made from, apart from its name, number and options.
  struct Origin {
    std::shared_ptr<const zone::Rtm> rtm;
    zone::TrackPosition start;
  };
  [[nodiscard]] const Origin& origin() const;
  /// The state, for a snapshot: to be read into a virtual AIV of the same origin, name, number and options.
  void archive(Archive& archive);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::virtual_side
