#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/commands/values/decoded_command.h"

namespace cosiva::virtual_side {

/// The ids of commands: gives one to each command that has none, and lists those that clients have chosen, so that a
/// request that is sent again is recognised.
///
/// Invariant: no id is given twice, and no chosen id is given; at most `chosen_max` chosen ids are listed, each once.
class CommandIds {
 public:
  static constexpr std::size_t chosen_max = 200;

  /// "c12", after begin_series() "c-<time, base 36>-12".
  [[nodiscard]] std::string next();
  /// Counts a command that has an id.
  void count() { ++count_; }
  /// The count of the process before is not known: the ids from now on contain the time, so that they differ from those
  /// that were given before.
  void begin_series(SimTime now);

  /// Adds a chosen id, and drops the oldest where there are too many; an id that is listed stays as it is.
  void add(const CommandIdentity& command);
  enum class Known : std::uint8_t { no, same, other };  ///< `other`: the id belongs to a command of other content
  [[nodiscard]] Known find(const CommandIdentity& command) const;

  [[nodiscard]] bool empty() const { return chosen_.empty(); }
  /// The chosen ids, oldest first: [["mine","<content, hexadecimal>"],…]
  void write(JsonWriter& json) const;
  /// Replaces the chosen ids; items that cannot be read are skipped, and false is returned.
  [[nodiscard]] bool restore(const JsonValue& json);
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] bool chosen(std::string_view id) const;

  std::string series_{"c"};
  std::uint64_t count_{0};
  std::deque<CommandIdentity> chosen_;  ///< oldest first
};

}  // namespace cosiva::virtual_side
