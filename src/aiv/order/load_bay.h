#pragma once

#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::aiv {

/// The loads on a vehicle: one on each load handling device at most (VDA 5050 2.1 §6.10.6, loads).
/// Invariant: each load is on one of the vehicle's devices, and no device carries two.
class LoadBay {
 public:
  /// @param positions  the names of the load handling devices; each once
  explicit LoadBay(std::vector<std::string> positions) : positions_{std::move(positions)} {}

  /// The load of a pick (parameters loadId, loadType, lhd; without lhd the first free device). Fails ("load.occupied")
  /// where the device, or every device, carries a load.
  [[nodiscard]] Result<wire::Load> room_for(const wire::Action& pick) const;
  /// Takes the load on board. Fails as room_for().
  [[nodiscard]] Result<wire::Load> pick(const wire::Action& pick);
  /// The load that a drop refers to (parameters lhd, loadId and loadType; each that is given must agree). Fails
  /// ("load.none") where the vehicle carries no such load.
  [[nodiscard]] Result<wire::Load> load_for(const wire::Action& drop) const;
  /// Takes the load off. Fails as load_for().
  [[nodiscard]] Result<wire::Load> drop(const wire::Action& drop);

  /// In the order of the devices.
  [[nodiscard]] const std::vector<wire::Load>& loads() const { return loads_; }
  [[nodiscard]] const std::vector<std::string>& positions() const { return positions_; }
  /// What was saved before a restart; loads on devices that the vehicle does not have are left out.
  void restore(const std::vector<wire::Load>& loads);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] bool carries(const std::string& position) const;
  void put(wire::Load load);

  std::vector<std::string> positions_;
  std::vector<wire::Load> loads_;
};

}  // namespace cosiva::aiv
