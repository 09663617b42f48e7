#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "cosiva/base/time.h"

namespace cosiva::adapters {

/// Bounds the number of lines in a log, whatever remote programs send: of each source and kind of line a few pass in
/// each window, and of each kind a number from all sources together; the others are counted, and the count is logged
/// when the window is over.
///
/// The source is what precedes the first ": " of a line. Two lines are of one kind where they differ only in digits and
/// in what is between quotation marks.
///
/// Invariant: at most keys_max sources and kinds are stored; lines of further ones have one count together. The times
/// are those of the inputs, so that the same inputs give the same log.
class LogLimiter {
 public:
  static constexpr SimDuration window{std::chrono::seconds{10}};
  static constexpr std::uint32_t lines_max = 10;        ///< of one source and kind in a window
  static constexpr std::uint32_t kind_lines_max = 250;  ///< of one kind in a window, from all sources
  static constexpr std::size_t keys_max = 4096;

  using Write = std::function<void(char level, const std::string& text)>;
  explicit LogLimiter(Write write) : write_{std::move(write)} {}

  /// Writes the line, or counts it.
  /// @param now  a time before the last one counts as the last one
  void log(SimTime now, char level, const std::string& text);
  /// Writes the counts of windows that are over. To be called regularly.
  void tick(SimTime now);
  /// Writes all counts.
  void flush();

  /// The line without what may differ between lines of one kind.
  [[nodiscard]] static std::string kind_of(std::string_view text);

 private:
  struct Count {
    SimTime began{};
    std::uint32_t passed{0};
    std::uint64_t more{0};  ///< lines that were not written
    char level{'i'};
    std::string last;  ///< the last of them
  };
  using Counts = std::map<std::string, Count, std::less<>>;
  /// The count of a key, whose window contains `now`.
  Count& count_of(Counts& counts, const std::string& key, SimTime now);
  void write_count(const Count& count);

  Write write_;
  Counts lines_;  ///< by source and kind
  Counts kinds_;  ///< by kind
  SimTime now_{};
  SimTime checked_at_{};
};

}  // namespace cosiva::adapters
