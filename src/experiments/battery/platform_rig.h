#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/experiments/battery/procedure.h"
#include "cosiva/experiments/battery/virtual_rig.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::experiments {

/// A test with the whole platform in the loop, in virtual time: the vehicles drive on the circuit to the end, and the
/// procedure receives what they publish (their boards' reports, twice per second). A vehicle whose run has ended gets a
/// service battery at once and continues as traffic: it blocks no vehicle, and the others' load stays unchanged. Same
/// options, same bits.
class PlatformRig {
 public:
  /// Fails where the world cannot be made, or its fleet is not complete in two minutes.
  [[nodiscard]] static Result<PlatformRig> make(WorldOptions world, VirtualRigOptions options);
  ~PlatformRig();
  PlatformRig(PlatformRig&&) noexcept;
  PlatformRig& operator=(PlatformRig&&) noexcept;

  void step();  ///< half a second
  [[nodiscard]] bool done() const;
  [[nodiscard]] SimTime now() const;
  [[nodiscard]] const Procedure& procedure() const;
  [[nodiscard]] const std::vector<TrueEnd>& ground_truth() const;
  [[nodiscard]] std::vector<std::string> take_messages();
  /// For tests that intervene: kill a vehicle, cause message loss.
  [[nodiscard]] World& world();

 private:
  struct Impl;
  explicit PlatformRig(std::unique_ptr<Impl> inside);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::experiments
