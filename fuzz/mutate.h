#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/random.h"

/// Hostile inputs made from good ones, the same for the same seed on every machine. Half of the changes follow the
/// syntax of JSON and TOML (they replace whole values), half damage arbitrary bytes, so that both the reader's grammar
/// and the code behind it are reached.
namespace cosiva::fuzz {

namespace detail {

inline constexpr std::array<std::string_view, 36> values{"null",
                                                         "true",
                                                         "false",
                                                         "0",
                                                         "-0.0",
                                                         "-1",
                                                         "1",
                                                         "4294967295",
                                                         "4294967296",
                                                         "-2147483649",
                                                         "9223372036854775807",
                                                         "18446744073709551616",
                                                         "1e9",
                                                         "1e10",
                                                         "-1e308",
                                                         "1e309",
                                                         "1e-320",
                                                         "3.14159265358979323846",
                                                         "nan",
                                                         "inf",
                                                         "\"\"",
                                                         "\"x\"",
                                                         "\"\\u0000\"",
                                                         "\"\\ud800\"",
                                                         "\"../../#+$\"",
                                                         "\"2023-07-11T00:00:00Z\"",
                                                         "\"2023-02-30T25:00:00Z\"",
                                                         "\"9.9.9\"",
                                                         "\"CONNECTIONBROKEN\"",
                                                         "\"HARD\"",
                                                         "{}",
                                                         "[]",
                                                         "[[]]",
                                                         "{\"\":{}}",
                                                         "[null,{},0]",
                                                         "{\"x\":0,\"x\":1}"};
inline constexpr std::array<std::string_view, 20> tokens{"{",
                                                         "}",
                                                         "[",
                                                         "]",
                                                         "\"",
                                                         ":",
                                                         ",",
                                                         "\\",
                                                         "\n",
                                                         "=",
                                                         "[[",
                                                         "]]",
                                                         "#",
                                                         "\xFF",
                                                         "\xC3",
                                                         "\xED\xA0\x80",
                                                         std::string_view{"\0", 1},
                                                         "/",
                                                         "e",
                                                         "-"};

inline std::size_t below(Random& random, std::size_t bound) { return static_cast<std::size_t>(random.below(bound)); }

/// Replaces one value of JSON or TOML: the text between a ':', '=', ',' or '[' and the next separator.
inline void replace_value(Random& random, std::string& text) {
  const std::size_t start = text.find_first_of(":=,[", below(random, text.size()));
  if (start == std::string::npos) return;
  std::size_t end = text.find_first_of(",]}\n", start + 1);
  if (end == std::string::npos) end = text.size();
  text.replace(start + 1, end - start - 1, values[below(random, values.size())]);
}
/// Replaces a run of digits by another number.
inline void replace_number(Random& random, std::string& text) {
  const std::size_t start = text.find_first_of("0123456789", below(random, text.size()));
  if (start == std::string::npos) return;
  std::size_t end = text.find_first_not_of("0123456789.", start);
  if (end == std::string::npos) end = text.size();
  const std::string number = random.chance(0.5)
                                 ? std::to_string(static_cast<std::int64_t>(random.next() >> random.below(64)))
                                 : std::to_string(random.uniform(-4.0, 4.0));
  text.replace(start, end - start, number);
}
/// Copies a piece of another good input into this one.
inline void splice(Random& random, std::string& text, std::span<const std::string> corpus) {
  const std::string& other = corpus[below(random, corpus.size())];
  if (other.empty()) return;
  const std::size_t from = below(random, other.size());
  const std::size_t length = 1 + below(random, other.size() - from);
  const std::size_t at = below(random, text.size() + 1);
  const std::size_t replaced = random.chance(0.5) ? std::min(length, text.size() - at) : 0;
  text.replace(at, replaced, other, from, length);
}
inline void damage_bytes(Random& random, std::string& text) {
  const std::size_t at = below(random, text.size());
  const std::size_t length = 1 + below(random, std::min<std::size_t>(text.size() - at, 64));
  switch (random.below(7)) {
    case 0: text[at] = static_cast<char>(static_cast<unsigned char>(text[at]) ^ (1U << random.below(8))); break;
    case 1: text[at] = static_cast<char>(random.below(256)); break;
    case 2: text.erase(at, length); break;
    case 3: text.insert(at, std::string{text, at, length}); break;
    case 4: text.insert(at, tokens[below(random, tokens.size())]); break;
    case 5: text.resize(at); break;
    default: std::swap(text[at], text[below(random, text.size())]); break;
  }
}

}  // namespace detail

/// Changes `text` at one to four locations. `corpus` must not be empty; the result has at most `bytes_max` bytes.
inline void mutate(Random& random, std::string& text, std::span<const std::string> corpus, std::size_t bytes_max) {
  for (auto left = 1 + random.below(4); left > 0; --left) {
    const auto choice = random.below(8);
    if (text.empty() || choice == 0) {
      detail::splice(random, text, corpus);
    } else if (choice <= 3) {
      detail::replace_value(random, text);
    } else if (choice == 4) {
      detail::replace_number(random, text);
    } else {
      detail::damage_bytes(random, text);
    }
  }
  // Occasionally a deep or long input: the bounds must be tested too.
  if (random.chance(0.002))
    text.insert(detail::below(random, text.size() + 1), std::string(10'000, random.chance(0.5) ? '[' : '9'));
  if (text.size() > bytes_max) text.resize(bytes_max);
}

/// An endless source of mutated inputs.
class Mutator {
 public:
  /// @param corpus  good inputs, at least one
  Mutator(std::uint64_t seed, std::vector<std::string> corpus, std::size_t bytes_max = std::size_t{1} << 20U)
      : random_{seed, "mutator"}, corpus_{std::move(corpus)}, bytes_max_{bytes_max} {}

  /// Valid until the next call.
  [[nodiscard]] const std::string& next() {
    input_ = corpus_[detail::below(random_, corpus_.size())];
    mutate(random_, input_, corpus_, bytes_max_);
    return input_;
  }

 private:
  Random random_;
  std::vector<std::string> corpus_;
  std::size_t bytes_max_;
  std::string input_;
};

}  // namespace cosiva::fuzz
