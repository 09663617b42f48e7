#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// Reads a journal's bytes from front to back. A record cut short at the end is reported by `truncated`, a damaged one
/// by an error that names its offset.
///
/// Invariant: the next record begins within the bytes, or at their end.
class Reader {
 public:
  /// Fails ("journal.magic") if the bytes are no journal.
  [[nodiscard]] static Result<Reader> open(std::string_view bytes);
  /// The next input; nothing at the end. Errors ("journal.crc", "journal.length", "journal.kind", "journal.flag",
  /// "journal.after_end") name the record's offset, and are repeated on every further call.
  [[nodiscard]] Result<std::optional<wire::Input>> next();
  [[nodiscard]] const std::optional<std::string>& recorded_digest() const { return digest_; }
  [[nodiscard]] bool truncated() const { return truncated_; }

 private:
  explicit Reader(std::string_view bytes) : bytes_{bytes} {}
  std::string_view bytes_;
  std::size_t at_{8};
  std::optional<std::string> digest_;
  bool truncated_{false};
};

}  // namespace cosiva::journal
