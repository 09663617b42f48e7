#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"
#include "cosiva/hmi/zone_library.h"
#include "cosiva/virtual/server/core/server_core.h"

namespace cosiva::app {

/// Who the page speaks for: a live server, or a world in virtual time.
struct PageHost {
  const virtual_side::ServerCore* core{};
  /// Gives the core a command as Input::command.
  std::function<void(const std::string& source, std::string json)> command;
  std::function<SimTime()> now;
  std::shared_ptr<const ZoneLibrary> zones;  ///< never null
  std::string run_name;                      ///< shown on the page
  std::string scenario_name;                 ///< empty: none
  /// The zone's file, when edits may be saved into it; empty: they go to the user's own folder of zones.
  std::string zone_file;
  /// The last picture of the camera over the zone, as Netpbm's P5, and word to it that somebody looks; null: none came
  /// lately. Empty where there is none to ask.
  std::function<std::shared_ptr<const std::string>()> gvs_preview;

  struct Clock {
    bool is_virtual{false};
    bool running{true};
    double speed{1.0};  ///< virtual seconds per second
  };
  std::function<Clock()> clock;
  /// Only for virtual time; empty live. Speed 0.1…100.
  std::function<void(bool running, double speed)> set_clock;
  std::function<void(SimDuration)> step;  ///< runs so much while the clock stands
};

/// The page's contract (docs/protocols/hmi-api.md): HTTP calls, and the live stream while somebody looks.
class ServerPage {
 public:
  /// @param web_root  the page's built files; empty: `/` says how to build them
  [[nodiscard]] static Result<std::unique_ptr<ServerPage>> open(adapters::EventLoop& loop, PageHost host,
                                                                std::uint16_t port, std::string web_root,
                                                                bool headless);
  ~ServerPage();
  [[nodiscard]] std::uint16_t port() const;
  /// What the plant says is true, for the eye only: shown beside twin and belief, never used (ground_truth_topic's
  /// JSON).
  void ground_truth(const std::string& json);
  /// An input has been handled; what an operator waits for (a command's state) is sent at once, not at the next beat.
  void changed();

 private:
  struct Impl;
  explicit ServerPage(std::unique_ptr<Impl> inside);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::app
