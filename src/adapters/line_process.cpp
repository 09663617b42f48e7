#include "cosiva/adapters/line_process.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

using Clock = std::chrono::steady_clock;

/// Lines are sent in pieces of this size: an estimator receives a dozen inputs between two requests.
constexpr std::size_t send_at = 16U << 10U;
constexpr std::size_t line_max = 1U << 20U;

[[noreturn]] void become(const char* command, pid_t parent, int socket) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(127);
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM, SIGHUP, SIGCHLD}) ::signal(signal, SIG_DFL);
  ::dup2(socket, STDIN_FILENO);
  ::dup2(socket, STDOUT_FILENO);
  ::execl("/bin/sh", "sh", "-c", command, static_cast<char*>(nullptr));
  ::_exit(127);
}

}  // namespace

Result<std::unique_ptr<LineProcess>> LineProcess::start(const std::string& command) {
  std::unique_ptr<LineProcess> process{new LineProcess};
  process->command_ = command;
  std::array<int, 2> ends{};
  // One socket for both directions: unlike for a pipe, writing to one that is not read is an error and not a signal.
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return fail("process.start", std::string("no socket: ") + std::strerror(errno), command);
  process->fd_ = ends[0];
  const pid_t parent = ::getpid();
  process->pid_ = ::fork();
  if (process->pid_ == 0) become(command.c_str(), parent, ends[1]);
  ::close(ends[1]);
  if (process->pid_ < 0) return fail("process.start", std::string("cannot fork: ") + std::strerror(errno), command);
  return process;
}

LineProcess::~LineProcess() {
  if (fd_ >= 0) ::close(fd_);
  if (pid_ <= 0) return;
  // The program's input is closed, which ends a program that reads to the end; any other is killed with its children.
  for (int i = 0; i < 20 && ::waitpid(pid_, nullptr, WNOHANG) == 0; ++i) {
    if (i == 10) ::kill(-pid_, SIGTERM);
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
  ::kill(-pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

tl::unexpected<Error> LineProcess::ended() {
  int status = 0;
  std::string how = "it closed its output";
  for (int i = 0; i < 50; ++i) {
    const pid_t reaped = ::waitpid(pid_, &status, WNOHANG);
    if (reaped == pid_) {
      how = WIFSIGNALED(status) ? "it was killed by signal " + std::to_string(WTERMSIG(status))
                                : "it ended with exit status " + std::to_string(WEXITSTATUS(status));
      ::kill(-pid_, SIGKILL);
      pid_ = -1;
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
  }
  return fail("process.gone", how, command_);
}

Result<void> LineProcess::exchange(bool until_line, std::chrono::milliseconds timeout) {
  if (pid_ < 0) return fail("process.gone", "it has ended", command_);
  COSIVA_EXPECT(fd_ >= 0 && pid_ > 0);
  const auto deadline = Clock::now() + timeout;
  std::array<char, 4096> bytes{};
  while (!to_send_.empty() || (until_line && received_.find('\n') == std::string::npos)) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd watched{fd_, static_cast<short>(to_send_.empty() ? POLLIN : POLLIN | POLLOUT), 0};
    const int ready = left > 0 ? ::poll(&watched, 1, static_cast<int>(left)) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0)
      return fail("process.unresponsive",
                  until_line ? "it gave no response for " + std::to_string(timeout.count()) + " ms"
                             : "it took nothing for " + std::to_string(timeout.count()) + " ms",
                  command_);
    if ((watched.revents & POLLOUT) != 0) {
      const ssize_t sent = ::send(fd_, to_send_.data(), to_send_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) to_send_.erase(0, static_cast<std::size_t>(sent));
      if (sent < 0 && errno != EAGAIN && errno != EINTR) return ended();
    }
    if ((watched.revents & (POLLIN | POLLHUP | POLLERR)) == 0) continue;
    const ssize_t got = ::recv(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return ended();
    if (got > 0) received_.append(bytes.data(), static_cast<std::size_t>(got));
    if (received_.size() > line_max && received_.find('\n') == std::string::npos)
      return fail("process.garbage", "it wrote more than a megabyte without an end of line", command_);
  }
  return {};
}

Result<void> LineProcess::send_line(std::string_view line, std::chrono::milliseconds timeout) {
  to_send_ += line;
  to_send_ += '\n';
  return to_send_.size() < send_at ? Result<void>{} : exchange(false, timeout);
}

Result<std::string> LineProcess::send_request(std::string_view line, std::chrono::milliseconds timeout) {
  to_send_ += line;
  to_send_ += '\n';
  if (auto done = exchange(true, timeout); !done) return tl::unexpected(done.error());
  const std::size_t end = received_.find('\n');
  std::string response = received_.substr(0, end);
  received_.erase(0, end + 1);
  return response;
}

}  // namespace cosiva::adapters
