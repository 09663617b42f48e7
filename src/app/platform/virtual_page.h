#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/app/platform/virtual_run.h"
#include "cosiva/app/platform/zone_watch.h"
#include "cosiva/hmi/server_page.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::app {

/// A world in virtual time behind the page: the page's calls are handled by the world's own event loop, and therefore
/// without a lock. The page can stop and step the clock and change its speed.
class VirtualPage {
 public:
  /// @param ended  called when the run's duration is over
  [[nodiscard]] static Result<std::unique_ptr<VirtualPage>> open(adapters::EventLoop& loop, VirtualRun& run,
                                                                 std::function<void()> ended);
  [[nodiscard]] std::uint16_t port() const { return page_->port(); }
  [[nodiscard]] PageHost::Clock clock() const;
  void set_clock(bool running, double speed);
  /// Runs for this duration while the clock is stopped; ends at the run's end.
  void step(SimDuration duration);

 private:
  using Steady = std::chrono::steady_clock;
  VirtualPage(adapters::EventLoop& loop, VirtualRun& run, std::function<void()> ended);
  [[nodiscard]] PageHost host();
  /// @param decoded  the same command, decoded; null: the server decodes it
  void command(std::string json, std::shared_ptr<const wire::InProcessMessage> decoded = {});
  void heartbeat();
  /// Runs at most to the run's end; returns false when the end is reached.
  bool run_for(SimDuration duration);
  void measure(Steady::time_point now);

  VirtualRun& run_;
  std::function<void()> ended_;
  std::unique_ptr<ServerPage> page_;
  std::unique_ptr<ZoneWatch> watch_;
  adapters::Timer timer_;
  bool running_{true};
  bool over_{false};
  double speed_;
  double reached_;  ///< virtual seconds per second, measured
  Steady::time_point last_heartbeat_;
  Steady::time_point measured_since_;
  SimTime measured_from_;
  bool reported_slow_{false};
};

/// Runs `up --virtual-time --page` until its duration, Ctrl-C or a signal ends it. Gives the exit status.
int run_virtual_page(VirtualRun& run);

}  // namespace cosiva::app
