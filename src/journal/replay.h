#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// The result of a replay.
struct Replayed {
  std::string digest;
  std::optional<std::string> recorded_digest;
  std::uint64_t inputs{};
  bool truncated{false};
};
/// Runs a core over every input. `make_core` makes the core from the first input, which must be `configure` (else
/// "journal.configure") and is part of the run. `after` (if given) is called at the end with the core.
[[nodiscard]] Result<Replayed> replay(
    std::string_view bytes, const std::function<Result<std::unique_ptr<wire::Core>>(const wire::Input&)>& make_core,
    const std::function<void(wire::Core&)>& after = {});

}  // namespace cosiva::journal
