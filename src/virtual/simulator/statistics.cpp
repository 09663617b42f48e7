#include "cosiva/virtual/simulator/statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

// The exponent and the upper six mantissa bits of a double form a logarithmic bucket number without computing a
// logarithm.
constexpr int mantissa_bits = 6;
constexpr std::uint64_t lowest = std::bit_cast<std::uint64_t>(0x1p-24) >> (52 - mantissa_bits);
constexpr std::uint64_t highest = std::bit_cast<std::uint64_t>(0x1p24) >> (52 - mantissa_bits);
constexpr std::size_t bucket_count = static_cast<std::size_t>(highest - lowest) + 1;

std::size_t bucket_of(double value) {
  if (!(value > 0x1p-24)) return 0;
  const std::uint64_t key = std::bit_cast<std::uint64_t>(value) >> (52 - mantissa_bits);
  return static_cast<std::size_t>(std::min(key, highest) - lowest);
}

double centre_of(std::size_t bucket) {
  const auto edge = [](std::uint64_t key) { return std::bit_cast<double>(key << (52 - mantissa_bits)); };
  return 0.5 * (edge(lowest + bucket) + edge(lowest + bucket + 1));
}

}  // namespace

void Statistics::add(double value) {
  if (!std::isfinite(value)) return;
  value = std::max(value, 0.0);
  ++count_;
  sum_ += value;
  max_ = std::max(max_, value);
  if (buckets_.empty()) {
    if (exact_.size() < exact_max) {
      exact_.push_back(value);
      COSIVA_EXPECT(exact_.size() == count_);
      return;
    }
    buckets_.assign(bucket_count, 0);
    for (const double old : exact_) ++buckets_[bucket_of(old)];
    exact_ = {};
  }
  ++buckets_[bucket_of(value)];
}

double Statistics::percentile(double ratio) const {
  if (count_ == 0) return 0.0;
  const double rank_real = std::ceil(ratio * static_cast<double>(count_) - 1e-9);
  const auto rank = static_cast<std::uint64_t>(std::clamp(rank_real, 1.0, static_cast<double>(count_)));
  if (buckets_.empty()) {
    std::vector<double> sorted = exact_;
    const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::ranges::nth_element(sorted, nth);
    return *nth;
  }
  std::uint64_t detected = 0;
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    detected += buckets_[i];
    if (detected >= rank) return std::min(i == 0 ? 0.0 : centre_of(i), max_);
  }
  return max_;
}

void Statistics::fold(Digest& digest) const {
  digest.add(count_);
  digest.add(sum_);
  digest.add(max_);
}

void write_json(JsonWriter& json, const Statistics& statistics) {
  json.begin_object()
      .field("count", statistics.count())
      .field("mean", statistics.mean())
      .field("p50", statistics.percentile(0.50))
      .field("p99", statistics.percentile(0.99))
      .field("max", statistics.max())
      .end_object();
}

void RecentP99::add(double value, SimTime at) {
  const bool over = value > limit_;
  if (over) last_over_ = at;
  // Most often none is above: the whole window is false then, and stays so.
  if (over || over_count_ > 0) {
    if (over_[next_]) --over_count_;
    over_[next_] = over;
    if (over) ++over_count_;
  }
  filled_ = std::min(filled_ + 1, over_.size());
  COSIVA_EXPECT(over_count_ <= filled_ && filled_ <= over_.size());
  next_ = next_ + 1 == over_.size() ? 0 : next_ + 1;
}

void Statistics::archive(Archive& archive) { archive(count_, sum_, max_, exact_, buckets_); }

void RecentP99::archive(Archive& archive) { archive(limit_, over_, next_, filled_, over_count_); }

}  // namespace cosiva::virtual_side
