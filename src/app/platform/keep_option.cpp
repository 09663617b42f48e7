#include "cosiva/app/platform/keep_option.h"

#include <array>
#include <charconv>
#include <chrono>
#include <string>

namespace cosiva::app {
namespace {

constexpr std::uint64_t value_max = 1'000'000;

struct Unit {
  std::string_view name;
  std::chrono::hours age;  ///< 0: a size
  std::size_t bytes;
};
constexpr std::array<Unit, 5> units{{{"d", std::chrono::hours{24}, 0},
                                     {"h", std::chrono::hours{1}, 0},
                                     {"MB", {}, 1'000'000},
                                     {"GB", {}, 1'000'000'000},
                                     {"TB", {}, 1'000'000'000'000}}};

/// Takes one limit; false where the text is none, or the same kind was stated already.
bool take(std::string_view text, journal::Keep& keep) {
  std::uint64_t value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || value == 0 || value > value_max) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  for (const Unit& unit : units) {
    if (text != unit.name) continue;
    if (unit.bytes == 0 ? keep.age.has_value() : keep.bytes.has_value()) return false;
    if (unit.bytes == 0)
      keep.age = static_cast<std::int64_t>(value) * unit.age;
    else
      keep.bytes = value * unit.bytes;
    return true;
  }
  return false;
}

}  // namespace

Result<journal::Keep> parse_keep(std::string_view text) {
  journal::Keep keep;
  if (text == "all") return keep;
  const std::size_t slash = text.find('/');
  const bool first = take(text.substr(0, slash), keep);
  const bool second = slash == std::string_view::npos || take(text.substr(slash + 1), keep);
  if (first && second) return keep;
  return fail("keep", "'" + std::string(text) +
                          "' is no limit; --keep takes an age (30d, 12h), a size (20GB, 500MB), " +
                          "both (30d/20GB), or all");
}

}  // namespace cosiva::app
