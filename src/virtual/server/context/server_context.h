#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/areas/control_areas.h"
#include "cosiva/virtual/server/context/server_link.h"
#include "cosiva/virtual/server/context/server_options.h"
#include "cosiva/virtual/server/exchange/agent_proxy.h"
#include "cosiva/virtual/server/exchange/traces.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/simulator/simulator.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// Messages that no vehicle of the registry sent and that cannot be used.
struct UnknownSenders {
  std::uint64_t logged{0};
  SimTime logged_at{};
  std::uint64_t unlogged{0};  ///< since the last line of the log
  std::uint64_t excess{0};    ///< of vehicles that exceed the number of vehicles that the server accepts
  std::optional<SimTime> excess_at{};
};

/// The proxies of the remote agents that are no vehicles.
struct RemoteAgents {
  AgentProxy physical_side{"physical side"};
  AgentProxy emulated_world{"emulated world"};
  AgentProxy gvs{"GVS"};
  AgentProxy battery_test{"battery test"};

  void archive(Archive& archive);  ///< the state, for a snapshot
};

/// What each part of the server is handed: the options, the time, the link, and the parts that hold what is known of
/// vehicles and of the zone. The members refer to each other: a context stays where it was made.
struct ServerContext {
  ServerOptions options;
  /// "<interface>/"
  std::string topic_prefix{
      (options.interface_name.empty() ? std::string(wire::default_interface) : options.interface_name) + "/"};
  wire::ServerTopics topics{wire::server_topics(options.area)};
  SimTime now{};  ///< of the input that is being handled
  ServerLink link{};
  ControlAreas areas{options.area};
  Traces traces{options.traces_max};
  MessagePublisher publisher{traces, options.as_values};
  RemoteAgents agents{};
  Registry registry{topic_prefix.substr(0, topic_prefix.size() - 1), options.vehicles_max};
  Simulator simulator{options.contract, options.rtm};
  bool state_stale{false};  ///< something that the state file holds has changed since the file was written
  std::uint64_t messages_refused{0};
  UnknownSenders unknown_senders{};
};

/// Traces each step of the simulator, as a message between two of its parts.
[[nodiscard]] Simulator::Step step_recorder(ServerContext& context);

/// Counts a message that no vehicle of the registry sent and that cannot be used; logs the first ones, and then one a
/// minute.
/// @param fault  what is wrong, to be read after "ignored '<topic>': "
void refuse_unknown_sender(ServerContext& context, const std::string& topic, const std::string& fault);
/// The same of a message of a vehicle for which the registry has no room, logged once a minute.
void refuse_excess_vehicle(ServerContext& context, const std::string& name);
/// A vehicle was refused in the last minute, because the registry is full.
[[nodiscard]] bool refuses_vehicles(const ServerContext& context);

}  // namespace cosiva::virtual_side
