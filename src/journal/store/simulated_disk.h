#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/result.h"
#include "cosiva/journal/store/disk.h"

namespace cosiva::journal {

/// A disk in memory, for tests and the fault simulation: calls fail where `faults` decides so, and a power failure
/// leaves of unsynced writes any part that a real disk may leave.
///
/// Invariant: the durable bytes of a file are the first ones of its bytes, except sectors whose sync failed.
class SimulatedDisk final : public Disk {
 public:
  enum class Call : std::uint8_t { names, read, create, append, sync, replace, cut, remove };
  /// The code of the error of a call ("disk.full", "disk.read_only", "disk.io"); empty: the call succeeds. A failed
  /// append leaves a part of its bytes, drawn at random.
  using Faults = std::function<std::string(Call call, const std::string& name)>;

  explicit SimulatedDisk(std::uint64_t seed) : random_{seed, "disk"} {}

  void set_faults(Faults faults) { faults_ = std::move(faults); }
  /// Every file as it is after a power failure: of the bytes not synced some are cut off, and some sectors are zeros.
  void fail_power();
  /// Inverts a bit of a file.
  void flip_bit(const std::string& name, std::size_t bit);
  [[nodiscard]] std::uint64_t calls() const { return calls_; }

  [[nodiscard]] Result<std::vector<std::string>> names() const override;
  [[nodiscard]] Result<std::string> read(const std::string& name) const override;
  [[nodiscard]] Result<std::unique_ptr<DiskFile>> create(const std::string& name) override;
  [[nodiscard]] Result<void> replace(const std::string& name, std::string_view bytes) override;
  [[nodiscard]] Result<void> cut(const std::string& name, std::size_t bytes) override;
  [[nodiscard]] Result<void> remove(const std::string& name) override;

 private:
  struct File {
    std::string bytes;
    std::size_t durable_bytes{0};
    /// Sectors whose sync failed, and from which byte on: zeros after a power failure, though a later sync succeeded.
    std::map<std::size_t, std::size_t> lost_sectors;
  };
  class OpenFile;

  [[nodiscard]] Result<void> allow(Call call, const std::string& name) const;
  [[nodiscard]] Result<void> append(const std::string& name, std::string_view bytes);
  [[nodiscard]] Result<void> sync(const std::string& name);

  std::map<std::string, File> files_;
  mutable Random random_;
  Faults faults_;
  mutable std::uint64_t calls_{0};
};

}  // namespace cosiva::journal
