#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/onboard/onboard_options.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// The on-board program (TSVA, A14): dispatches inputs to its parts and publishes what they decide. Ports:
/// port_name(number, board) for each board. Ticks once in a cycle.
///
/// Invariant: a zone is in force exactly while there is a context to drive in.
class OnboardCore final : public wire::Core {
 public:
  explicit OnboardCore(OnboardOptions options);
  ~OnboardCore() override;

  void handle(const wire::Input& input, wire::Effects& effects) override;
  [[nodiscard]] SimDuration tick_period() const override;
  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  [[nodiscard]] std::optional<wire::Will> will() const override;
  void farewell(SimTime now, wire::Effects& effects) override;
  void fold(Digest& digest) const override;

  [[nodiscard]] const OnboardOptions& options() const;
  /// The position that was saved last, where messages pass as values and no effect is emitted; empty: none yet.
  [[nodiscard]] std::string persisted_bytes() const;
  [[nodiscard]] std::vector<std::string> ports() const;
  /// The estimated pose; nothing until the position is known. For experiments and tests.
  [[nodiscard]] std::optional<Pose2> estimated_pose() const;
  [[nodiscard]] double estimated_speed_mps() const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  SimTime now_{};  ///< of the last input
};

}  // namespace cosiva::aiv
