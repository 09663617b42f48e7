#pragma once

#include "zone/circuit_factory.h"

namespace cosiva::zone {

/// ASAM OpenDRIVE: docs/guide/zones.md says what is taken of it.
class OpenDriveCircuitFactory final : public CircuitFactory {
 public:
  [[nodiscard]] std::string_view format() const override { return "opendrive"; }
  [[nodiscard]] std::vector<std::string_view> file_endings() const override { return {".xodr"}; }
  [[nodiscard]] Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override;
};

}  // namespace cosiva::zone
