#include "cosiva/virtual/server/registry/registry.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::virtual_side {

std::optional<Registry::Address> Registry::find_topic(std::string_view topic) const {
  const auto it = topics_.find(topic);
  if (it == topics_.end()) return std::nullopt;
  return it->second;
}

std::optional<VehicleIndex> Registry::find(std::string_view name) const {
  const auto it = names_.find(name);
  if (it == names_.end()) return std::nullopt;
  return it->second;
}

std::uint32_t Registry::display_number_for(std::string_view serial) const {
  const auto taken = [&](std::uint32_t n) {
    return std::ranges::any_of(proxies_, [n](const AivProxy& proxy) { return proxy.identity.number() == n; });
  };
  std::uint64_t digits = 0;
  std::uint64_t position = 1;
  for (std::size_t i = serial.size(); i > 0 && serial[i - 1] >= '0' && serial[i - 1] <= '9' && position <= 100'000;
       --i) {
    digits += position * static_cast<std::uint64_t>(serial[i - 1] - '0');
    position *= 10;
  }
  const auto number = static_cast<std::uint32_t>(digits);
  if (number != 0 && !taken(number)) return number;
  std::uint32_t running = 1;
  while (taken(running)) ++running;
  return running;
}

void Registry::add_topics(const wire::VehicleId& id, VehicleIndex index) {
  for (const auto topic :
       {VehicleTopic::connection, VehicleTopic::state, VehicleTopic::visualization, VehicleTopic::factsheet})
    topics_.emplace(wire::vda_topic(id, to_string(topic), interface_name_), Address{index, topic});
  topics_.emplace(wire::own_topic(wire::virtual_obstacles_ack_topic_prefix, id),
                  Address{index, VehicleTopic::perceived});
  topics_.emplace(wire::own_topic(wire::detected_obstacle_topic_prefix, id), Address{index, VehicleTopic::detected});
  topics_.emplace(wire::own_topic(wire::boards_topic_prefix, id), Address{index, VehicleTopic::boards});
}

std::optional<VehicleIndex> Registry::add(const wire::VehicleId& id, SimTime now) {
  if (proxies_.size() >= vehicles_max) return std::nullopt;
  const auto index = static_cast<VehicleIndex>(proxies_.size());
  Identity identity{id, display_number_for(id.serial_number), interface_name_};
  const bool is_new = names_.emplace(identity.name(), index).second;
  COSIVA_EXPECT(is_new);
  add_topics(id, index);
  proxies_.emplace_back(std::move(identity), now);
  COSIVA_EXPECT(names_.size() == proxies_.size() && topics_.size() == proxies_.size() * vehicle_topics);
  return index;
}

}  // namespace cosiva::virtual_side
