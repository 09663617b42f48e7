#pragma once

#include <memory>

#include "cosiva/base/digest.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::aiv {

/// A zone configuration as the RTM that was built from it, for an on-board program in the process that built it
/// (virtual AIVs): the program does not read the zone's file again.
/// Invariant: the RTM is not null.
class AnnouncedZone final : public wire::InProcessMessage {
 public:
  /// @param rtm  not null (checked)
  explicit AnnouncedZone(std::shared_ptr<const zone::Rtm> rtm);
  [[nodiscard]] const std::shared_ptr<const zone::Rtm>& rtm() const { return rtm_; }
  void fold(Digest& digest) const override;

 private:
  std::shared_ptr<const zone::Rtm> rtm_;
};

}  // namespace cosiva::aiv
