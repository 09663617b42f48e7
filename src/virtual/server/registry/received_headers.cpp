#include "cosiva/virtual/server/registry/received_headers.h"

#include <charconv>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/registry/message_counters.h"

namespace cosiva::virtual_side {
namespace {

/// The major version of "2.1.0", "2.0.0", "v2"; nothing where there is none.
std::optional<int> major_of(std::string_view version) {
  if (version.starts_with('v') || version.starts_with('V')) version.remove_prefix(1);
  int major = 0;
  const auto [end, error] = std::from_chars(version.data(), version.data() + version.size(), major);
  if (error != std::errc{}) return std::nullopt;
  if (end != version.data() + version.size() && *end != '.') return std::nullopt;
  return major;
}

/// The lowest `count` bits.
std::uint64_t ones(std::uint32_t count) { return count < 64 ? (std::uint64_t{1} << count) - 1 : ~std::uint64_t{0}; }

}  // namespace

bool ReceivedHeaders::readable(std::string_view version) { return major_of(version) == 2; }

ReceivedHeaders::Gap ReceivedHeaders::on_header(VehicleTopic topic, const wire::Header& header) {
  if (!header.version.empty() && header.version != version_) {
    COSIVA_EXPECT(readable(header.version));
    version_ = header.version;
  }
  std::optional<std::uint32_t>& newest = newest_id_[static_cast<std::size_t>(topic)];
  std::uint64_t& missing = missing_[static_cast<std::size_t>(topic)];
  if (!newest) {
    newest = header.header_id;
    return {};
  }
  // Counts modulo 2³².
  const std::uint32_t behind = *newest - header.header_id;
  if (behind == 0) return {};
  if (behind <= overtaken_max) {
    const std::uint64_t bit = std::uint64_t{1} << (behind - 1);
    const bool late = (missing & bit) != 0;
    missing &= ~bit;
    return {0, late};
  }
  const std::uint32_t step = header.header_id - *newest;
  newest = header.header_id;
  missing = step < overtaken_max ? missing << step : 0;
  // A large step is a restart or an old message, not thousands of lost ones.
  if (step > MessageCounters::missed_per_message_max) return {};
  missing |= ones(step - 1);
  return {step - 1, false};
}

void ReceivedHeaders::archive(Archive& archive) { archive(newest_id_, missing_, version_, senders_); }

}  // namespace cosiva::virtual_side
