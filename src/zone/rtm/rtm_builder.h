#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "cosiva/base/result.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::zone {

/// Builds the RTMs of one core and stores the last result: the part that checks a configuration and the part that
/// brings it into force get the same object, so that a zone switch reads the zone's file once. Invariant: the stored
/// RTM was built from its own configuration(), and the stored error is of the configuration stored with it.
class RtmBuilder {
 public:
  RtmBuilder() = default;
  /// @param built  built before this core began; may be null
  explicit RtmBuilder(std::shared_ptr<const Rtm> built) : built_{std::move(built)} {}

  /// Takes what was built elsewhere, on another thread perhaps: build() returns it for an equal configuration.
  /// @param built  of this configuration (checked), not null
  void take(const ZoneConfiguration& configuration, const Result<std::shared_ptr<const Rtm>>& built);
  /// The RTM of the configuration, never null, or the factory's error. The last result is returned again for an equal
  /// configuration.
  [[nodiscard]] Result<std::shared_ptr<const Rtm>> build(const ZoneConfiguration& configuration);

  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Refused {
    ZoneConfiguration configuration;
    Error error;
  };
  std::shared_ptr<const Rtm> built_;
  std::optional<Refused> refused_;
};

}  // namespace cosiva::zone
