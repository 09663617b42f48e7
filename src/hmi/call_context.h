#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/hmi/server_page.h"

namespace cosiva::app {

/// One request, parsed.
struct Call {
  const adapters::HttpRequest& request;
  std::vector<std::string> arguments;  ///< the path's parts at the pattern's {…}, in their order
  JsonValue body;                      ///< an object, where the route requires one
};

/// What the calls of one page have in common: the host whose core they use, and the obstacles of an emulated world.
/// Invariant: the host has a core and takes commands.
class CallContext {
 public:
  explicit CallContext(PageHost host);

  [[nodiscard]] const PageHost& host() const { return host_; }
  /// Has the core check a command and, where the core would accept it, gives it to the core. Fails with the core's
  /// refusal.
  [[nodiscard]] Result<void> give(std::string json);
  /// The clock of the run; the wall's where the host has none of its own.
  [[nodiscard]] PageHost::Clock clock() const;

  /// Replaces the obstacles that the emulated world reports: the only ones that can be removed.
  void know_plant(std::set<std::string> obstacles);
  /// Whether an emulated world has reported.
  [[nodiscard]] bool has_plant() const { return plant_obstacles_.has_value(); }
  [[nodiscard]] bool in_plant(const std::string& obstacle) const;
  /// A name that no obstacle of the emulated world has.
  [[nodiscard]] std::string next_obstacle_id();
  /// The core was given a command that adds it.
  void added_to_plant(const std::string& obstacle);
  /// The core was given a command that removes it.
  void removed_from_plant(const std::string& obstacle);

 private:
  PageHost host_;
  std::uint64_t boxes_{0};
  std::optional<std::set<std::string>> plant_obstacles_;  ///< nothing: no emulated world has reported
  std::set<std::string> plant_added_;  ///< by these calls, and not yet reported by the emulated world
};

}  // namespace cosiva::app
