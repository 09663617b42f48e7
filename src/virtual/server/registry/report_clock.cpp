#include "cosiva/virtual/server/registry/report_clock.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::uint32_t gaps_smoothed = 10;

}  // namespace

void ReportClock::on_report(SimTime now) {
  COSIVA_EXPECT(now >= last_);
  const SimDuration gap = now - last_;
  if (!first_) {
    first_ = now;
  } else if (gap < gap_max) {
    gaps_ = std::min(gaps_ + 1, gaps_smoothed);
    usual_gap_ += (gap - usual_gap_) / gaps_;
  }
  last_ = now;
}

SimDuration ReportClock::longest_silence(SimDuration at_least) const {
  return std::max(at_least, from_seconds(gaps_until_lost * to_seconds(usual_gap_)));
}

}  // namespace cosiva::virtual_side
