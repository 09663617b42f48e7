#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// Logs faulty messages with one line per kind of fault: a sender that errs does so ten times a second.
///
/// Invariant: each kind is kept once, and at most `kinds_max` kinds are.
class ErrorLog {
 public:
  static constexpr std::size_t kinds_max = 16;

  void report(std::string kind, std::string_view text, wire::Effects& effects);
  /// Each kind may be logged again.
  void clear() { kinds_.clear(); }

 private:
  std::vector<std::string> kinds_;
};

}  // namespace cosiva::aiv
