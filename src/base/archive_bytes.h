#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva {

/// The bytes of an archive, written or read in the same order by the same calls.
///
/// Damaged bytes make reading fail, without an exception, and cost no more memory than a small multiple of the bytes.
/// Invariant: what has been read never exceeds the bytes; after a failure nothing is read or written.
class ArchiveBytes {
 public:
  /// Appends to `bytes`, which must outlive the archive.
  explicit ArchiveBytes(std::string& bytes) : written_{&bytes} {}
  /// Reads from `bytes`, which must outlive the archive.
  explicit ArchiveBytes(std::string_view bytes) : left_{bytes} {}

  [[nodiscard]] bool reads() const { return written_ == nullptr; }
  [[nodiscard]] bool failed() const { return fault_.has_value(); }
  /// The first failure counts.
  void fail(std::string_view why);
  /// To be called last: bytes that were not read are a failure. Fails with "archive" and the first failure.
  [[nodiscard]] Result<void> finish();
  /// A number of elements that follow, each of at least one byte: more than bytes are left to read is a failure.
  /// @return  the number that was written; 0 after a failure
  [[nodiscard]] std::size_t count(std::size_t elements);

 protected:
  void bytes(char* data, std::size_t size);
  void number(std::uint64_t& value);
  void flag(bool& value);
  void text(std::string& value);
  /// Which of the alternatives 0 … `alternatives` − 1 follows; 0 after a failure.
  [[nodiscard]] std::size_t choice(std::size_t index, std::size_t alternatives);
  /// False, and a failure: fewer than `size` elements of `each` bytes are left to read.
  [[nodiscard]] bool may_follow(std::size_t size, std::size_t each);

 private:
  std::string* written_{};   ///< null: reads
  std::string_view left_{};  ///< not read yet
  std::optional<std::string> fault_;
};

}  // namespace cosiva
