#include "cosiva/zone/rtm/prepared_factory.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {

PreparedFactory::PreparedFactory(ZoneConfiguration configuration, const CircuitFactory& factory,
                                 std::shared_ptr<const DrawableCircuit> circuit)
    : configuration_{std::move(configuration)}, factory_{&factory}, circuit_{std::move(circuit)} {
  COSIVA_EXPECT(circuit_ != nullptr && circuit_->zone() != nullptr);
}

Result<std::shared_ptr<const PreparedFactory>> PreparedFactory::make(ZoneConfiguration configuration,
                                                                     const CircuitFactory& factory) {
  auto circuit = factory.make_circuit(configuration);
  if (!circuit) return tl::unexpected(std::move(circuit).error());
  return std::shared_ptr<const PreparedFactory>{
      new PreparedFactory{std::move(configuration), factory, std::move(*circuit)}};
}

Result<std::shared_ptr<const DrawableCircuit>> PreparedFactory::make_circuit(
    const ZoneConfiguration& configuration) const {
  if (configuration == configuration_) return circuit_;
  return factory_->make_circuit(configuration);
}

}  // namespace cosiva::zone
