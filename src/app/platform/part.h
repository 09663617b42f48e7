#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/live_shell.h"
#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {

/// One part (server, plant, vehicle) running alone in its process until a signal or its duration ends it.
class Part {
 public:
  /// @param summary  the core's metrics at the end, as JSON
  Part(adapters::EventLoop& loop, adapters::LiveShell& shell, std::string kind, const PartArguments& arguments,
       std::function<std::string()> summary);

  /// Starts the shell and runs to the end: summary file, JSON and journal are written. Gives the exit status.
  int run();

 private:
  void end();
  void finish(const std::string& digest);

  adapters::EventLoop& loop_;
  adapters::LiveShell& shell_;
  std::string kind_;
  const PartArguments& arguments_;
  std::function<std::string()> summary_;
  std::string summary_at_end_;
  adapters::WallClock clock_;
  SimTime started_;
  adapters::Timer duration_;
  adapters::Timer alive_;  ///< for `up`: a sign of life twice a second
  bool ending_{false};
  int status_{0};
};

/// The sign of life of a part that announces.
inline constexpr const char* alive_event = R"({"event":"alive"})";
/// Between two of them: each is sent from the part's loop, so that a
/// loop that hangs sends none.
inline constexpr std::chrono::milliseconds alive_period{500};

/// Prints one event for `up`, as a JSON line on standard output.
void announce(const PartArguments& arguments, const std::string& json);

/// Reads and builds the zone, so that a bad file is reported at the start and not by a core later; the core takes this
/// RTM. Fails as load_zone and zone::Rtm::initialise do.
/// @param name_or_file  a ready zone's name or a file
[[nodiscard]] Result<std::shared_ptr<const zone::Rtm>> load_good_zone(const std::string& name_or_file);

/// The options of a part's live shell. Fails as mqtt_options does.
/// @param kind     of the core: "server", "plant" or "aiv"
/// @param name     of the part on the broker
/// @param options  the core's, as JSON
[[nodiscard]] Result<adapters::LiveOptions> live_options(const PartArguments& part, std::string kind, std::string name,
                                                         std::string options);

}  // namespace cosiva::app
