#pragma once

#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::zone {

/// ASAM OpenDRIVE: docs/guide/zones.md states which parts are read.
class OpenDriveCircuitFactory final : public CircuitFactory {
 public:
  [[nodiscard]] std::string_view format() const override { return "opendrive"; }
  [[nodiscard]] std::vector<std::string_view> file_endings() const override { return {".xodr"}; }
  [[nodiscard]] Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override;
  [[nodiscard]] Result<std::shared_ptr<const DrawableCircuit>> make_circuit(
      const ZoneConfiguration& configuration) const override;
  /// In the sidecar file: the file itself stays unchanged.
  [[nodiscard]] Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration,
                                                 const ZoneEdit& edit) const override;
};

}  // namespace cosiva::zone
