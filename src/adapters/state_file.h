#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// The few bytes a core wants kept over a crash of its process (wire::Persist), kept before store() returns.
///
/// The file has two slots that are written in turn, in place: a name that is made, moved or grown waits for whatever
/// else the disk has to do (up to 1.5 s were measured beside a copy of large files, where this takes 0.03 ms), and a
/// vehicle that remembers its place ten times a second must not. A slot starts with a line
/// "cosiva-memory 1 NUMBER LENGTH DIGEST"; the higher number that is whole counts, so one that was being written when
/// the machine lost its power does no harm.
class StateFile {
 public:
  explicit StateFile(std::string path) : path_{std::move(path)} {}
  ~StateFile();
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  /// Nothing: no file, an empty one, or none of its slots is whole. A text without slots is taken as it is.
  [[nodiscard]] std::optional<std::string> load() const;
  /// In the place of what was stored. Fails ("file.write"); then what was stored before is still there.
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

/// What such a file gives back: a part of it, or nothing.
[[nodiscard]] std::optional<std::string_view> newest_in(std::string_view state_file);

}  // namespace cosiva::adapters
