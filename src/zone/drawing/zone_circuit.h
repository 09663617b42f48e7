#pragma once

#include <memory>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/drawable_circuit.h"

namespace cosiva::zone {

/// The circuit of a zone that was read from a file; its drawing is that of draw(). Invariant: it has a zone.
class ZoneCircuit final : public DrawableCircuit {
 public:
  /// @param zone  not null
  explicit ZoneCircuit(std::shared_ptr<const TrafficZone> zone);

  const std::shared_ptr<const TrafficZone>& zone() const override { return zone_; }
  std::vector<Primitive> draw() const override;

 private:
  std::shared_ptr<const TrafficZone> zone_;
};

/// The circuit of a zone that a factory has made, or the factory's error.
[[nodiscard]] Result<std::shared_ptr<const DrawableCircuit>> circuit_of(Result<TrafficZone> zone);

}  // namespace cosiva::zone
