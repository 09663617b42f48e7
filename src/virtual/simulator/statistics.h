#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// Count, mean, maximum and percentiles of a stream of numbers ≥ 0, in bounded memory and deterministically.
/// Percentiles are exact for the first `exact_max` samples; after that a histogram of fixed buckets (64 per octave,
/// from 2⁻²⁴ to 2²⁴) gives them within 0.8 %; the others are always exact. Invariant: either has all samples.
class Statistics {
 public:
  static constexpr std::size_t exact_max = 2048;

  void add(double value);
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean() const { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }
  [[nodiscard]] double max() const { return max_; }
  /// By nearest rank: the smallest sample such that at least `ratio` ∈ (0, 1] of all samples are not above it. 0 if
  /// none.
  [[nodiscard]] double percentile(double ratio) const;

  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::uint64_t count_{0};
  double sum_{0.0};
  double max_{0.0};
  std::vector<double> exact_;
  std::vector<std::uint32_t> buckets_;  ///< empty while `exact_` holds everything
};

/// {"count","mean","p50","p99","max"}.
void write_json(JsonWriter& json, const Statistics& statistics);

/// Reports whether the p99 of the last `window` samples is above a limit, in constant time: this is the case exactly
/// when more than 1 % of them are above. Invariant: no more are above than there are, at most `window`.
class RecentP99 {
 public:
  /// A violation is no longer displayed after this time without a value above the limit. With the period of the
  /// snapshots and of the page's lists, a display is green again within 5 s.
  static constexpr SimDuration recovery{std::chrono::seconds{4}};

  RecentP99(double limit, std::size_t window) : limit_{limit}, over_(window, false) {}

  void add(double value, SimTime at);
  [[nodiscard]] bool held() const { return over_count_ * 100 <= filled_; }
  /// Whether a display shows the limit as violated: the p99 is above it, and so was a value of the last seconds. The
  /// window alone would show a short overload until its last sample has left the window: 100 commands later, or 200
  /// reports.
  [[nodiscard]] bool violated(SimTime now) const { return !held() && last_over_ && now - *last_over_ < recovery; }
  /// Continues a restored state: when its last value was above the limit is not stored, and may have been just now.
  void continue_at(SimTime now) { last_over_ = now; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  double limit_;
  std::vector<bool> over_;
  std::size_t next_{0};
  std::size_t filled_{0};
  std::size_t over_count_{0};
  std::optional<SimTime> last_over_;
};

}  // namespace cosiva::virtual_side
