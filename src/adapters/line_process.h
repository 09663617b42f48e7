#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// A program that is used line by line, one response at a time: written to its standard input, read from its standard
/// output, both without ever waiting longer than is stated. Its standard error is inherited. The program runs in a
/// process group of its own, gets SIGTERM when the parent dies, and is killed with the object.
///
/// Invariant: the socket to the program is open, and the program's number is known until the program has been reaped.
class LineProcess {
 public:
  /// @param command  for /bin/sh
  /// Fails ("process.start").
  [[nodiscard]] static Result<std::unique_ptr<LineProcess>> start(const std::string& command);
  ~LineProcess();
  LineProcess(const LineProcess&) = delete;
  LineProcess& operator=(const LineProcess&) = delete;

  /// Buffers the line, and sends the buffer when it is large. Fails ("process.gone", "process.unresponsive") as ask()
  /// does.
  [[nodiscard]] Result<void> send_line(std::string_view line, std::chrono::milliseconds timeout);
  /// Sends the buffered lines, and waits for one line. Fails ("process.gone") where the program has ended, stating how;
  /// ("process.unresponsive") where it writes or reads nothing for that long; ("process.garbage") on a line of more
  /// than a megabyte.
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
