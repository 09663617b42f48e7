#include "cosiva/app/cli/seed_range.h"

#include <charconv>
#include <optional>
#include <string>

namespace cosiva::app {
namespace {

constexpr std::uint64_t seeds_max = 10'000'000;

std::optional<std::uint64_t> read_number(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

Result<SeedRange> read_seed_range(std::string_view text, std::string_view option, std::string_view code) {
  const std::size_t dots = text.find("..");
  const auto first = read_number(text.substr(0, dots));
  const auto last = dots == std::string_view::npos ? first : read_number(text.substr(dots + 2));
  if (!first || !last || *first > *last || *last - *first >= seeds_max)
    return fail(std::string(code), "state a seed such as 7, or a range such as 1..200", std::string(option));
  return SeedRange{*first, *last};
}

}  // namespace cosiva::app
