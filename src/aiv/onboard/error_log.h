#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// Logs faulty messages with one line per kind of fault: a faulty sender repeats its fault ten times a second.
///
/// Invariant: each kind is stored once, and at most `kinds_max` kinds are stored.
class ErrorLog {
 public:
  static constexpr std::size_t kinds_max = 16;

  void report(std::string kind, std::string_view text, wire::Effects& effects);
  /// Each kind may be logged again.
  void clear() { kinds_.clear(); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<std::string> kinds_;
};

}  // namespace cosiva::aiv
