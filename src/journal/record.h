#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// The record at the front of some bytes, which it refers to.
struct RecordView {
  std::uint8_t kind;  ///< wire::InputKind, or format::end_kind
  bool flag;
  SimTime at;
  std::string_view source;
  std::string_view payload;
  std::size_t bytes;  ///< of the whole record, its length and checksum included

  /// The input; only of a record that is not the end.
  [[nodiscard]] wire::Input input() const;
};

/// Appends the record of an input to `out`.
void append_record(std::string& out, const wire::Input& input);
/// Appends the record that ends a run, with its digest.
void append_end_record(std::string& out, SimTime at, std::string_view digest);

/// The record at the front of the bytes; nothing where the bytes end within it. Fails ("journal.length",
/// "journal.crc", "journal.flag", "journal.kind") with the reason; the caller knows the offset.
[[nodiscard]] Result<std::optional<RecordView>> front_record(std::string_view bytes);

}  // namespace cosiva::journal
