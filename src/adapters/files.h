#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "adapters/event_loop.h"
#include "base/result.h"

namespace cosiva::adapters {

/// Fails ("file.read") naming the file and the reason; "-" reads standard input.
[[nodiscard]] Result<std::string> read_file(const std::string& path);
/// All of it or nothing: written beside the file, then put in its place. Fails ("file.write").
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view bytes);

/// Each file by its name in the folder, which is made where it is missing. Fails ("file.write") at the first that
/// cannot.
[[nodiscard]] Result<void> write_files(const std::string& folder,
                                       const std::vector<std::pair<std::string, std::string>>& files);

/// Where a journal's bytes go. They reach the file at most 100 ms after append(), and at the end. When the disk is full
/// the journal stops with one clear error, and what it recorded goes on.
class JournalFile {
 public:
  /// Fails ("journal.open").
  [[nodiscard]] static Result<std::unique_ptr<JournalFile>> create(EventLoop& loop, const std::string& path,
                                                                   std::function<void(const Error&)> on_error);
  ~JournalFile();
  void append(std::string_view bytes);
  void flush();
  [[nodiscard]] bool broken() const { return fd_ < 0; }

 private:
  JournalFile(EventLoop& loop, std::string path, int fd, std::function<void(const Error&)> on_error);
  std::string path_;
  int fd_;
  std::function<void(const Error&)> on_error_;
  std::string buffer_;
  Timer flush_timer_;
};

/// The few bytes a core wants kept over a crash of its process (wire::Remember).
class MemoryFile {
 public:
  explicit MemoryFile(std::string path) : path_{std::move(path)} {}
  [[nodiscard]] std::optional<std::string> load() const;
  [[nodiscard]] Result<void> store(std::string_view bytes);

 private:
  std::string path_;
};

}  // namespace cosiva::adapters
