#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/zone/geometry/section_kinds.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/toml/toml_fields.h"

namespace cosiva::zone {

/// Of one [circuit], or several [[circuit]] of a zone: sections of one are laid end to end.
struct TomlCircuit {
  std::string name;  ///< empty: the only one, which need not have any
  bool closed{false};
  Pose2 follows;                      ///< the start of its next section
  std::vector<SectionId> sections{};  ///< in the file's order
};

/// Reads [circuit], [[circuit]] and [[section]]: the graph of sections.
class TomlTracks {
 public:
  TomlTracks(TomlFaults& faults, const TomlFields& root, std::string name, const VehicleShape& vehicle)
      : faults_{faults}, root_{root}, name_{std::move(name)}, vehicle_{vehicle} {}

  /// Nothing after leaving faults: gaps between ends, or bends that are too tight, all of them.
  [[nodiscard]] std::optional<Circuit> read();

  /// The loops of named closed circuits. A circuit that does not close leaves a fault.
  [[nodiscard]] std::vector<Loop> loops(const Circuit& circuit) const;
  /// Ids of waypoints that sections name.
  [[nodiscard]] WaypointRules rules() const { return rules_; }

 private:
  void read_circuits();
  void read_sections();
  void read_section(const TomlFields& fields);
  void read_circuit_of(const TomlFields& fields);
  /// The start of the section: at `start`, at the end of the section `from`, or at the present end of its circuit.
  [[nodiscard]] Pose2 start_of(const TomlFields& fields, const TomlCircuit& circuit);
  [[nodiscard]] std::optional<Section> read_shape(const TomlFields& fields, const Pose2& follows) const;
  [[nodiscard]] Result<Section> read_shaped(const TomlFields& fields, const ShapedKind& kind,
                                            const Pose2& follows) const;
  void read_waypoint_ids(const TomlFields& fields, SectionId id);
  void read_successors();
  void add_successor(SectionId id, std::string_view name, std::string_view key, SectionId said_by);
  void check_vehicle_fits() const;
  [[nodiscard]] std::optional<Circuit> join();
  void list_bad_joints() const;

  TomlFaults& faults_;
  const TomlFields& root_;
  std::string name_;
  VehicleShape vehicle_;
  std::vector<TomlCircuit> circuits_;
  std::size_t here_{0};  ///< the circuit of the section being read
  std::vector<TomlFields> entries_;
  std::vector<Circuit::Part> parts_;
  std::vector<SectionId> from_;  ///< by section: the one whose end it branches off from; no_section: none
  std::map<std::string, SectionId, std::less<>> by_name_;  ///< those read so far; of two with one name the first
  WaypointRules rules_;
  double turned_rad_{0.0};
  double length_m_{0.0};
};

}  // namespace cosiva::zone
