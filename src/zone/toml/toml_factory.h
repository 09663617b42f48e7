#pragma once

#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::zone {

inline constexpr std::size_t toml_bytes_max = 64U << 20U;
inline constexpr std::size_t toml_sections_max = 200'000;

/// CoSiVA's own format, described in docs/guide/zones.md.
class TomlCircuitFactory final : public CircuitFactory {
 public:
  [[nodiscard]] std::string_view format() const override { return "toml"; }
  [[nodiscard]] std::vector<std::string_view> file_endings() const override { return {".toml"}; }
  [[nodiscard]] Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override;
  [[nodiscard]] Result<std::shared_ptr<const DrawableCircuit>> make_circuit(
      const ZoneConfiguration& configuration) const override;
  [[nodiscard]] std::vector<Error> faults(const ZoneConfiguration& configuration) const override;
  /// Reads back as the same zone, to the last bit, except for its diagnostics.
  [[nodiscard]] Result<ZoneConfiguration> written(const TrafficZone& zone,
                                                  std::vector<Diagnostic>& lost) const override;
  [[nodiscard]] Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration,
                                                 const ZoneEdit& edit) const override;
};

}  // namespace cosiva::zone
