#include "cosiva/virtual/server/registry/received_headers.h"

#include <charconv>
#include <utility>

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

}  // namespace

bool ReceivedHeaders::readable(std::string_view version) { return major_of(version) == 2; }

std::uint32_t ReceivedHeaders::on_header(VehicleTopic topic, const wire::Header& header) {
  if (!header.version.empty() && header.version != version_) {
    COSIVA_EXPECT(readable(header.version));
    version_ = header.version;
  }
  std::optional<std::uint32_t>& last = last_id_[static_cast<std::size_t>(topic)];
  const std::optional<std::uint32_t> before = std::exchange(last, header.header_id);
  if (!before) return 0;
  // Counts modulo 2³²; a large step is a restart or an old message, not thousands of lost ones.
  const std::uint32_t step = header.header_id - *before;
  return step > 1 && step <= MessageCounters::missed_per_message_max ? step - 1 : 0;
}

void ReceivedHeaders::archive(Archive& archive) { archive(last_id_, version_); }

}  // namespace cosiva::virtual_side
