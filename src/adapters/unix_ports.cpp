#include "cosiva/adapters/unix_ports.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <type_traits>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
using Stream = asio::local::stream_protocol;
using ErrorCode = boost::system::error_code;

constexpr std::chrono::milliseconds reconnect_period{200};
/// A board that does not read for this long is gone: at 50 frames a second the buffer holds over ten seconds' data.
constexpr std::size_t unsent_max = 64 * 1024;

Result<void> check_path(const std::string& path) {
  constexpr std::size_t path_max = sizeof(sockaddr_un::sun_path) - 1;
  if (path.size() <= path_max) return {};
  return fail("port.path", "a socket's path may have " + std::to_string(path_max) + " bytes; use a shorter directory",
              path);
}

/// One connected stream. The owner is notified of bytes and of the end until close().
///
/// Invariant: at most unsent_max bytes wait, and only while a wait for the socket is in progress.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Stream::socket socket, std::function<void(std::string_view)> on_bytes, std::function<void()> on_end)
      : socket_{std::move(socket)}, on_bytes_{std::move(on_bytes)}, on_end_{std::move(on_end)} {
    ErrorCode ignored;
    socket_.non_blocking(true, ignored);
  }

  void start() { read(); }

  void send(std::string_view bytes) {
    if (!socket_.is_open()) return;
    if (unsent_.empty()) {
      ErrorCode error;
      const std::size_t sent = socket_.write_some(asio::buffer(bytes.data(), bytes.size()), error);
      if (!error) bytes.remove_prefix(sent);
      if (error && error != asio::error::would_block && error != asio::error::try_again) return end_later();
      if (bytes.empty()) return;
    }
    if (unsent_.size() + bytes.size() > unsent_max) return end_later();
    unsent_ += bytes;
    write();
  }

  void close() {
    on_bytes_ = {};
    on_end_ = {};
    ErrorCode ignored;
    socket_.close(ignored);
  }

 private:
  void read() {
    socket_.async_read_some(asio::buffer(buffer_), [self = shared_from_this()](const ErrorCode& error, std::size_t n) {
      if (error) return self->end();
      if (self->on_bytes_) self->on_bytes_({self->buffer_.data(), n});
      if (self->socket_.is_open()) self->read();
    });
  }

  void write() {
    COSIVA_EXPECT(!unsent_.empty() && unsent_.size() <= unsent_max);
    if (std::exchange(writing_, true)) return;
    socket_.async_wait(Stream::socket::wait_write, [self = shared_from_this()](const ErrorCode& waited) {
      self->writing_ = false;
      if (waited || !self->socket_.is_open()) return;
      ErrorCode error;
      const std::size_t sent = self->socket_.write_some(asio::buffer(self->unsent_), error);
      if (error && error != asio::error::would_block && error != asio::error::try_again) return self->end();
      if (!error) self->unsent_.erase(0, sent);
      if (!self->unsent_.empty()) self->write();
    });
  }

  /// The pending read notices the shut-down stream and ends it from the loop, not from inside send().
  void end_later() {
    ErrorCode ignored;
    socket_.shutdown(Stream::socket::shutdown_both, ignored);
  }

  void end() {
    ErrorCode ignored;
    socket_.close(ignored);
    const auto on_end = std::exchange(on_end_, {});
    on_bytes_ = {};
    if (on_end) on_end();
  }

  Stream::socket socket_;
  std::function<void(std::string_view)> on_bytes_;
  std::function<void()> on_end_;
  std::array<char, 4096> buffer_;
  std::string unsent_;
  bool writing_{false};
};

/// Common to both ends of a connected port: passes its bytes on, and reports when the stream opened and closed.
///
/// Invariant: the handlers learn in turn that the port is up and that it is down.
class Line : public std::enable_shared_from_this<Line> {
 public:
  Line(std::string port, const PortHandlers& handlers) : port_{std::move(port)}, handlers_{handlers} {}

  /// Replaces the stream before it. `after_loss` is called when the stream ends by itself, after the handlers.
  void carry(Stream::socket socket, std::function<void()> after_loss = {}) {
    const auto self = shared_from_this();  // a handler may destroy its ports
    if (connection_) {
      connection_->close();
      connection_.reset();
      report(false);
    }
    connection_ = std::make_shared<Connection>(
        std::move(socket),
        [weak = weak_from_this()](std::string_view bytes) {
          if (const auto line = weak.lock(); line && line->handlers_.on_bytes)
            line->handlers_.on_bytes(line->port_, bytes);
        },
        [weak = weak_from_this(), after_loss = std::move(after_loss)] {
          const auto line = weak.lock();
          if (!line) return;
          line->connection_.reset();
          line->report(false);
          if (after_loss) after_loss();
        });
    report(true);
    if (connection_) connection_->start();
  }

  void send(std::string_view bytes) {
    if (connection_) connection_->send(bytes);
  }

  void close() {
    handlers_ = {};
    if (connection_) connection_->close();
    connection_.reset();
    up_ = false;
  }

 private:
  void report(bool up) {
    COSIVA_EXPECT(up != up_);
    up_ = up;
    if (handlers_.on_port) handlers_.on_port(port_, up);
  }

  std::string port_;
  PortHandlers handlers_;
  std::shared_ptr<Connection> connection_;
  bool up_{false};  ///< as reported
};

// --- the boards' side -----------------------------------------------------------------------------------------------

/// Invariant: the socket's file belongs to this process exactly while `own_` is set.
class Listener : public std::enable_shared_from_this<Listener> {
 public:
  Listener(EventLoop& loop, std::string port, std::string path, const PortHandlers& handlers)
      : acceptor_{loop.context()}, path_{std::move(path)}, line_{std::make_shared<Line>(std::move(port), handlers)} {}

  Result<void> open() {
    COSIVA_EXPECT(!own_);
    ErrorCode error;
    // The directory belongs to this process (see DirectoryLock), so a socket here was left by a process that was
    // killed.
    struct stat found {};
    if (::lstat(path_.c_str(), &found) == 0) {
      if (!S_ISSOCK(found.st_mode)) return fail("port.listen", "exists and is not a socket", path_);
      ::unlink(path_.c_str());
    }
    acceptor_.open(Stream(), error);
    if (!error) acceptor_.bind(Stream::endpoint(path_), error);
    if (!error) acceptor_.listen(4, error);
    if (error) return fail("port.listen", "cannot listen: " + error.message(), path_);
    own_ = true;
    accept();
    return {};
  }

  void send(std::string_view bytes) { line_->send(bytes); }

  void close() {
    ErrorCode ignored;
    acceptor_.close(ignored);
    line_->close();
    if (std::exchange(own_, false)) ::unlink(path_.c_str());
  }

 private:
  void accept() {
    acceptor_.async_accept([self = shared_from_this()](const ErrorCode& error, Stream::socket socket) {
      if (!self->acceptor_.is_open()) return;
      if (!error) self->line_->carry(std::move(socket));
      self->accept();
    });
  }

  Stream::acceptor acceptor_;
  std::string path_;
  std::shared_ptr<Line> line_;
  bool own_{false};
};

// --- the on-board side ----------------------------------------------------------------------------------------------

class Connector : public std::enable_shared_from_this<Connector> {
 public:
  Connector(EventLoop& loop, std::string port, std::string path, const PortHandlers& handlers)
      : loop_{loop}, retry_{loop}, path_{std::move(path)}, line_{std::make_shared<Line>(std::move(port), handlers)} {}

  Result<void> open() {
    loop_.post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->connect();
    });
    return {};
  }

  void send(std::string_view bytes) { line_->send(bytes); }

  void close() {
    closed_ = true;
    retry_.cancel();
    line_->close();
  }

 private:
  void connect() {
    if (closed_) return;
    // A Unix socket connects at once or not at all (full backlog included), so there is nothing to wait for.
    Stream::socket socket{loop_.context()};
    ErrorCode error;
    socket.open(Stream(), error);
    if (!error) socket.non_blocking(true, error);
    if (!error) socket.connect(Stream::endpoint(path_), error);
    if (error) return retry();
    line_->carry(std::move(socket), [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->retry();
    });
  }

  void retry() {
    if (closed_) return;
    retry_.after(reconnect_period, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->connect();
    });
  }

  EventLoop& loop_;
  Timer retry_;
  std::string path_;
  std::shared_ptr<Line> line_;
  bool closed_{false};
};

/// One process at a time serves the boards of a directory. The kernel releases the lock however that process ends.
///
/// Invariant: the lock is of one directory, taken once.
class DirectoryLock {
 public:
  DirectoryLock() = default;
  ~DirectoryLock() {
    if (fd_ >= 0) ::close(fd_);
  }
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

  Result<void> take(const std::string& directory) {
    COSIVA_EXPECT(fd_ < 0);
    fd_ = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd_ >= 0 && ::flock(fd_, LOCK_EX | LOCK_NB) == 0) return {};
    if (errno == EWOULDBLOCK) return fail("port.listen", "another process serves the boards of this folder", directory);
    return fail("port.listen", std::string("cannot use this folder: ") + std::strerror(errno), directory);
  }

 private:
  int fd_{-1};
};

template <typename End>
class UnixPorts final : public Ports {
 public:
  ~UnixPorts() override {
    for (auto& [port, end] : ends_) end->close();
  }

  static Result<std::unique_ptr<Ports>> make(EventLoop& loop, const std::string& directory,
                                             const std::vector<std::string>& ports, const PortHandlers& handlers) {
    auto made = std::make_unique<UnixPorts>();
    if constexpr (std::is_same_v<End, Listener>) {
      if (auto taken = made->lock_.take(directory); !taken) return tl::unexpected(taken.error());
    }
    for (const std::string& port : ports) {
      const std::string path = socket_path(directory, port);
      if (auto fits = check_path(path); !fits) return tl::unexpected(fits.error());
      auto end = std::make_shared<End>(loop, port, path, handlers);
      if (auto opened = end->open(); !opened) return tl::unexpected(opened.error());
      made->ends_.emplace(port, std::move(end));
    }
    return made;
  }

  void send(const std::string& port, std::string_view bytes) override {
    const auto found = ends_.find(port);
    if (found != ends_.end()) found->second->send(bytes);
  }

 private:
  DirectoryLock lock_;  // released after the sockets are destroyed, hence declared first
  std::map<std::string, std::shared_ptr<End>> ends_;
};

}  // namespace

std::string socket_path(const std::string& directory, const std::string& port) {
  std::string name = port;
  std::ranges::replace(name, '/', '-');
  return directory + "/" + name + ".sock";
}

Result<std::unique_ptr<Ports>> listen_unix_ports(EventLoop& loop, const std::string& directory,
                                                 const std::vector<std::string>& ports, const PortHandlers& handlers) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return fail("port.listen", "cannot create this directory: " + error.message(), directory);
  return UnixPorts<Listener>::make(loop, directory, ports, handlers);
}

Result<std::unique_ptr<Ports>> connect_unix_ports(EventLoop& loop, const std::string& directory,
                                                  const std::vector<std::string>& ports, const PortHandlers& handlers) {
  return UnixPorts<Connector>::make(loop, directory, ports, handlers);
}

}  // namespace cosiva::adapters
