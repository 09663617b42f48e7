#include "app/words.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace cosiva::app {
namespace {

/// Insertions, deletions and replacements that lead from one word to the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

void say(std::string_view text) { std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data()); }

void print(std::string_view data) {
  std::fwrite(data.data(), 1, data.size(), stdout);
  std::fputc('\n', stdout);
  std::fflush(stdout);
}

std::string step_line(double t_s, std::string_view what) {
  const std::string at = decimals(t_s, 1);
  return std::string(at.size() < 8 ? 8 - at.size() : 0, ' ').append(at).append(" s  ").append(what);
}

int complain(const Error& error) {
  say("cosiva: " + to_string(error));
  return exit_bad_input;
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string decimals(double number, int digits) {
  char text[48];
  const int length = std::snprintf(text, sizeof text, "%.*f", digits, number);
  return {text, static_cast<std::size_t>(std::max(length, 0))};
}

}  // namespace cosiva::app
