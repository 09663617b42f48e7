#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
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
  std::vector<std::string> argv;  ///< argv[0] is looked up in PATH unless it holds a '/'
  std::string log_file;           ///< stderr (and stdout without on_line) is appended here; empty: inherited
  std::function<void(const std::string& line)> on_line;  ///< takes stdout, line by line
  std::function<void(const ChildExit&)> on_exit;
};

/// A process of ours. It gets its own process group, so Ctrl-C in the terminal reaches only us and we end it in order,
/// and SIGTERM when we die without a word (PR_SET_PDEATHSIG).
class Child {
 public:
  /// Fails ("child.start") when the program cannot be run.
  [[nodiscard]] static Result<std::unique_ptr<Child>> start(EventLoop& loop, ChildOptions options);
  ~Child();  ///< kills and reaps what still runs; on_exit is not called

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
