#include "cosiva/virtual/server/registry/message_rate.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// Weight of a new window in the usual rate.
constexpr double smoothing = 0.5;

}  // namespace

double MessageRate::limit_per_s(double per_s_max) const {
  if (!usual_per_s_ && announced_per_s_ <= 0.0) return per_s_max;
  const double known_per_s = std::max(usual_per_s_.value_or(0.0), announced_per_s_);
  return std::min(per_s_max, std::max(per_s_min, usual_multiple * known_per_s));
}

void MessageRate::measure(SimTime now) {
  if (!window_began_) window_began_ = now;
  const SimDuration length = now - *window_began_;
  if (length >= window) {
    const double per_s = in_window_ / to_seconds(length);
    // A window with a flood is no measure of the usual rate, nor is one with a pause: what the vehicle sent
    // meanwhile may have been delayed, and arrive together now.
    const bool flooded = dropped_at_ && *dropped_at_ >= *window_began_;
    const bool paused = usual_per_s_ && now - refilled_at_ > window / 2;
    if (!flooded && !paused) usual_per_s_ = usual_per_s_ ? *usual_per_s_ + smoothing * (per_s - *usual_per_s_) : per_s;
    window_began_ = now;
    in_window_ = 0;
  }
  ++in_window_;
}

MessageRate::Decision MessageRate::on_message(SimTime now, double per_s_max) {
  COSIVA_EXPECT(refilled_at_ <= now && per_s_max >= 0.0);
  if (per_s_max == 0.0) return Decision::accepted;
  const bool first = !window_began_.has_value();
  measure(now);
  const double limit = limit_per_s(per_s_max);
  const double full = std::max(1.0, limit * to_seconds(burst));
  tokens_ = first ? full : std::min(full, tokens_ + limit * to_seconds(now - refilled_at_));
  refilled_at_ = now;
  if (tokens_ >= 1.0) {
    tokens_ -= 1.0;
    return Decision::accepted;
  }
  const bool begins = !flooding(now);
  dropped_at_ = now;
  return begins ? Decision::flood_begins : Decision::dropped;
}

void MessageRate::archive(Archive& archive) {
  archive(announced_per_s_, usual_per_s_, window_began_, in_window_, tokens_, refilled_at_, dropped_at_);
}

}  // namespace cosiva::virtual_side
