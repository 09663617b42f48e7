#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/virtual/server/augmented/restored_aivs.h"
#include "cosiva/virtual/server/augmented/virtual_fleet.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// A requested change of the virtual objects (A3), read and validated.
struct VirtualObjectCommand {
  enum class Act { add, move, remove };
  Act act{Act::add};
  std::string id;  ///< in `remove`, "*" means all
  bool is_aiv{false};
  VirtualObjectKind kind{VirtualObjectKind::person};
  double radius_m{};
  Walk walk;                     ///< of a person or an obstacle
  zone::TrackPosition position;  ///< of an AIV
};

/// Reads commands about virtual objects and rejects invalid ones with a message that states the remedy. Reading changes
/// no state.
class VirtualObjectCommands {
 public:
  static constexpr double off_zone_m = 0.5;      ///< maximum distance of a virtual object beyond the drawing's bounds
  static constexpr double off_circuit_m = 0.30;  ///< maximum distance of a new virtual AIV from the circuit
  static constexpr double radius_m_min = 0.02;
  static constexpr double radius_m_max = 1.0;
  static constexpr double speed_mps_max = 3.0;

  VirtualObjectCommands(const Registry& registry, const Simulator& simulator, const VirtualFleet& fleet,
                        const RestoredAivs& restored, const MessagePublisher& publisher)
      : registry_{registry}, simulator_{simulator}, fleet_{fleet}, restored_{restored}, publisher_{publisher} {}

  [[nodiscard]] Result<VirtualObjectCommand> read(const AddCommand& command) const;
  [[nodiscard]] Result<VirtualObjectCommand> read(const MoveCommand& command) const;
  [[nodiscard]] Result<VirtualObjectCommand> read(const RemoveCommand& command) const;
  /// The next free "V1", "P1", "O1".
  [[nodiscard]] std::string next_id(std::string_view kind) const;
  /// The virtual AIV of this serial number, or of "CoSiVA.virtual/<serial>".
  [[nodiscard]] const VirtualFleet::Host* find_aiv(std::string_view id) const;
  /// Whether a virtual AIV may be added at this track position: fails with the reason.
  [[nodiscard]] Result<void> check_position(zone::TrackPosition position) const;
  /// Whether every other vehicle is far enough away from this track position.
  [[nodiscard]] bool has_room(zone::TrackPosition position) const;
  /// The permitted track position with the most room; nothing if no position has room.
  [[nodiscard]] std::optional<zone::TrackPosition> roomiest() const;
  /// A point on the zone's drawing, or at most 0.5 m outside it. Fails on a coordinate that is missing.
  [[nodiscard]] Result<Point2> read_point(OptionalNumber x_m, OptionalNumber y_m, std::string_view field) const;

 private:
  struct NearbyVehicle {
    std::string name;
    Point2 at;
    std::optional<zone::TrackPosition> position;
  };
  [[nodiscard]] std::vector<NearbyVehicle> nearby_vehicles() const;
  [[nodiscard]] bool has_room(zone::TrackPosition position, Point2 at, const NearbyVehicle& other) const;
  [[nodiscard]] Result<void> check_id(std::string_view id) const;
  [[nodiscard]] Result<void> check_zone() const;
  [[nodiscard]] Result<zone::TrackPosition> read_aiv_position(const VirtualObjectFields& virtual_object) const;
  [[nodiscard]] Result<std::optional<zone::TrackPosition>> read_section(
      const VirtualObjectFields& virtual_object) const;
  [[nodiscard]] Result<Walk> read_walk(const VirtualObjectFields& virtual_object, bool may_walk,
                                       const Walk& usual) const;
  [[nodiscard]] Result<std::vector<Point2>> read_path(const std::vector<std::optional<Point2>>& path) const;
  /// Whether a virtual object has this id, or a virtual AIV that is in the zone or waits to be restored.
  [[nodiscard]] bool in_use(std::string_view id) const;
  [[nodiscard]] std::string known_virtual_objects() const;

  const Registry& registry_;
  const Simulator& simulator_;
  const VirtualFleet& fleet_;
  const RestoredAivs& restored_;
  const MessagePublisher& publisher_;  ///< source of the current time
};

}  // namespace cosiva::virtual_side
