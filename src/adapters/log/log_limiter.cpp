#include "cosiva/adapters/log/log_limiter.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

constexpr SimDuration check_period{std::chrono::seconds{1}};
constexpr std::size_t shown_bytes_max = 120;
constexpr std::string_view separator = ": ";

bool digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string LogLimiter::kind_of(std::string_view text) {
  const std::size_t source_end = text.find(separator);
  if (source_end != std::string_view::npos) text.remove_prefix(source_end);
  std::string kind;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
      continue;
    }
    if (c == '\'' || c == '"') quote = c;
    if (digit(c) && !kind.empty() && kind.back() == '#') continue;
    kind += digit(c) ? '#' : c;
  }
  return kind.substr(0, shown_bytes_max);
}

LogLimiter::Count& LogLimiter::count_of(Counts& counts, const std::string& key, SimTime now) {
  auto found = counts.find(key);
  if (found == counts.end()) {
    const bool room = counts.size() < keys_max;
    found = counts.try_emplace(room ? key : std::string{}).first;
    if (found->second.passed == 0) found->second.began = now;
  }
  Count& count = found->second;
  if (now - count.began >= window) {
    write_count(count);
    count = {};
    count.began = now;
  }
  COSIVA_EXPECT(counts.size() <= keys_max + 1);
  return count;
}

void LogLimiter::log(SimTime now, char level, const std::string& text) {
  now_ = std::max(now_, now);
  const std::string kind = kind_of(text);
  const std::size_t source_end = text.find(separator);
  const std::string source = source_end == std::string::npos ? std::string{} : text.substr(0, source_end);
  Count& of_source = count_of(lines_, source.substr(0, shown_bytes_max) + '\n' + kind, now_);
  Count& of_kind = count_of(kinds_, kind, now_);
  if (of_source.passed < lines_max && of_kind.passed < kind_lines_max) {
    ++of_source.passed;
    ++of_kind.passed;
    return write_(level, text);
  }
  // A source that is repetitive is named; a kind that many sources write is summarised once.
  Count& more = of_source.passed >= lines_max ? of_source : of_kind;
  ++more.more;
  more.level = level;
  more.last = text.substr(0, shown_bytes_max);
}

void LogLimiter::tick(SimTime now) {
  now_ = std::max(now_, now);
  if (now_ - checked_at_ < check_period) return;
  checked_at_ = now_;
  for (Counts* counts : {&lines_, &kinds_}) {
    std::erase_if(*counts, [this](const auto& entry) {
      if (now_ - entry.second.began < window) return false;
      write_count(entry.second);
      return true;
    });
  }
}

void LogLimiter::flush() {
  for (Counts* counts : {&lines_, &kinds_}) {
    for (const auto& [key, count] : *counts) write_count(count);
    counts->clear();
  }
}

void LogLimiter::write_count(const Count& count) {
  if (count.more == 0) return;
  write_(count.level, "… " + std::to_string(count.more) + " more in " +
                          std::to_string(std::chrono::duration_cast<std::chrono::seconds>(window).count()) +
                          " s like: " + count.last);
}

}  // namespace cosiva::adapters
