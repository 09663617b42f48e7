#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// A program that is spoken to line by line, one answer at a time: written to its standard input, read from its
/// standard output, both without ever waiting longer than is stated. What it says on standard error goes to ours. It
/// runs in a process group of its own, gets SIGTERM when we die, and is killed with the object.
class LineProcess {
 public:
  /// @param command  for /bin/sh
  /// Fails ("process.start").
  [[nodiscard]] static Result<std::unique_ptr<LineProcess>> start(const std::string& command);
  ~LineProcess();
  LineProcess(const LineProcess&) = delete;
  LineProcess& operator=(const LineProcess&) = delete;

  /// Keeps the line, and sends what is kept when there is much of it. Fails ("process.gone", "process.unresponsive") as
  /// ask() does.
  [[nodiscard]] Result<void> send_line(std::string_view line, std::chrono::milliseconds timeout);
  /// Sends what was told, and waits for one line. Fails ("process.gone") where it has ended, saying how;
  /// ("process.unresponsive") where it says or takes nothing for that long; ("process.garbage") on a line of more than
  /// a megabyte.
  [[nodiscard]] Result<std::string> send_request(std::string_view line, std::chrono::milliseconds timeout);

 private:
  LineProcess() = default;
  [[nodiscard]] Result<void> exchange(bool until_line, std::chrono::milliseconds timeout);
  [[nodiscard]] tl::unexpected<Error> ended();

  std::string command_;
  pid_t pid_{-1};
  int fd_{-1};
  std::string to_send_;
  std::string received_;
};

}  // namespace cosiva::adapters
