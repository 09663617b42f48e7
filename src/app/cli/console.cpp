#include "cosiva/app/cli/console.h"

#include <algorithm>
#include <cstdio>

#include "cosiva/base/likeness.h"

namespace cosiva::app {

void print_info(std::string_view text) { std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data()); }

void print(std::string_view data) {
  std::fwrite(data.data(), 1, data.size(), stdout);
  std::fputc('\n', stdout);
  std::fflush(stdout);
}

std::string step_line(double t_s, std::string_view what) {
  const std::string at = decimals(t_s, 1);
  return std::string(at.size() < 8 ? 8 - at.size() : 0, ' ').append(at).append(" s  ").append(what);
}

int report_error(const Error& error) {
  print_info("cosiva: " + to_string(error));
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
