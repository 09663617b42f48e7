#include "cosiva/adapters/child_process.h"

#include <fcntl.h>
#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/streambuf.hpp>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <istream>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {

namespace asio = boost::asio;
using ErrorCode = boost::system::error_code;

std::string to_string(const ChildExit& exit) {
  if (exit.signal != 0) return "killed (signal " + std::to_string(exit.signal) + ")";
  return "exit " + std::to_string(exit.status);
}

namespace {

struct Pipe {
  int read_end{-1};
  int write_end{-1};
  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) == 0) {
      read_end = ends[0];
      write_end = ends[1];
    }
  }
  ~Pipe() {
    close_read();
    close_write();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_read() {
    if (read_end >= 0) ::close(std::exchange(read_end, -1));
  }
  void close_write() {
    if (write_end >= 0) ::close(std::exchange(write_end, -1));
  }
};

/// Runs between fork and exec: only what is safe there. Writes the errno to `failure` when it cannot go on.
[[noreturn]] void become(char* const* argv, pid_t parent, int output, int errors, int failure) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(127);  // the parent died before the line above
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM, SIGHUP, SIGCHLD}) ::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int input = ::open("/dev/null", O_RDONLY);
  if (input >= 0) ::dup2(input, STDIN_FILENO);
  if (output >= 0) ::dup2(output, STDOUT_FILENO);
  if (errors >= 0) ::dup2(errors, STDERR_FILENO);
  // Asio's sockets are not close-on-exec; a child that held our listening port would block it for us.
  ::close_range(3, ~0U, CLOSE_RANGE_CLOEXEC);
  ::execvp(argv[0], argv);
  const int error = errno;
  const auto ignored = ::write(failure, &error, sizeof error);
  static_cast<void>(ignored);
  ::_exit(127);
}

}  // namespace

struct Child::Impl : std::enable_shared_from_this<Child::Impl> {
  struct Output {
    explicit Output(asio::io_context& context) : pipe{context} {}
    asio::posix::stream_descriptor pipe;
    asio::streambuf buffer{64 * 1024};
  };

  explicit Impl(EventLoop& loop_, ChildOptions options_)
      : loop{loop_},
        options{std::move(options_)},
        reaped{loop_.context(), SIGCHLD},
        output{std::make_shared<Output>(loop_.context())},
        log_pipe{loop_.context()},
        grace{loop_} {}

  Result<void> start() {
    COSIVA_EXPECT(!options.argv.empty() && pid < 0);
    const std::string& program = options.argv.front();
    Pipe lines;
    Pipe failure;
    Pipe log_lines;
    int log = -1;
    if (options.on_log) {
      log = std::exchange(log_lines.write_end, -1);
    } else if (!options.log_file.empty()) {
      log = ::open(options.log_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
      if (log < 0) return fail("child.start", std::string("cannot write: ") + std::strerror(errno), options.log_file);
    }
    std::vector<char*> argv;
    for (std::string& argument : options.argv) argv.push_back(argument.data());
    argv.push_back(nullptr);

    watch();  // before the fork, so that not even an immediate end is missed
    const pid_t parent = ::getpid();
    pid = ::fork();
    if (pid == 0) become(argv.data(), parent, options.on_line ? lines.write_end : log, log, failure.write_end);
    const int fork_error = errno;
    if (log >= 0) ::close(log);
    if (pid < 0) return fail("child.start", std::string("cannot fork: ") + std::strerror(fork_error), program);
    failure.close_write();
    int error = 0;
    ssize_t got = 0;
    while ((got = ::read(failure.read_end, &error, sizeof error)) < 0 && errno == EINTR) {
    }
    if (got == static_cast<ssize_t>(sizeof error)) {
      ::waitpid(pid, nullptr, 0);
      pid = -1;
      return fail("child.start", std::string("cannot run: ") + std::strerror(error), program);
    }
    if (options.on_line) {
      ErrorCode ignored;
      output->pipe.assign(std::exchange(lines.read_end, -1), ignored);
      read_lines();
    }
    if (options.on_log) {
      ErrorCode ignored;
      log_pipe.assign(std::exchange(log_lines.read_end, -1), ignored);
      log_pipe.non_blocking(true, ignored);
      read_log();
    }
    return {};
  }

  void watch() {
    reaped.async_wait([weak = weak_from_this()](const ErrorCode& error, int) {
      const auto self = weak.lock();
      if (error || !self) return;
      if (!self->reap()) self->watch();
    });
  }

  bool reap() {
    int status = 0;
    if (pid <= 0 || ::waitpid(pid, &status, WNOHANG) != pid) return false;
    pid = -1;
    grace.cancel();
    // What a child wrote at its end, such as the reason of an abort, arrives before its exit is reported.
    if (options.on_log) take_log();
    ChildExit exit;
    exit.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    exit.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    const auto on_exit = std::exchange(options.on_exit, {});
    if (on_exit) on_exit(exit);
    return true;
  }

  void read_log() {
    // Waits and then reads, so that no bytes are in transit to a handler when the child's exit is handled.
    log_pipe.async_wait(asio::posix::stream_descriptor::wait_read, [weak = weak_from_this()](const ErrorCode& error) {
      const auto self = weak.lock();
      if (error || !self || !self->options.on_log) return;
      if (self->take_log()) self->read_log();
    });
  }

  /// Takes what is there, a pipe's capacity at most. False: the child has closed its log.
  bool take_log() {
    std::array<char, 64 * 1024> bytes{};
    ErrorCode error;
    const std::size_t size = log_pipe.read_some(asio::buffer(bytes), error);
    if (size > 0) options.on_log({bytes.data(), size});
    return size > 0 || error == asio::error::would_block;
  }

  void read_lines() {
    // A read that has begun still uses pipe and buffer after this object is destroyed: the handler keeps them.
    const auto line_read = [weak = weak_from_this(), kept = output](const ErrorCode& error, std::size_t) {
      const auto self = weak.lock();
      if (error || !self) return;
      std::istream stream{&kept->buffer};
      std::string line;
      std::getline(stream, line);
      if (self->options.on_line) self->options.on_line(line);
      self->read_lines();
    };
    asio::async_read_until(output->pipe, output->buffer, '\n', line_read);
  }

  void close() {
    options.on_exit = {};
    options.on_line = {};
    options.on_log = {};
    ErrorCode ignored;
    reaped.cancel(ignored);
    output->pipe.close(ignored);
    log_pipe.close(ignored);
    grace.cancel();
    if (pid <= 0) return;
    kill_group();
    ::waitpid(pid, nullptr, 0);
    pid = -1;
  }

  /// The child leads its own group, so that the processes it has started end with it.
  void kill_group() const { ::kill(-pid, SIGKILL); }

  EventLoop& loop;
  ChildOptions options;
  asio::signal_set reaped;
  std::shared_ptr<Output> output;
  asio::posix::stream_descriptor log_pipe;
  Timer grace;
  pid_t pid{-1};
};

Child::Child() = default;
Child::~Child() {
  if (impl_) impl_->close();
}

Result<std::unique_ptr<Child>> Child::start(EventLoop& loop, ChildOptions options) {
  std::unique_ptr<Child> made{new Child};
  made->impl_ = std::make_shared<Impl>(loop, std::move(options));
  if (auto started = made->impl_->start(); !started) return tl::unexpected(started.error());
  return made;
}

pid_t Child::pid() const { return impl_->pid; }
bool Child::running() const { return impl_->pid > 0; }

void Child::signal(int number) {
  if (running()) ::kill(impl_->pid, number);
}

void Child::end(std::chrono::milliseconds grace) {
  if (!running()) return;
  signal(SIGTERM);
  impl_->grace.after(grace, [weak = std::weak_ptr<Impl>(impl_)] {
    if (const auto self = weak.lock(); self && self->pid > 0) self->kill_group();
  });
}

}  // namespace cosiva::adapters
