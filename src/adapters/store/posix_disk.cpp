#include "cosiva/adapters/store/posix_disk.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "cosiva/adapters/disk_writer.h"
#include "cosiva/adapters/files.h"
#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

constexpr const char* lock_name = ".lock";
constexpr std::string_view new_suffix = ".new";
constexpr std::size_t early_bytes = std::size_t{256} << 10U;

tl::unexpected<Error> disk_error(int error, const std::string& path) {
  const char* const code = error == ENOSPC || error == EDQUOT || error == EFBIG  ? "disk.full"
                           : error == EROFS || error == EACCES || error == EPERM ? "disk.read_only"
                           : error == EEXIST                                     ? "disk.exists"
                                                                                 : "disk.io";
  return fail(code, std::strerror(error), path);
}

/// The errno of a call that returns a negative number on failure, or 0.
int error_of(int returned) { return returned < 0 ? errno : 0; }

/// Invariant: the file is open for appending.
class PosixFile final : public journal::DiskFile {
 public:
  PosixFile(std::string path, int fd) : path_{std::move(path)}, fd_{fd} { COSIVA_EXPECT(fd_ >= 0); }
  ~PosixFile() override { ::close(fd_); }
  PosixFile(const PosixFile&) = delete;
  PosixFile& operator=(const PosixFile&) = delete;

  Result<void> append(std::string_view bytes) override {
    if (const int error = write_all(fd_, bytes); error != 0) return disk_error(error, path_);
    // Otherwise the disk would begin with sync(). Where this fails, sync() reports it.
    if (bytes.size() >= early_bytes) static_cast<void>(::sync_file_range(fd_, 0, 0, SYNC_FILE_RANGE_WRITE));
    return {};
  }
  Result<void> sync() override {
    if (const int error = error_of(::fdatasync(fd_)); error != 0) return disk_error(error, path_);
    return {};
  }

 private:
  std::string path_;
  int fd_;
};

}  // namespace

Result<std::unique_ptr<PosixDisk>> PosixDisk::open(const std::string& folder, Use use) {
  std::error_code failed;
  if (use == Use::write) std::filesystem::create_directories(folder, failed);
  if (failed) return fail("store.open", "the folder cannot be made: " + failed.message(), folder);
  const int folder_fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_fd < 0) return fail("store.open", std::string("cannot open: ") + std::strerror(errno), folder);
  std::unique_ptr<PosixDisk> disk(new PosixDisk(folder, folder_fd));
  if (use == Use::read) return disk;
  disk->lock_fd_ = ::openat(folder_fd, lock_name, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (disk->lock_fd_ < 0) return fail("store.open", std::string("cannot be locked: ") + std::strerror(errno), folder);
  if (::flock(disk->lock_fd_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return fail("store.taken", "another process uses this store", folder);
  return disk;
}

PosixDisk::PosixDisk(std::string folder, int folder_fd) : folder_{std::move(folder)}, folder_fd_{folder_fd} {
  COSIVA_EXPECT(folder_fd_ >= 0);
}

PosixDisk::~PosixDisk() {
  ::close(folder_fd_);
  if (lock_fd_ >= 0) ::close(lock_fd_);
}

std::string PosixDisk::path_of(const std::string& name) const { return folder_ + "/" + name; }

Result<void> PosixDisk::sync_names() const {
  if (const int error = error_of(::fsync(folder_fd_)); error != 0) return disk_error(error, folder_);
  return {};
}

Result<std::vector<std::string>> PosixDisk::names() const {
  std::vector<std::string> names;
  std::error_code failed;
  for (std::filesystem::directory_iterator at{folder_, failed}, end; !failed && at != end; at.increment(failed)) {
    std::string name = at->path().filename().string();
    if (name != lock_name && !name.ends_with(new_suffix)) names.push_back(std::move(name));
  }
  if (failed) return fail("disk.io", failed.message(), folder_);
  std::sort(names.begin(), names.end());
  return names;
}

Result<std::string> PosixDisk::read(const std::string& name) const {
  auto bytes = read_file(path_of(name));
  if (!bytes) return fail("disk.io", bytes.error().message, bytes.error().location);
  return bytes;
}

Result<std::unique_ptr<journal::DiskFile>> PosixDisk::create(const std::string& name) {
  const int fd = ::openat(folder_fd_, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0600);
  if (fd < 0) return disk_error(errno, path_of(name));
  std::unique_ptr<journal::DiskFile> file = std::make_unique<PosixFile>(path_of(name), fd);
  if (auto synced = sync_names(); !synced) return tl::unexpected<Error>(synced.error());
  return file;
}

Result<void> PosixDisk::replace(const std::string& name, std::string_view bytes) {
  const std::string other = name + std::string(new_suffix);
  const int fd = ::openat(folder_fd_, other.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return disk_error(errno, path_of(other));
  int error = write_all(fd, bytes);
  if (error == 0) error = error_of(::fsync(fd));
  ::close(fd);
  if (error == 0) error = error_of(::renameat(folder_fd_, other.c_str(), folder_fd_, name.c_str()));
  if (error == 0) return sync_names();
  ::unlinkat(folder_fd_, other.c_str(), 0);
  return disk_error(error, path_of(name));
}

Result<void> PosixDisk::cut(const std::string& name, std::size_t bytes) {
  const int fd = ::openat(folder_fd_, name.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) return disk_error(errno, path_of(name));
  int error = error_of(::ftruncate(fd, static_cast<off_t>(bytes)));
  if (error == 0) error = error_of(::fsync(fd));
  ::close(fd);
  if (error != 0) return disk_error(error, path_of(name));
  return {};
}

Result<void> PosixDisk::remove(const std::string& name) {
  if (const int error = error_of(::unlinkat(folder_fd_, name.c_str(), 0)); error != 0)
    return disk_error(error, path_of(name));
  return sync_names();
}

}  // namespace cosiva::adapters
