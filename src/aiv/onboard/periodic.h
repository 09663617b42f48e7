#pragma once

#include <optional>

#include "cosiva/base/time.h"

namespace cosiva::aiv {

/// Reports when a periodic event is due. A jump of the clock causes no burst.
class Periodic {
 public:
  explicit Periodic(SimDuration period) : period_{period} {}
  /// Whether take() would return true.
  [[nodiscard]] bool due(SimTime now) const { return !next_ || now >= *next_ || *next_ - now > period_; }
  [[nodiscard]] bool take(SimTime now) {
    if (!due(now)) return false;
    next_ = next_ && now - *next_ < period_ ? *next_ + period_ : now + period_;
    return true;
  }
  template <typename Archive>
  void archive(Archive& archive) {
    archive(next_);
  }

 private:
  SimDuration period_;
  std::optional<SimTime> next_;
};

}  // namespace cosiva::aiv
