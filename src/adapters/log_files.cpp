#include "cosiva/adapters/log_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "cosiva/adapters/disk_writer.h"
#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

/// The files of one log. Used by one thread at a time.
/// Invariant: while no file is open, its size counts as zero.
class RotatingFile {
 public:
  RotatingFile(std::string path, LogLimits limits) : path_{std::move(path)}, limits_{limits} {}
  ~RotatingFile() { close(); }
  RotatingFile(const RotatingFile&) = delete;
  RotatingFile& operator=(const RotatingFile&) = delete;

  Result<void> open() {
    fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    struct stat known {};
    if (fd_ < 0 || ::fstat(fd_, &known) != 0) return refuse(errno);
    bytes_ = S_ISREG(known.st_mode) ? static_cast<std::uint64_t>(known.st_size) : 0;
    return {};
  }

  Result<void> append(std::string_view bytes) {
    if (bytes_ > 0 && bytes_ + bytes.size() > limits_.file_bytes_max) rotate();
    if (fd_ < 0)
      if (auto opened = open(); !opened) return opened;
    COSIVA_EXPECT(fd_ >= 0);
    if (const int error = write_all(fd_, bytes); error != 0) return refuse(error);
    bytes_ += bytes.size();
    return {};
  }

 private:
  [[nodiscard]] std::string part(std::uint32_t number) const {
    return number == 0 ? path_ : path_ + "." + std::to_string(number);
  }

  void rotate() {
    close();
    if (limits_.files_max <= 1) ::unlink(path_.c_str());
    for (std::uint32_t number = limits_.files_max - 1; number > 0; --number)
      ::rename(part(number - 1).c_str(), part(number).c_str());
  }

  void close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
    bytes_ = 0;
  }

  [[nodiscard]] tl::unexpected<Error> refuse(int error) const {
    return fail("file.write", std::string("the log cannot be written: ") + std::strerror(error), path_);
  }

  std::string path_;
  LogLimits limits_;
  int fd_{-1};
  std::uint64_t bytes_{0};
};

struct Log {
  explicit Log(std::unique_ptr<RotatingFile> its_file) : file{std::move(its_file)} {}
  std::unique_ptr<RotatingFile> file;
  std::string waiting;
  std::uint64_t lost{0};  ///< bytes since the last successful write
  bool reported{false};
};

std::string lost_line(std::uint64_t bytes) {
  return "\n" + std::to_string(bytes) + " bytes of this log are lost: the disk was full or too slow\n";
}

}  // namespace

struct LogFiles::Impl : std::enable_shared_from_this<Impl> {
  Impl(EventLoop& loop_, LogLimits limits_, std::function<void(const Error&)> on_error_)
      : loop{loop_}, limits{limits_}, on_error{std::move(on_error_)} {
    COSIVA_EXPECT(limits.files_max >= 1 && limits.file_bytes_max > 0);
  }

  void work() {
    std::unique_lock lock{mutex};
    for (;;) {
      changed.wait(lock, [this] { return ends || waiting_bytes > 0; });
      if (waiting_bytes == 0) return;
      COSIVA_EXPECT(waiting_bytes <= behind_max);
      writing = true;
      for (auto& [path, log] : logs)
        if (!log.waiting.empty()) write(log, lock);
      writing = false;
      changed.notify_all();
    }
  }

  /// With the mutex held, except while the disk is written.
  void write(Log& log, std::unique_lock<std::mutex>& lock) {
    const std::string batch = std::exchange(log.waiting, {});
    waiting_bytes -= batch.size();
    const std::uint64_t lost = log.lost;
    lock.unlock();
    auto written = lost > 0 ? log.file->append(lost_line(lost)) : Result<void>{};
    if (written) written = log.file->append(batch);
    lock.lock();
    if (written) {
      log.lost -= lost;
      log.reported = false;
      return;
    }
    log.lost += batch.size();
    if (std::exchange(log.reported, true)) return;
    loop.post([weak = weak_from_this(), error = std::move(written.error())] {
      if (const auto self = weak.lock(); self && self->on_error) self->on_error(error);
    });
  }

  EventLoop& loop;
  LogLimits limits;
  std::function<void(const Error&)> on_error;
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::string, Log> logs;  ///< by path
  std::size_t waiting_bytes{0};     ///< of all logs
  bool writing{false};
  bool ends{false};
  std::thread thread;
};

LogFiles::LogFiles(EventLoop& loop, LogLimits limits, std::function<void(const Error&)> on_error)
    : impl_{std::make_shared<Impl>(loop, limits, std::move(on_error))} {
  impl_->thread = std::thread{[inside = impl_.get()] { inside->work(); }};
}

LogFiles::~LogFiles() {
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->ends = true;
  }
  impl_->changed.notify_all();
  impl_->thread.join();
}

Result<void> LogFiles::open(const std::string& path) {
  auto file = std::make_unique<RotatingFile>(path, impl_->limits);
  if (auto opened = file->open(); !opened) return opened;
  const std::lock_guard lock{impl_->mutex};
  impl_->logs.try_emplace(path, std::move(file));
  return {};
}

void LogFiles::append(const std::string& path, std::string_view bytes) {
  {
    const std::lock_guard lock{impl_->mutex};
    const auto found = impl_->logs.find(path);
    COSIVA_EXPECT(found != impl_->logs.end());
    if (impl_->waiting_bytes + bytes.size() > behind_max) {
      found->second.lost += bytes.size();
      return;
    }
    found->second.waiting += bytes;
    impl_->waiting_bytes += bytes.size();
  }
  impl_->changed.notify_all();
}

void LogFiles::drain() {
  std::unique_lock lock{impl_->mutex};
  impl_->changed.wait(lock, [this] { return impl_->waiting_bytes == 0 && !impl_->writing; });
}

}  // namespace cosiva::adapters
