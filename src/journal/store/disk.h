#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::journal {

/// The smallest unit that a disk writes whole or not at all.
inline constexpr std::size_t sector_bytes = 512;

/// A new file of a store, which only grows. Nothing is durable before sync() has succeeded; until then a power failure
/// may lose any part of the bytes, not only the last ones.
class DiskFile {
 public:
  virtual ~DiskFile() = default;
  /// The disk may begin to write the bytes. Fails ("disk.full", "disk.read_only", "disk.io"); then any part of the
  /// bytes may be in the file.
  [[nodiscard]] virtual Result<void> append(std::string_view bytes) = 0;
  /// Makes all bytes durable. Fails ("disk.io" and as append() does); then none of the bytes since the last sync() can
  /// be relied upon, even if a later sync() succeeds.
  [[nodiscard]] virtual Result<void> sync() = 0;

 protected:
  DiskFile() = default;
  DiskFile(const DiskFile&) = default;
  DiskFile& operator=(const DiskFile&) = default;
};

/// The folder of a store: a folder of a file system (adapters), or a simulated one that loses, tears and refuses. Every
/// function fails with "disk.full", "disk.read_only" or "disk.io", and names the file.
class Disk {
 public:
  virtual ~Disk() = default;
  /// The names of all files, sorted.
  [[nodiscard]] virtual Result<std::vector<std::string>> names() const = 0;
  [[nodiscard]] virtual Result<std::string> read(const std::string& name) const = 0;
  /// A new, empty file, whose name is durable. Fails also ("disk.exists") where there is one of this name.
  [[nodiscard]] virtual Result<std::unique_ptr<DiskFile>> create(const std::string& name) = 0;
  /// The file with exactly this content, or as it was: durable, also through a power failure.
  [[nodiscard]] virtual Result<void> replace(const std::string& name, std::string_view bytes) = 0;
  /// Keeps the first `bytes` of a file, durably.
  [[nodiscard]] virtual Result<void> cut(const std::string& name, std::size_t bytes) = 0;
  [[nodiscard]] virtual Result<void> remove(const std::string& name) = 0;

 protected:
  Disk() = default;
  Disk(const Disk&) = default;
  Disk& operator=(const Disk&) = default;
};

}  // namespace cosiva::journal
