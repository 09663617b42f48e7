#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// A file that only grows and has one writer process at a time. Bytes given to append() are in the file even when the
/// process is killed.
///
/// Invariant: the file is open for appending.
class AppendFile {
 public:
  /// Opens the file, and creates it and its folder where missing. Fails ("file.write"), and ("file.taken") where
  /// another process has opened it.
  [[nodiscard]] static Result<std::unique_ptr<AppendFile>> open(const std::string& path);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Cuts the file after the first `bytes`. Fails ("file.write").
  [[nodiscard]] Result<void> cut(std::size_t bytes);
  /// Fails ("file.write"); then a part of the bytes may be in the file.
  [[nodiscard]] Result<void> append(std::string_view bytes);

 private:
  AppendFile(std::string path, int fd);
  [[nodiscard]] tl::unexpected<Error> refuse(int error) const;

  std::string path_;
  int fd_;
};

}  // namespace cosiva::adapters
