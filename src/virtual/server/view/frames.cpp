#include "cosiva/virtual/server/view/frames.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <limits>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::virtual_side {
namespace {

constexpr char magic = 'P';
constexpr char version = 1;
constexpr std::uint16_t key_flag = 1;
constexpr double heading_unit_rad = 1e-4;
constexpr double millimetre = 1e-3;
constexpr unsigned augmented_bit = 4;
constexpr unsigned blocked_bit = 8;

/// Little-endian on every machine.
template <std::unsigned_integral T>
char* put(char* at, T value) {
  const std::uint64_t bits{value};
  for (std::size_t i = 0; i < sizeof value; ++i) at[i] = static_cast<char>((bits >> (8 * i)) & 0xFFU);
  return at + sizeof value;
}

char* put(char* at, float value) { return put(at, std::bit_cast<std::uint32_t>(std::isfinite(value) ? value : 0.0F)); }

char* put_units(char* at, double value, double unit) {
  constexpr double low = std::numeric_limits<std::int16_t>::min();
  constexpr double high = std::numeric_limits<std::int16_t>::max();
  const double units = std::isfinite(value) ? std::clamp(std::nearbyint(value / unit), low, high) : 0.0;
  return put(at, static_cast<std::uint16_t>(static_cast<std::int16_t>(units)));
}

}  // namespace

PositionFrames::PositionFrames(std::uint32_t key_every) : key_every_{std::max(key_every, 1U)} {}

bool PositionFrames::same_handles_as_key() const {
  return std::ranges::equal(now_, key_, [](const Record& a, const Record& b) { return a[0] == b[0] && a[1] == b[1]; });
}

PositionFrames::Frame PositionFrames::encode(double time_ms, std::span<const PositionRecord> records) {
  now_.resize(records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const PositionRecord& record = records[i];
    COSIVA_EXPECT(i == 0 || records[i - 1].handle < record.handle);
    char* at = put(now_[i].data(), record.handle);
    *at++ = static_cast<char>(static_cast<unsigned>(record.kind) | (record.augmented ? augmented_bit : 0U) |
                              (record.blocked ? blocked_bit : 0U));
    *at++ = static_cast<char>(record.status);
    at = put(at, record.x_m);
    at = put(at, record.y_m);
    const double heading_rad = std::isfinite(record.heading_rad) ? wrap_angle(double{record.heading_rad}) : 0.0;
    at = put_units(at, heading_rad, heading_unit_rad);
    at = put_units(at, double{record.speed_mps}, millimetre);
    at = put_units(at, double{record.reported_dx_m}, millimetre);
    put_units(at, double{record.reported_dy_m}, millimetre);
  }

  ++sequence_;
  const bool key = request_key_ || sequence_ - key_sequence_ >= key_every_ || !same_handles_as_key();
  if (key) {
    key_sequence_ = sequence_;
    key_ = now_;
    request_key_ = false;
  }
  COSIVA_EXPECT(key_.size() == now_.size());

  Frame frame{std::string(header_bytes, '\0'), key};
  frame.bytes.reserve(header_bytes + now_.size() * record_bytes);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < now_.size(); ++i) {
    if (!key && now_[i] == key_[i]) continue;
    frame.bytes.append(now_[i].data(), record_bytes);
    ++count;
  }
  char* at = frame.bytes.data();
  *at++ = magic;
  *at++ = version;
  at = put(at, key ? key_flag : std::uint16_t{0});
  at = put(at, sequence_);
  at = put(at, key_sequence_);
  at = put(at, count);
  put(at, std::bit_cast<std::uint64_t>(time_ms));
  return frame;
}

}  // namespace cosiva::virtual_side
