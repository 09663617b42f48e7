#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

struct ChildExit {
  int status{};  ///< exit status, or −1 when a signal ended it
  int signal{};  ///< that signal, or 0
  [[nodiscard]] bool clean() const { return status == 0; }
};
/// "exit 2", "killed (signal 9)".
[[nodiscard]] std::string to_string(const ChildExit& exit);

struct ChildOptions {
  std::vector<std::string> argv;  ///< argv[0] is searched in PATH unless it has a '/'
  std::string log_file;           ///< stderr (and stdout without on_line) is appended here; empty: inherited
  /// Takes the same in place of log_file, as it is written: all of it before on_exit is called.
  std::function<void(std::string_view bytes)> on_log;
  std::function<void(const std::string& line)> on_line;  ///< takes stdout, line by line
  std::function<void(const ChildExit&)> on_exit;
};

/// A child process. The child has its own process group, so that Ctrl-C in the terminal reaches only the parent, which
/// then ends the child in order, and gets SIGTERM when the parent dies without ending it (PR_SET_PDEATHSIG).
///
/// Invariant: a process is started once, and its number is known exactly until the process has been reaped.
class Child {
 public:
  /// Fails ("child.start") when the program cannot be run.
  [[nodiscard]] static Result<std::unique_ptr<Child>> start(EventLoop& loop, ChildOptions options);
  ~Child();  ///< kills and reaps a process that still runs; on_exit is not called

  [[nodiscard]] pid_t pid() const;
  [[nodiscard]] bool running() const;
  /// SIGTERM, then SIGKILL after `grace`. on_exit follows.
  void end(std::chrono::milliseconds grace = std::chrono::seconds{3});
  void signal(int number);

 private:
  Child();
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
