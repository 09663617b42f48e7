#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/journal/store/disk.h"

namespace cosiva::adapters {

/// A folder of the file system, written by one process at a time.
///
/// Invariant: while an object that writes exists, this process holds the lock of the folder.
class PosixDisk final : public journal::Disk {
 public:
  enum class Use : std::uint8_t { read, write };
  /// Opens the folder; to write, it is made where missing, and locked. Fails ("store.open"), and ("store.taken") where
  /// another process writes there.
  [[nodiscard]] static Result<std::unique_ptr<PosixDisk>> open(const std::string& folder, Use use = Use::write);
  ~PosixDisk() override;
  PosixDisk(const PosixDisk&) = delete;
  PosixDisk& operator=(const PosixDisk&) = delete;

  [[nodiscard]] Result<std::vector<std::string>> names() const override;
  [[nodiscard]] Result<std::string> read(const std::string& name) const override;
  [[nodiscard]] Result<std::unique_ptr<journal::DiskFile>> create(const std::string& name) override;
  [[nodiscard]] Result<void> replace(const std::string& name, std::string_view bytes) override;
  [[nodiscard]] Result<void> cut(const std::string& name, std::size_t bytes) override;
  [[nodiscard]] Result<void> remove(const std::string& name) override;

 private:
  PosixDisk(std::string folder, int folder_fd);
  [[nodiscard]] std::string path_of(const std::string& name) const;
  /// Makes the names of the folder durable.
  [[nodiscard]] Result<void> sync_names() const;

  std::string folder_;
  int folder_fd_;
  int lock_fd_{-1};
};

}  // namespace cosiva::adapters
