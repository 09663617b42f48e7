#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "aiv/speed.h"
#include "base/result.h"

namespace cosiva::aiv {

/// What a vehicle keeps over a crash of its program. The odometer counts on in its board meanwhile, so place and
/// odometer together tell where it stands now, as long as the board's session is the same.
struct Memory {
  std::string zone;
  std::string section;
  double s_m{};
  std::int64_t odometer_um{};
  std::uint32_t session{};
  bool paused{};                   ///< somebody stopped it: it stays stopped
  std::optional<Profile> imposed;  ///< and stays slow
  friend bool operator==(const Memory&, const Memory&) = default;
};
[[nodiscard]] std::string to_json(const Memory& memory);
/// Fails with code "memory.*" on what is no memory.
[[nodiscard]] Result<Memory> memory_from_json(std::string_view json);

}  // namespace cosiva::aiv
