#include "cosiva/adapters/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

constexpr std::chrono::milliseconds flush_period{100};
constexpr std::size_t flush_bytes = 64 * 1024;

}  // namespace

Result<std::string> read_file(const std::string& path) {
  const bool standard = path == "-";
  const int fd = standard ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail("file.read", std::string("cannot read: ") + std::strerror(errno), path);
  std::string bytes;
  int error = 0;
  for (;;) {
    char buffer[64 * 1024];
    const ssize_t got = ::read(fd, buffer, sizeof buffer);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error = errno;
    if (got <= 0) break;
    bytes.append(buffer, static_cast<std::size_t>(got));
  }
  if (!standard) ::close(fd);
  if (error != 0) return fail("file.read", std::string("cannot read: ") + std::strerror(error), path);
  return bytes;
}

Result<void> write_file(const std::string& path, std::string_view bytes) {
  const std::string temporary = path + ".new";
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return fail("file.write", std::string("cannot write: ") + std::strerror(errno), path);
  int error = write_all(fd, bytes);
  if (::close(fd) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return {};
  ::unlink(temporary.c_str());
  return fail("file.write", std::string("cannot write: ") + std::strerror(error), path);
}

JournalFile::JournalFile(EventLoop& loop, std::string path, int fd, std::function<void(const Error&)> on_error)
    : path_{std::move(path)},
      fd_{fd},
      on_error_{std::move(on_error)},
      timer_{loop},
      writer_{
          loop, writes_to(fd), [this](const Error& error) {
            timer_.cancel();
            if (on_error_)
              on_error_({"journal.write", "the journal stops here, everything else goes on: " + error.message, path_});
          }} {
  timer_.every(flush_period, [this] { hand_on(); });
}

Result<void> write_files(const std::string& folder, const std::vector<std::pair<std::string, std::string>>& files) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail("file.write", "the folder cannot be made: " + error.message(), folder);
  for (const auto& [name, bytes] : files)
    if (auto written = write_file((std::filesystem::path(folder) / name).string(), bytes); !written) return written;
  return {};
}

Result<std::unique_ptr<JournalFile>> JournalFile::create(EventLoop& loop, const std::string& path,
                                                         std::function<void(const Error&)> on_error) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return fail("journal.open", std::string("cannot record here: ") + std::strerror(errno), path);
  return std::unique_ptr<JournalFile>(new JournalFile(loop, path, fd, std::move(on_error)));
}

JournalFile::~JournalFile() {
  flush();
  ::close(fd_);
}

void JournalFile::append(std::string_view bytes) {
  if (writer_.broken()) return;
  buffer_ += bytes;
  if (buffer_.size() >= flush_bytes) hand_on();
  COSIVA_EXPECT(buffer_.size() < flush_bytes);
}

void JournalFile::hand_on() {
  if (!buffer_.empty()) writer_.append(std::exchange(buffer_, {}));
}

void JournalFile::flush() {
  hand_on();
  writer_.drain();
}

}  // namespace cosiva::adapters
