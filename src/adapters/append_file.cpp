#include "cosiva/adapters/append_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "cosiva/adapters/disk_writer.h"
#include "cosiva/base/expect.h"

namespace cosiva::adapters {

Result<std::unique_ptr<AppendFile>> AppendFile::open(const std::string& path) {
  std::error_code error;
  const auto folder = std::filesystem::path(path).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) return fail("file.write", "the folder cannot be made: " + error.message(), folder.string());
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) return fail("file.write", std::string("cannot write: ") + std::strerror(errno), path);
  std::unique_ptr<AppendFile> file(new AppendFile(path, fd));
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return file;
  if (errno == EWOULDBLOCK) return fail("file.taken", "another process is writing it", path);
  return file;  // a file system without locks
}

AppendFile::AppendFile(std::string path, int fd) : path_{std::move(path)}, fd_{fd} { COSIVA_EXPECT(fd_ >= 0); }

AppendFile::~AppendFile() { ::close(fd_); }

tl::unexpected<Error> AppendFile::refuse(int error) const {
  return fail("file.write", std::string("cannot write: ") + std::strerror(error), path_);
}

Result<void> AppendFile::cut(std::size_t bytes) {
  if (::ftruncate(fd_, static_cast<off_t>(bytes)) != 0) return refuse(errno);
  return {};
}

Result<void> AppendFile::append(std::string_view bytes) {
  if (const int error = write_all(fd_, bytes); error != 0) return refuse(error);
  return {};
}

}  // namespace cosiva::adapters
