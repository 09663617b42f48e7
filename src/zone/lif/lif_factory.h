#pragma once

#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::zone {

inline constexpr std::size_t lif_bytes_max = 64U << 20U;

/// VDMA LIF, the Layout Interchange Format, 1.0 and the draft of 2.0: docs/guide/zones.md states which parts are read.
class LifCircuitFactory final : public CircuitFactory {
 public:
  [[nodiscard]] std::string_view format() const override { return "lif"; }
  [[nodiscard]] std::vector<std::string_view> file_endings() const override { return {".lif.json", ".json"}; }
  [[nodiscard]] Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override;
  [[nodiscard]] Result<std::shared_ptr<const DrawableCircuit>> make_circuit(
      const ZoneConfiguration& configuration) const override;
  [[nodiscard]] Result<ZoneConfiguration> written(const TrafficZone& zone,
                                                  std::vector<Diagnostic>& lost) const override;
  [[nodiscard]] Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration,
                                                 const ZoneEdit& edit) const override;
};

}  // namespace cosiva::zone
