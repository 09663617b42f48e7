#include "cosiva/virtual/server/context/server_context.h"

#include <utility>

#include "cosiva/base/archive.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::uint64_t unknown_senders_logged_max = 20;
constexpr SimDuration log_again_after{std::chrono::minutes{1}};

}  // namespace

void RemoteAgents::archive(Archive& archive) { archive(physical_side, emulated_world, gvs, battery_test); }

Simulator::Step step_recorder(ServerContext& context) {
  return [&context](std::string_view from, std::string_view to, std::string_view kind, std::string_view content) {
    context.traces.add(context.now, from, to, kind, content);
  };
}

void refuse_unknown_sender(ServerContext& context, const std::string& topic, const std::string& fault) {
  ++context.messages_refused;
  UnknownSenders& senders = context.unknown_senders;
  if (senders.logged >= unknown_senders_logged_max && context.now - senders.logged_at < log_again_after) {
    ++senders.unlogged;
    return;
  }
  ++senders.logged;
  senders.logged_at = context.now;
  const std::uint64_t unlogged = std::exchange(senders.unlogged, 0);
  context.publisher.log('w', "ignored '" + topic.substr(0, 120) + "': " + fault +
                                 (unlogged > 0 ? " (and " + std::to_string(unlogged) + " more messages)" : ""));
}

void refuse_excess_vehicle(ServerContext& context, const std::string& name) {
  UnknownSenders& senders = context.unknown_senders;
  ++context.messages_refused;
  ++senders.excess;
  if (senders.excess_at && context.now - *senders.excess_at < log_again_after) return;
  senders.excess_at = context.now;
  context.publisher.log(
      'w', name.substr(0, 120) + ": not accepted, as the server already has its limit of " +
               std::to_string(context.registry.vehicles_max()) +
               " vehicles (--vehicles-max); messages of such vehicles so far: " + std::to_string(senders.excess));
}

bool refuses_vehicles(const ServerContext& context) {
  return context.unknown_senders.excess_at && context.now - *context.unknown_senders.excess_at < log_again_after;
}

}  // namespace cosiva::virtual_side
