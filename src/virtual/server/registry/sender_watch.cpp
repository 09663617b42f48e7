#include "cosiva/virtual/server/registry/sender_watch.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// A message that was overtaken in transit is at most so many numbers behind.
constexpr std::uint32_t overtaken_max = 64;
constexpr std::uint32_t half_of_all_ids = std::uint32_t{1} << 31U;

}  // namespace

void SenderWatch::on_message(VehicleTopic topic, const wire::Header& header, SimTime now) {
  std::optional<Newest>& newest = newest_[static_cast<std::size_t>(topic)];
  const Newest next{header.header_id, header.timestamp};
  if (!newest) {
    newest = next;
    return;
  }
  const std::uint32_t behind = newest->id - next.id;  // counts modulo 2³²
  const bool is_lower = behind != 0 && behind < half_of_all_ids;
  const bool went_back = is_lower && (behind > overtaken_max || next.sent >= newest->sent);
  if (went_back || !is_lower) newest = next;
  if (!went_back) return;
  const auto before = std::exchange(went_back_at_[static_cast<std::size_t>(topic)], now);
  COSIVA_EXPECT(!before || *before <= now);
  if (!before || now - *before > window) return;
  if (!several_since(now)) several_since_ = *before;
  several_until_ = now + window;
}

std::optional<SimTime> SenderWatch::several_since(SimTime now) const {
  return several_until_ && now <= *several_until_ ? several_since_ : std::nullopt;
}

void SenderWatch::archive(Archive& archive) { archive(newest_, went_back_at_, several_since_, several_until_); }

}  // namespace cosiva::virtual_side
