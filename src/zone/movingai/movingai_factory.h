#pragma once

#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::zone {

/// MovingAI maps, as planners of many agents are compared on: docs/guide/zones.md states what becomes of them.
class MovingAiCircuitFactory final : public CircuitFactory {
 public:
  [[nodiscard]] std::string_view format() const override { return "movingai"; }
  [[nodiscard]] std::vector<std::string_view> file_endings() const override { return {".map"}; }
  /// Fails as read_grid does, and ("circuit.empty") on a map without two free squares side by side, ("zone.size") on
  /// one with too many, ("zone.vehicle") where the squares are too small for the vehicle.
  [[nodiscard]] Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override;
  [[nodiscard]] Result<std::shared_ptr<const DrawableCircuit>> make_circuit(
      const ZoneConfiguration& configuration) const override;
  /// In the sidecar file: the map itself stays unchanged.
  [[nodiscard]] Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration,
                                                 const ZoneEdit& edit) const override;
};

}  // namespace cosiva::zone
