#pragma once

#include <functional>
#include <optional>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::app {

/// Checks twice per second whether the file of a zone, or its sidecar file, differs from the zone in force, and
/// switches to its content once the file no longer changes. Content that the page saved is in force already, and
/// therefore no change.
class ZoneWatch {
 public:
  struct Handlers {
    std::function<std::optional<zone::ZoneConfiguration>()> in_force;
    std::function<void(std::string command)>
        give;  ///< to the core, which validates the zone and reports why it is refused
    std::function<void(const std::string& text)> print_info;
  };
  /// @param sidecar_file  empty: the sidecar file next to the zone's file
  ZoneWatch(adapters::EventLoop& loop, std::string file, std::string sidecar_file, Handlers handlers);

  /// One check, as by the timer; for tests.
  void check();

 private:
  void take(const zone::ZoneConfiguration& read);
  /// Sizes and times of both files; unchanged values mean that no program has written the files.
  [[nodiscard]] std::string stamp() const;

  std::string file_;
  std::string sidecar_file_;
  Handlers handlers_;
  std::optional<zone::ZoneConfiguration> at_rest_;  ///< content of the last completed check
  std::string at_rest_stamp_;
  std::optional<zone::ZoneConfiguration> settling_;
  int failed_checks_{0};
  adapters::Timer timer_;
};

}  // namespace cosiva::app
