#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/layout/drawable_circuit.h"

namespace cosiva::zone {

/// The factory of one format that has already made the circuit of one configuration, perhaps on another thread: it is
/// made once, however often it is requested. Invariant: circuit() is that of configuration().
class PreparedFactory final : public CircuitFactory {
 public:
  /// Lets the factory of the format make the circuit. Fails as that does.
  /// @param factory  must outlive the result
  [[nodiscard]] static Result<std::shared_ptr<const PreparedFactory>> make(ZoneConfiguration configuration,
                                                                           const CircuitFactory& factory);

  [[nodiscard]] const ZoneConfiguration& configuration() const { return configuration_; }
  [[nodiscard]] const DrawableCircuit& circuit() const { return *circuit_; }

  std::string_view format() const override { return factory_->format(); }
  std::vector<std::string_view> file_endings() const override { return factory_->file_endings(); }
  Result<ZoneConfiguration> written(const TrafficZone& zone, std::vector<Diagnostic>& lost) const override {
    return factory_->written(zone, lost);
  }
  Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override {
    return factory_->make_zone(configuration);
  }
  /// The prepared circuit for the configuration that it was prepared of; any other one is made.
  Result<std::shared_ptr<const DrawableCircuit>> make_circuit(const ZoneConfiguration& configuration) const override;
  std::vector<Error> faults(const ZoneConfiguration& configuration) const override {
    return factory_->faults(configuration);
  }
  Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration, const ZoneEdit& edit) const override {
    return factory_->edited(configuration, edit);
  }

 private:
  PreparedFactory(ZoneConfiguration configuration, const CircuitFactory& factory,
                  std::shared_ptr<const DrawableCircuit> circuit);

  ZoneConfiguration configuration_;
  const CircuitFactory* factory_;
  std::shared_ptr<const DrawableCircuit> circuit_;
};

}  // namespace cosiva::zone
