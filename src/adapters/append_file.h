#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// A file that only grows, and of which only one process at a time is the writer. What append() was given stands in it
/// when the process is killed.
class AppendFile {
 public:
  /// Opens it, makes it where it is missing, and its folder too. Fails ("file.write"), and ("file.taken") where another
  /// process has it.
  [[nodiscard]] static Result<std::unique_ptr<AppendFile>> open(const std::string& path);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Forgets what is behind the first `bytes`. Fails ("file.write").
  [[nodiscard]] Result<void> cut(std::size_t bytes);
  /// Fails ("file.write"); then some of it may stand there.
  [[nodiscard]] Result<void> append(std::string_view bytes);

 private:
  AppendFile(std::string path, int fd) : path_{std::move(path)}, fd_{fd} {}
  [[nodiscard]] tl::unexpected<Error> refuse(int error) const;

  std::string path_;
  int fd_;
};

}  // namespace cosiva::adapters
