#include "cosiva/adapters/broker.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <pwd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

using std::chrono::milliseconds;

constexpr int ports_tried_max = 5;
constexpr milliseconds accept_max{10'000};

class Socket {
 public:
  Socket() : fd_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)} {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

// NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): this is how the sockets API is called
const sockaddr* generic(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }

bool accepts(std::uint16_t port) {
  const Socket socket;
  const sockaddr_in address = loopback(port);
  return ::connect(socket.fd(), generic(address), sizeof address) == 0;
}

Result<std::string> find_mosquitto() {
  std::string looked;
  const char* path = std::getenv("PATH");
  std::string directories = path == nullptr ? "" : path;
  directories += ":/usr/sbin:/usr/local/sbin";
  for (std::size_t at = 0; at <= directories.size();) {
    const std::size_t colon = std::min(directories.find(':', at), directories.size());
    const std::string candidate = directories.substr(at, colon - at) + "/mosquitto";
    if (candidate.size() > 10 && ::access(candidate.c_str(), X_OK) == 0) return candidate;
    at = colon + 1;
  }
  return fail("broker.missing",
              "mosquitto is not installed (Debian: apt install mosquitto), nor was a broker given with --broker");
}

std::string our_user() {
  const passwd* entry = ::getpwuid(::geteuid());
  return entry == nullptr ? std::string{} : std::string(entry->pw_name);
}

Result<void> write_private_file(const std::string& path, std::string_view text) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return fail("broker.start", std::string("cannot write: ") + std::strerror(errno), path);
  const bool whole = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::close(fd);
  if (!whole) return fail("broker.start", "cannot write all of it", path);
  return {};
}

std::string configuration(std::uint16_t port) {
  std::string text = "listener " + std::to_string(port) +
                     " 127.0.0.1\n"
                     "allow_anonymous true\n"
                     "persistence false\n"
                     "set_tcp_nodelay true\n"
                     // Per client that does not read: 4 s of 10 000 messages a second, and 100 MB of 2.5 kB each.
                     "max_inflight_messages 20000\n"
                     "max_queued_messages 40000\n"
                     "max_queued_bytes 134217728\n"
                     // Of the whole broker: invented topics with retained messages are bounded by nothing else.
                     "memory_limit 1073741824\n"
                     "max_packet_size 262144\n"
                     "log_dest stderr\n"
                     "log_type error\n"
                     "log_type warning\n"
                     "log_type notice\n"
                     "log_timestamp_format %Y-%m-%dT%H:%M:%S\n";
  // Run by root, mosquitto would change its user and thereby lose its parent-death signal (PR_SET_PDEATHSIG).
  if (const std::string user = our_user(); !user.empty()) text += "user " + user + "\n";
  return text;
}

}  // namespace

Result<std::uint16_t> find_free_port() {
  const Socket socket;
  sockaddr_in address = loopback(0);
  socklen_t length = sizeof address;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  auto* writable = reinterpret_cast<sockaddr*>(&address);
  if (socket.fd() < 0 || ::bind(socket.fd(), generic(address), sizeof address) != 0 ||
      ::getsockname(socket.fd(), writable, &length) != 0) {
    return fail("broker.start", std::string("no free port on 127.0.0.1: ") + std::strerror(errno));
  }
  return ntohs(address.sin_port);
}

PrivateBroker::~PrivateBroker() {
  child_.reset();
  std::error_code ignored;
  std::filesystem::remove(configuration_path(), ignored);
}

Result<void> PrivateBroker::launch() {
  COSIVA_EXPECT(port_ != 0);
  ChildOptions child;
  child.argv = {options_.program, "-c", configuration_path()};
  child.log_file = options_.log_file;
  child.on_log = options_.on_log;
  child.on_exit = [this](const ChildExit& exit) {
    if (on_exit_) on_exit_(exit);
  };
  auto started = Child::start(loop_, std::move(child));
  if (!started) return tl::unexpected(started.error());
  child_ = std::move(*started);
  return {};
}

Result<void> PrivateBroker::restart() { return launch(); }

Result<std::unique_ptr<PrivateBroker>> PrivateBroker::start(EventLoop& loop, BrokerOptions options) {
  if (options.program.empty()) {
    auto found = find_mosquitto();
    if (!found) return tl::unexpected(found.error());
    options.program = *found;
  }
  std::unique_ptr<PrivateBroker> broker{new PrivateBroker(loop, std::move(options))};
  // Another process may take the port before mosquitto does: then the next port is tried.
  for (int tries = 0; tries < ports_tried_max; ++tries) {
    auto port = find_free_port();
    if (!port) return tl::unexpected(port.error());
    broker->port_ = *port;
    if (auto written = write_private_file(broker->configuration_path(), configuration(*port)); !written)
      return tl::unexpected(written.error());
    if (auto launched = broker->launch(); !launched) return tl::unexpected(launched.error());
    const auto ended = [&] { return !broker->child_->running(); };
    const bool decided = loop.run_until([&] { return ended() || accepts(*port); }, accept_max);
    if (decided && !ended()) return broker;
  }
  return fail("broker.start", "mosquitto does not start; its log has the reason", broker->options_.log_file);
}

}  // namespace cosiva::adapters
