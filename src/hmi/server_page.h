#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"
#include "cosiva/hmi/zone_library.h"
#include "cosiva/virtual/server/commands/values/decoded_command.h"
#include "cosiva/virtual/server/core/server_core.h"

namespace cosiva::app {

/// The sender of Stops that works without the core (adapters::StopSender); its functions are called from the page's
/// thread. All are empty where only the core publishes Stops.
struct StopLine {
  /// Publishes the Stop to the vehicles ("*": all) that the sender knows; whether it knows all of them.
  std::function<bool(const std::string& id, const std::vector<std::string>& vehicles)> send;
  /// The vehicles may drive again.
  std::function<void(const std::vector<std::string>& vehicles)> lift;
  /// The vehicles that have not confirmed the Stop of this id.
  std::function<std::vector<std::string>(const std::string& id)> unconfirmed;
};

/// The program behind the page: a live server, or a world in virtual time.
struct PageHost {
  const virtual_side::ServerCore* core{};
  /// Called when the core has been given a command, or with the reason why it cannot be stored.
  using Decided = std::function<void(const Result<void>&)>;
  /// Gives the core a command as Input::command, as its text and decoded: once the command is durable.
  std::function<void(const std::string& source, std::string json,
                     std::shared_ptr<const virtual_side::DecodedCommand> decoded, Decided decided)>
      command;
  /// Gives the core a Stop at once; `durable` is called once its record is durable. Empty: nothing is recorded, and
  /// `command` gives it.
  std::function<void(const std::string& source, std::string json,
                     std::shared_ptr<const virtual_side::DecodedCommand> decoded, std::function<void()> durable)>
      stop;
  StopLine stop_line;
  /// Whether the core has still to be given commands that an earlier process accepted (LiveShell); changes wait until
  /// it has. Empty: there are none.
  std::function<bool()> gives_earlier_commands;
  std::function<SimTime()> now;
  std::shared_ptr<const ZoneLibrary> zones;  ///< never null
  std::string run_name;                      ///< shown on the page
  std::string scenario_name;                 ///< empty: none
  /// The zone's file, when edits may be saved into it; empty: they go to the user's own folder of zones.
  std::string zone_file;
  /// Requests and returns the latest image of the camera over the zone, as Netpbm's P5; null: there is no recent one.
  /// Empty where there is no camera.
  std::function<std::shared_ptr<const std::string>()> gvs_preview;

  /// The parts of the platform and their state, as a JSON array (Supervisor); empty text: not known. Empty where no
  /// supervisor runs the parts.
  std::function<std::string()> parts_json;

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

/// The page's contract (docs/protocols/hmi-api.md): HTTP calls, and the live stream while a client is connected. The
/// HTTP server has a thread of its own, and long bodies are read by another one; the core is used on its own loop only.
///
/// Invariant: the host has a core that takes commands, a clock and a library of zones.
class ServerPage {
 public:
  /// @param loop      of the core: functions of the host are called from it, except those of the Stop line
  /// @param web_root  the page's built files; empty: the response to `/` explains how to build them
  [[nodiscard]] static Result<std::unique_ptr<ServerPage>> open(adapters::EventLoop& loop, PageHost host,
                                                                std::uint16_t port, std::string web_root,
                                                                bool headless);
  ~ServerPage();
  [[nodiscard]] std::uint16_t port() const;
  /// The plant's ground truth, for display only: shown next to twin and estimate, never used (ground_truth_topic's
  /// JSON).
  void ground_truth(std::string json);
  /// An input has been handled; a change that an operator waits for (a command's state) is sent at once, not at the
  /// next period.
  void changed();

 private:
  struct Impl;
  explicit ServerPage(std::unique_ptr<Impl> inside);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::app
