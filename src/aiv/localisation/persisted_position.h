#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::aiv {

/// What a vehicle preserves over a crash of its program. The odometer continues to count in its board meanwhile, so
/// position and odometer together give the present position, as long as the board's session is the same.
struct PersistedPosition {
  std::string zone;
  std::string section;
  double s_m{};
  std::int64_t odometer_um{};
  std::uint32_t session{};
  bool paused{};                   ///< the vehicle was paused: it stays stopped
  std::optional<Profile> imposed;  ///< the imposed profile stays in force
  std::optional<Pose2> pose{};     ///< X_MB when the odometer had that reading; old files have none
  /// The vehicle was off-path, or away from all paths: the pose counts, not the position.
  bool off_path{};
  /// PILS was in a manoeuvre that had come this far.
  std::optional<Pose2> manoeuvre{};
  std::optional<std::string> next{};  ///< the section that the route led to
  std::vector<wire::Load> loads{};    ///< on board
  friend bool operator==(const PersistedPosition&, const PersistedPosition&) = default;
};
[[nodiscard]] std::string to_json(const PersistedPosition& persisted);
/// Fails with code "state.*" where the text is not a persisted position.
[[nodiscard]] Result<PersistedPosition> persisted_position_from_json(std::string_view json);

}  // namespace cosiva::aiv
