#include "cosiva/journal/store/simulated_disk.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::journal {
namespace {

/// Zeros in the part of a sector that lies in [from, end of the bytes).
void lose_sector(std::string& bytes, std::size_t sector, std::size_t from) {
  const std::size_t begin = std::max(sector * sector_bytes, from);
  const std::size_t end = std::min((sector + 1) * sector_bytes, bytes.size());
  if (begin < end)
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(begin), bytes.begin() + static_cast<std::ptrdiff_t>(end),
              '\0');
}

}  // namespace

/// Invariant: the disk has the file.
class SimulatedDisk::OpenFile final : public DiskFile {
 public:
  OpenFile(SimulatedDisk& disk, std::string name) : disk_{disk}, name_{std::move(name)} {
    COSIVA_EXPECT(disk_.files_.contains(name_));
  }
  Result<void> append(std::string_view bytes) override { return disk_.append(name_, bytes); }
  Result<void> sync() override { return disk_.sync(name_); }

 private:
  SimulatedDisk& disk_;
  std::string name_;
};

void SimulatedDisk::fail_power() {
  for (auto& [name, file] : files_) {
    COSIVA_EXPECT(file.durable_bytes <= file.bytes.size());
    const std::size_t written = file.bytes.size() - file.durable_bytes;
    file.bytes.resize(file.durable_bytes + random_.below(written + 1));
    for (std::size_t sector = file.durable_bytes / sector_bytes; sector * sector_bytes < file.bytes.size(); ++sector) {
      if (random_.chance(0.3)) lose_sector(file.bytes, sector, file.durable_bytes);
    }
    for (const auto& [sector, from] : file.lost_sectors) lose_sector(file.bytes, sector, from);
    file.lost_sectors.clear();
    file.durable_bytes = file.bytes.size();
  }
}

void SimulatedDisk::flip_bit(const std::string& name, std::size_t bit) {
  std::string& bytes = files_.at(name).bytes;
  bytes.at(bit / 8) = static_cast<char>(static_cast<unsigned char>(bytes.at(bit / 8)) ^ (1U << (bit % 8)));
}

Result<void> SimulatedDisk::allow(Call call, const std::string& name) const {
  ++calls_;
  const std::string code = faults_ ? faults_(call, name) : std::string{};
  if (code.empty()) return {};
  return fail(code, "the simulated disk refuses", name);
}

Result<std::vector<std::string>> SimulatedDisk::names() const {
  if (auto allowed = allow(Call::names, {}); !allowed) return tl::unexpected<Error>(allowed.error());
  std::vector<std::string> names;
  for (const auto& [name, file] : files_) names.push_back(name);
  return names;
}

Result<std::string> SimulatedDisk::read(const std::string& name) const {
  if (auto allowed = allow(Call::read, name); !allowed) return tl::unexpected<Error>(allowed.error());
  const auto file = files_.find(name);
  if (file == files_.end()) return fail("disk.io", "there is no such file", name);
  return file->second.bytes;
}

Result<std::unique_ptr<DiskFile>> SimulatedDisk::create(const std::string& name) {
  if (auto allowed = allow(Call::create, name); !allowed) return tl::unexpected<Error>(allowed.error());
  if (!files_.try_emplace(name).second) return fail("disk.exists", "there is such a file", name);
  return std::make_unique<OpenFile>(*this, name);
}

Result<void> SimulatedDisk::replace(const std::string& name, std::string_view bytes) {
  if (auto allowed = allow(Call::replace, name); !allowed) return allowed;
  files_[name] = {std::string(bytes), bytes.size(), {}};
  return {};
}

Result<void> SimulatedDisk::cut(const std::string& name, std::size_t bytes) {
  if (auto allowed = allow(Call::cut, name); !allowed) return allowed;
  File& file = files_.at(name);
  COSIVA_EXPECT(bytes <= file.bytes.size());
  file.bytes.resize(bytes);
  file.durable_bytes = bytes;
  return {};
}

Result<void> SimulatedDisk::remove(const std::string& name) {
  if (auto allowed = allow(Call::remove, name); !allowed) return allowed;
  files_.erase(name);
  return {};
}

Result<void> SimulatedDisk::append(const std::string& name, std::string_view bytes) {
  File& file = files_.at(name);
  if (auto allowed = allow(Call::append, name); !allowed) {
    file.bytes += bytes.substr(0, random_.below(bytes.size() + 1));
    return allowed;
  }
  file.bytes += bytes;
  return {};
}

Result<void> SimulatedDisk::sync(const std::string& name) {
  File& file = files_.at(name);
  auto allowed = allow(Call::sync, name);
  if (!allowed) {
    for (std::size_t sector = file.durable_bytes / sector_bytes; sector * sector_bytes < file.bytes.size(); ++sector) {
      if (random_.chance(0.5)) file.lost_sectors.emplace(sector, file.durable_bytes);
    }
  }
  if (allowed) file.durable_bytes = file.bytes.size();
  return allowed;
}

}  // namespace cosiva::journal
