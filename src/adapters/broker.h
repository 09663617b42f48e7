#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/adapters/child_process.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

struct BrokerOptions {
  std::string run_directory;                             ///< its configuration goes here, readable by this user alone
  std::string log_file;                                  ///< empty: its output goes to our stderr
  std::string program;                                   ///< empty: searched in PATH and /usr/sbin
  std::function<void(std::string_view bytes)> on_log{};  ///< takes its output in place of log_file
};

/// A private mosquitto on 127.0.0.1: not reachable from other machines, and without state that outlives it. Its queues
/// hold what a reader that stalls for a few seconds misses, and are bounded; what exceeds them, the broker logs. Nagle
/// is off at both ends.
///
/// Invariant: the broker is launched on one port, chosen before.
class PrivateBroker {
 public:
  /// Starts the broker on a free port and waits until it accepts. Fails ("broker.missing", "broker.start").
  [[nodiscard]] static Result<std::unique_ptr<PrivateBroker>> start(EventLoop& loop, BrokerOptions options);
  ~PrivateBroker();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] Child* child() { return child_.get(); }
  /// Called when the broker ends without a request to end.
  void on_exit(std::function<void(const ChildExit&)> action) { on_exit_ = std::move(action); }
  /// Starts the broker again on the same port, which its clients know. Does not wait until it accepts.
  [[nodiscard]] Result<void> restart();

 private:
  PrivateBroker(EventLoop& loop, BrokerOptions options) : loop_{loop}, options_{std::move(options)} {}
  [[nodiscard]] Result<void> launch();
  [[nodiscard]] std::string configuration_path() const { return options_.run_directory + "/mosquitto.conf"; }

  EventLoop& loop_;
  BrokerOptions options_;
  std::uint16_t port_{0};
  std::function<void(const ChildExit&)> on_exit_;
  std::unique_ptr<Child> child_;
};

/// A TCP port of 127.0.0.1 that was free a moment ago.
[[nodiscard]] Result<std::uint16_t> find_free_port();

}  // namespace cosiva::adapters
