#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"
#include "cosiva/hmi/zone_library.h"
#include "cosiva/virtual/server/commands/values/decoded_command.h"
#include "cosiva/virtual/server/core/server_core.h"

namespace cosiva::app {

/// The program behind the page: a live server, or a world in virtual time.
struct PageHost {
  const virtual_side::ServerCore* core{};
  /// Called when the core has been given a command, or with the reason why it cannot be stored.
  using Decided = std::function<void(const Result<void>&)>;
  /// Gives the core a command as Input::command, as its text and decoded: once the command is durable, unless it is a
  /// Stop.
  std::function<void(const std::string& source, std::string json,
                     std::shared_ptr<const virtual_side::DecodedCommand> decoded, Decided decided)>
      command;
  std::function<SimTime()> now;
  std::shared_ptr<const ZoneLibrary> zones;  ///< never null
  std::string run_name;                      ///< shown on the page
  std::string scenario_name;                 ///< empty: none
  /// The zone's file, when edits may be saved into it; empty: they go to the user's own folder of zones.
  std::string zone_file;
  /// Requests and returns the latest image of the camera over the zone, as Netpbm's P5; null: there is no recent one.
  /// Empty where there is no camera.
  std::function<std::shared_ptr<const std::string>()> gvs_preview;

  struct Clock {
    bool is_virtual{false};
    bool running{true};
    double speed{1.0};  ///< virtual seconds per second
  };
  std::function<Clock()> clock;
  /// Only for virtual time; empty live. Speed 0.1…100.
  std::function<void(bool running, double speed)> set_clock;
  std::function<void(SimDuration)> step;  ///< runs for this long while the clock is stopped
};

/// The page's contract (docs/protocols/hmi-api.md): HTTP calls, and the live stream while a client is connected.
///
/// Invariant: the host has a core that takes commands, a clock and a library of zones.
class ServerPage {
 public:
  /// @param web_root  the page's built files; empty: the response to `/` explains how to build them
  [[nodiscard]] static Result<std::unique_ptr<ServerPage>> open(adapters::EventLoop& loop, PageHost host,
                                                                std::uint16_t port, std::string web_root,
                                                                bool headless);
  ~ServerPage();
  [[nodiscard]] std::uint16_t port() const;
  /// The plant's ground truth, for display only: shown next to twin and estimate, never used (ground_truth_topic's
  /// JSON).
  void ground_truth(const std::string& json);
  /// An input has been handled; a change that an operator waits for (a command's state) is sent at once, not at the
  /// next period.
  void changed();

 private:
  struct Impl;
  explicit ServerPage(std::unique_ptr<Impl> inside);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::app
