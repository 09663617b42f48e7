#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cosiva::app {

/// Gives ids for commands: "C-mif3k2q9x1z4a-7" is the seventh of one process.
///
/// Invariant: no id is given twice, neither by this object nor by another one or by a restarted process: ids contain
/// the time at which the object was made, in ms, and a random number, because a clock may be set back.
class UniqueIds {
 public:
  /// @param kind  what the ids begin with
  explicit UniqueIds(char kind);
  [[nodiscard]] std::string next();

 private:
  std::string prefix_;
  std::uint64_t count_{0};
};

/// Whether a client may choose this id for a command: 1 to 64 of A-Z a-z 0-9 _ . : -, and none that the server may give
/// itself ("C-…", "S-…", "c-…", "c12").
[[nodiscard]] bool valid_client_id(std::string_view id);

}  // namespace cosiva::app
