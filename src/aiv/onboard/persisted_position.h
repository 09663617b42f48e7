#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

namespace cosiva::aiv {

/// What a vehicle keeps over a crash of its program. The odometer counts on in its board meanwhile, so place and
/// odometer together tell where it stands now, as long as the board's session is the same.
struct PersistedPosition {
  std::string zone;
  std::string section;
  double s_m{};
  std::int64_t odometer_um{};
  std::uint32_t session{};
  bool paused{};                   ///< somebody stopped it: it stays stopped
  std::optional<Profile> imposed;  ///< and stays slow
  std::optional<Pose2> pose{};     ///< X_MB when the odometer read that; memories of old have none
  /// It stood beside the line, or away from it: the pose counts, not the place.
  bool off_path{};
  /// PILS was in a manoeuvre that had come this far.
  std::optional<Pose2> manoeuvre{};
  std::optional<std::string> next{};  ///< the section that its way led to
  friend bool operator==(const PersistedPosition&, const PersistedPosition&) = default;
};
[[nodiscard]] std::string to_json(const PersistedPosition& persisted);
/// Fails with code "memory.*" on what is no memory.
[[nodiscard]] Result<PersistedPosition> persisted_position_from_json(std::string_view json);

}  // namespace cosiva::aiv
