#include "cosiva/virtual/server/registry/report_clock.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::uint32_t gaps_smoothed = 10;

}  // namespace

void ReportClock::on_report(SimTime now, SimTime reported_at) {
  COSIVA_EXPECT(now >= last_);
  COSIVA_EXPECT(reported_at <= now);
  const SimDuration gap = now - last_;
  if (!first_) {
    first_ = now;
  } else if (gap < gap_max) {
    gaps_ = std::min(gaps_ + 1, gaps_smoothed);
    usual_gap_ += (gap - usual_gap_) / gaps_;
  }
  last_ = now;
  reported_at_ = std::max(reported_at_, reported_at);
  COSIVA_EXPECT(usual_gap_ > SimDuration::zero() && usual_gap_ <= gap_max);
}

SimDuration ReportClock::longest_silence(SimDuration at_least) const {
  return std::max(at_least, from_seconds(gaps_until_lost * to_seconds(usual_gap_)));
}

void ReportClock::archive(Archive& archive) { archive(first_, last_, reported_at_, usual_gap_, gaps_); }

}  // namespace cosiva::virtual_side
