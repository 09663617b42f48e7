#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/hmi/server_page.h"
#include "cosiva/hmi/stop_book.h"
#include "cosiva/hmi/unique_ids.h"
#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::app {

/// A zone of a request, with the command that switches to it, decoded and the zone built.
struct GivenZone {
  zone::ZoneConfiguration configuration;
  std::string command;
  std::shared_ptr<const virtual_side::DecodedCommand> decoded;
};

/// One request, parsed.
struct Call {
  adapters::HttpRequest request;
  std::vector<std::string> arguments;     ///< the path's parts at the pattern's {…}, in their order
  JsonValue body;                         ///< an object, where the route requires one
  std::shared_ptr<const GivenZone> zone;  ///< where the route takes a zone; the body is then empty
};

/// What the calls of one page have in common: the host whose core they use, and the obstacles of an emulated world.
/// Invariant: the host has a core and takes commands.
class CallContext {
 public:
  explicit CallContext(PageHost host);

  [[nodiscard]] const PageHost& host() const { return host_; }
  /// An id that no other command has or will have.
  [[nodiscard]] std::string next_command_id() { return command_ids_.next(); }
  /// Has the core check a command and, where the core would accept it, gives it to the core, now or once the command is
  /// durable. A command with a client's id that the core was given before is not given again. Fails with the core's
  /// refusal.
  [[nodiscard]] Result<void> give(std::string json);
  /// Gives a command that the core evaluates itself, whatever a check would find.
  void give_unchecked(std::string json, std::shared_ptr<const virtual_side::DecodedCommand> decoded);
  /// The response to the present request depends on what its commands have made of the platform: `response` is called
  /// once they are decided, and replaces what the handler returned.
  void respond_once_decided(std::function<adapters::HttpResponse()> response) { response_ = std::move(response); }
  [[nodiscard]] std::function<adapters::HttpResponse()> take_response() { return std::exchange(response_, {}); }
  /// How many of those commands are not decided.
  [[nodiscard]] std::size_t undecided() const { return undecided_; }
  /// Calls `action` each time that no command is undecided any more.
  void on_decided(std::function<void()> action) { on_decided_ = std::move(action); }
  /// Why a command since the last call could not be stored; nothing where all could.
  [[nodiscard]] std::optional<Error> take_failure() { return std::exchange(failure_, std::nullopt); }
  /// The Stops of the page; their book may be used from any thread.
  [[nodiscard]] const std::shared_ptr<StopBook>& stops() const { return stops_; }
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
  std::shared_ptr<StopBook> stops_{std::make_shared<StopBook>()};
  UniqueIds command_ids_{'C'};
  std::size_t undecided_{0};
  std::optional<Error> failure_;
  std::function<adapters::HttpResponse()> response_;
  std::function<void()> on_decided_;
  std::uint64_t boxes_{0};
  std::optional<std::set<std::string>> plant_obstacles_;  ///< nothing: no emulated world has reported
  std::set<std::string> plant_added_;  ///< by these calls, and not yet reported by the emulated world
};

}  // namespace cosiva::app
