#include "cosiva/adapters/disk_writer.h"

#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {

int write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

DiskWriter::Write writes_to(int fd) {
  return [fd](std::string_view bytes) -> Result<void> {
    if (const int error = write_all(fd, bytes); error != 0) return fail("file.write", std::strerror(error));
    return {};
  };
}

struct DiskWriter::Impl : std::enable_shared_from_this<Impl> {
  Impl(EventLoop& loop_, Write write_, std::function<void(const Error&)> on_error_)
      : loop{loop_}, write{std::move(write_)}, on_error{std::move(on_error_)} {}

  void work() {
    std::unique_lock lock{mutex};
    for (;;) {
      changed.wait(lock, [this] { return ends || !waiting.empty(); });
      if (waiting.empty()) return;
      COSIVA_EXPECT(!failed && waiting.size() <= behind_max);
      const std::string batch = std::exchange(waiting, {});
      writing = true;
      lock.unlock();
      auto written = write(batch);
      lock.lock();
      writing = false;
      if (!written) fail_with(std::move(written.error()));
      changed.notify_all();
    }
  }

  /// With the mutex held.
  void fail_with(Error error) {
    waiting.clear();
    if (std::exchange(failed, true)) return;
    loop.post([weak = weak_from_this(), error = std::move(error)] {
      if (const auto self = weak.lock(); self && self->on_error) self->on_error(error);
    });
  }

  EventLoop& loop;
  Write write;
  std::function<void(const Error&)> on_error;
  std::mutex mutex;
  std::condition_variable changed;
  std::string waiting;
  bool writing{false};
  bool failed{false};
  bool ends{false};
  std::thread thread;
};

DiskWriter::DiskWriter(EventLoop& loop, Write write, std::function<void(const Error&)> on_error)
    : impl_{std::make_shared<Impl>(loop, std::move(write), std::move(on_error))} {
  impl_->thread = std::thread{[inside = impl_.get()] { inside->work(); }};
}

DiskWriter::~DiskWriter() {
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->ends = true;
  }
  impl_->changed.notify_all();
  impl_->thread.join();
}

void DiskWriter::append(std::string_view bytes) {
  {
    const std::lock_guard lock{impl_->mutex};
    if (impl_->failed) return;
    if (impl_->waiting.size() + bytes.size() > behind_max) {
      impl_->fail_with({"file.slow", "the disk does not keep up: more than 64 MiB wait to be written", {}});
      return;
    }
    impl_->waiting += bytes;
  }
  impl_->changed.notify_all();
}

void DiskWriter::drain() {
  std::unique_lock lock{impl_->mutex};
  impl_->changed.wait(lock, [this] { return impl_->waiting.empty() && !impl_->writing; });
}

bool DiskWriter::broken() const {
  const std::lock_guard lock{impl_->mutex};
  return impl_->failed;
}

}  // namespace cosiva::adapters
