#include "cosiva/experiments/faults/ownership_monitor.h"

#include <algorithm>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::experiments {
namespace {

/// The vehicle that a message on an owner topic concerns, and the control area that the message names.
std::optional<std::pair<std::string, std::string>> owner_in(const std::string& topic, const std::string& payload) {
  const auto vehicle = wire::parse_own_topic(wire::owner_topic_prefix, topic);
  if (!vehicle) return std::nullopt;
  const auto owner = wire::owner_from_json(payload);
  return std::pair{wire::to_string(*vehicle), owner ? owner->area : std::string{}};
}

}  // namespace

void OwnershipMonitor::on_received(Process server, const wire::Input& message) {
  COSIVA_EXPECT(areas_.contains(server));
  const auto owner = owner_in(message.source, message.payload);
  if (!owner) return;
  const auto& [vehicle, area] = *owner;
  std::string& known = owners_[server][vehicle];
  if (known == areas_.at(server) && area != known) ++released_;
  known = area;
  handed_over_[server].erase(vehicle);
}

Finding OwnershipMonitor::on_published(Process server, const wire::Publish& message) {
  const std::string& own = areas_.at(server);
  if (const auto owner = owner_in(message.topic, message.payload)) {
    if (owner->second != own) handed_over_[server][owner->first] = owner->second;
    return std::nullopt;
  }
  const auto topic = wire::parse_vda_topic(message.topic);
  if (!topic || topic->vehicle.manufacturer == wire::virtual_manufacturer) return std::nullopt;
  if (topic->name != "order" && topic->name != "instantActions") return std::nullopt;
  const std::string vehicle = wire::to_string(topic->vehicle);
  if (owners_[server][vehicle] != own)
    return Violation{"I4", "the server of control area " + own + " sends " + topic->name + " to " + vehicle +
                               ", which it does not own"};
  if (handed_over_[server].contains(vehicle))
    return Violation{"I4", "the server of control area " + own + " sends " + topic->name + " to " + vehicle +
                               ", which it has handed over"};
  return std::nullopt;
}

void OwnershipMonitor::on_killed(Process server) {
  owners_.erase(server);
  handed_over_.erase(server);
}

Finding OwnershipMonitor::step(SimTime now, const std::map<Process, std::set<std::string>>& commanded) {
  std::map<std::string, int> servers;
  for (const auto& [server, vehicles] : commanded)
    for (const std::string& vehicle : vehicles) ++servers[vehicle];
  std::erase_if(both_since_, [&](const auto& both) { return servers[both.first] < 2; });
  for (const auto& [vehicle, count] : servers) {
    if (count < 2) continue;
    const SimTime since = both_since_.try_emplace(vehicle, now).first->second;
    both_longest_ = std::max(both_longest_, now - since);
    if (now - since > both_max)
      return Violation{
          "I4", "two servers have commanded " + vehicle + " for " + std::to_string(to_seconds(now - since)) + " s"};
  }
  return std::nullopt;
}

}  // namespace cosiva::experiments
