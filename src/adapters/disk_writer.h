#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// Writes all of it; the errno, or 0.
[[nodiscard]] int write_all(int fd, std::string_view bytes);

/// Writes a loop's bytes to a disk from a separate thread: a disk that is slow, or stalls for a second while it cleans
/// up or another program fills it, then delays the file and nothing else.
///
/// Invariant: at most behind_max bytes wait, and none after a failure.
class DiskWriter {
 public:
  using Write = std::function<Result<void>(std::string_view bytes)>;
  /// The most that may wait to be written; a disk that falls behind further counts as one that cannot be written.
  static constexpr std::size_t behind_max = std::size_t{64} << 20U;

  /// @param write     called from that thread, one batch after the other
  /// @param on_error  called from the loop, once; after a write that failed nothing more is written. May be empty
  DiskWriter(EventLoop& loop, Write write, std::function<void(const Error&)> on_error);
  /// Waits until everything is written.
  ~DiskWriter();
  DiskWriter(const DiskWriter&) = delete;
  DiskWriter& operator=(const DiskWriter&) = delete;

  /// Appends behind the bytes that wait.
  void append(std::string_view bytes);
  /// Waits until everything is written, or writing has failed.
  void drain();
  [[nodiscard]] bool broken() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the error in transit to the loop
};

/// Fails ("file.write") with the reason.
[[nodiscard]] DiskWriter::Write writes_to(int fd);

}  // namespace cosiva::adapters
