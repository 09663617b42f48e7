#include "cosiva/hmi/unique_ids.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <random>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::app {
namespace {

constexpr std::size_t random_digits = 5;
constexpr std::size_t client_id_bytes_max = 64;

std::string in_base_36(std::uint64_t value) {
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, 36).ptr;
  return {digits.data(), end};
}

}  // namespace

UniqueIds::UniqueIds(char kind) : prefix_{kind, '-'} {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  prefix_ += in_base_36(static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(now).count()));
  std::random_device random;
  const std::string digits = std::string(random_digits, '0') + in_base_36(random());
  prefix_ += digits.substr(digits.size() - random_digits) + "-";
  COSIVA_EXPECT(prefix_.size() < client_id_bytes_max);
}

std::string UniqueIds::next() { return prefix_ + std::to_string(++count_); }

bool valid_client_id(std::string_view id) {
  if (id.empty() || id.size() > client_id_bytes_max || !wire::valid_serial_number(id)) return false;
  if (id.starts_with("C-") || id.starts_with("S-") || id.starts_with("c-")) return false;
  const bool is_counted = id.size() > 1 && id.front() == 'c' &&
                          std::ranges::all_of(id.substr(1), [](char c) { return c >= '0' && c <= '9'; });
  return !is_counted;
}

}  // namespace cosiva::app
