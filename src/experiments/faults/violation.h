#pragma once

#include <optional>
#include <string>

namespace cosiva::experiments {

/// An invariant that did not hold.
struct Violation {
  std::string invariant;  ///< "I1" to "I10"
  std::string text;
};

/// What a check has found; nothing: the invariant holds.
using Finding = std::optional<Violation>;

}  // namespace cosiva::experiments
