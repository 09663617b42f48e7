#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

struct LogLimits {
  std::uint64_t file_bytes_max{10'000'000};  ///< a file that would become larger is rotated
  std::uint32_t files_max{3};                ///< of each log, the one being written among them; at least 1
};

/// The log files of several programs, written from one separate thread, so that no disk delays the loop. A file that is
/// full becomes "<path>.1", the one before "<path>.2", and so on; the oldest is deleted. Where the disk is full, lines
/// are lost and counted, this is reported once, and the log continues when there is room again.
///
/// Invariant: at most behind_max bytes wait to be written, and a log has at most files_max files, of at most
/// file_bytes_max bytes each unless a single append() is larger.
class LogFiles {
 public:
  /// The most that may wait for the disk; what exceeds it is lost and counted.
  static constexpr std::size_t behind_max = std::size_t{4} << 20U;

  /// @param on_error  called from the loop, once until the file can be written again; may be empty
  LogFiles(EventLoop& loop, LogLimits limits, std::function<void(const Error&)> on_error);
  /// Waits until everything is written.
  ~LogFiles();
  LogFiles(const LogFiles&) = delete;
  LogFiles& operator=(const LogFiles&) = delete;

  /// Opens or creates a log. Fails ("file.write").
  [[nodiscard]] Result<void> open(const std::string& path);
  /// Appends to a log that is open (checked).
  void append(const std::string& path, std::string_view bytes);
  /// Waits until everything is written or lost.
  void drain();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with errors in transit to the loop
};

}  // namespace cosiva::adapters
