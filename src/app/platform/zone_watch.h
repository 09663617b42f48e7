#pragma once

#include <functional>
#include <optional>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::app {

/// Looks twice a second whether the file of a zone, or its sidecar file, holds something else than what is in force,
/// and switches to that once it has settled. What the page saved is in force already, so that is no change.
class ZoneWatch {
 public:
  struct Handlers {
    std::function<std::optional<zone::ZoneConfiguration>()> in_force;
    std::function<void(std::string command)> give;  ///< to the core, which judges it and says why it refuses
    std::function<void(const std::string& text)> print_info;
  };
  /// @param sidecar_file  empty: the one beside the file
  ZoneWatch(adapters::EventLoop& loop, std::string file, std::string sidecar_file, Handlers handlers);

  /// As the timer does; for tests.
  void check();

 private:
  void take(const zone::ZoneConfiguration& read);
  /// Sizes and times of both files; the same as before: nobody has written them.
  [[nodiscard]] std::string stamp() const;

  std::string file_;
  std::string sidecar_file_;
  Handlers handlers_;
  std::optional<zone::ZoneConfiguration> at_rest_;  ///< as last read and done with
  std::string at_rest_stamp_;
  std::optional<zone::ZoneConfiguration> settling_;
  int failed_checks_{0};
  adapters::Timer timer_;
};

}  // namespace cosiva::app
