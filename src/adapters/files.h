#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/adapters/disk_writer.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// Fails ("file.read") naming the file and the reason; "-" reads standard input.
[[nodiscard]] Result<std::string> read_file(const std::string& path);
/// All of it or nothing: written to a new file, which then replaces the old one. Fails ("file.write").
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view bytes);

/// Each file by its name in the folder, which is created where missing. Fails ("file.write") at the first file that
/// cannot be written.
[[nodiscard]] Result<void> write_files(const std::string& folder,
                                       const std::vector<std::pair<std::string, std::string>>& files);

/// The file of a journal's bytes, which are handed to the writer at most 100 ms after append(), and are in the file at
/// the end. When the disk is full, or too slow to keep up, the journal stops with one clear error, and the recorded
/// program goes on.
///
/// Invariant: between calls less than one batch of bytes waits to be handed to the writer.
class JournalFile {
 public:
  /// Fails ("journal.open"). `on_error` is called from the loop.
  [[nodiscard]] static Result<std::unique_ptr<JournalFile>> create(EventLoop& loop, const std::string& path,
                                                                   std::function<void(const Error&)> on_error);
  ~JournalFile();
  void append(std::string_view bytes);
  /// Waits until everything is in the file, or cannot be written.
  void flush();
  [[nodiscard]] bool broken() const { return writer_.broken(); }

 private:
  JournalFile(EventLoop& loop, std::string path, int fd, std::function<void(const Error&)> on_error);
  void hand_on();

  std::string path_;
  int fd_;
  std::function<void(const Error&)> on_error_;
  std::string buffer_;
  Timer timer_;
  DiskWriter writer_;
};

}  // namespace cosiva::adapters
