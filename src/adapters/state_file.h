#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// The few bytes that a core persists over a crash of its process (wire::Persist), written before store() returns.
///
/// The file has two slots that are written in turn, in place: creating, renaming or growing a file waits for all other
/// work of the disk (up to 1.5 s were measured during a copy of large files, where this takes 0.03 ms), and a vehicle
/// that persists its position ten times a second must not wait. A slot starts with a line "cosiva-memory 1 NUMBER
/// LENGTH DIGEST"; the intact slot with the higher number counts, so that a slot that was being written at a power
/// failure does no harm.
///
/// Invariant: while the file is open, its slots are of equal size, a power of two, and the slot written last is intact.
class StateFile {
 public:
  explicit StateFile(std::string path) : path_{std::move(path)} {}
  ~StateFile();
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  /// Nothing: no file, an empty one, or no intact slot. A text without slots is read as it is.
  [[nodiscard]] std::optional<std::string> load() const;
  /// Replaces the bytes stored before. Fails ("file.write"); then the bytes stored before are still there.
  [[nodiscard]] Result<void> store(std::string_view bytes);

 private:
  bool open_as_it_is();
  [[nodiscard]] Result<void> make_anew(std::string_view bytes);
  void close();

  std::string path_;
  int fd_{-1};
  std::size_t slot_bytes_{0};
  std::uint64_t number_{0};  ///< of the slot written last
};

/// The stored bytes of such a file: a part of it, or nothing.
[[nodiscard]] std::optional<std::string_view> newest_in(std::string_view state_file);

}  // namespace cosiva::adapters
