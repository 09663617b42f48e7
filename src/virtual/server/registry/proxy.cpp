#include "cosiva/virtual/server/registry/proxy.h"

#include <algorithm>
#include <utility>

#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {

std::optional<VehicleTopic> parse_vehicle_topic(std::string_view name) {
  if (name == "state") return VehicleTopic::state;
  if (name == "visualization") return VehicleTopic::visualization;
  if (name == "connection") return VehicleTopic::connection;
  if (name == "factsheet") return VehicleTopic::factsheet;
  return std::nullopt;
}

std::string_view to_string(VehicleTopic topic) {
  switch (topic) {
    case VehicleTopic::connection: return "connection";
    case VehicleTopic::state: return "state";
    case VehicleTopic::visualization: return "visualization";
    case VehicleTopic::factsheet: return "factsheet";
    case VehicleTopic::perceived: return "virtual_obstacles_ack";
    case VehicleTopic::detected: return "detected_obstacle";
    case VehicleTopic::boards: return "boards";
  }
  return "?";
}

std::optional<bool> AivProxy::supports(std::string_view instant_action) const {
  if (!factsheet) return std::nullopt;
  return std::ranges::any_of(factsheet->actions,
                             [&](const auto& action) { return action.instant && action.type == instant_action; });
}

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
    return std::ranges::any_of(proxies_, [n](const AivProxy& p) { return p.number == n; });
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

std::optional<VehicleIndex> Registry::add(const wire::VehicleId& id, SimTime now) {
  if (proxies_.size() >= vehicles_max) return std::nullopt;
  const auto index = static_cast<VehicleIndex>(proxies_.size());
  AivProxy proxy;
  proxy.id = id;
  proxy.name = wire::to_string(id);
  proxy.number = display_number_for(id.serial_number);
  proxy.order_topic = wire::vda_topic(id, "order", interface_name_);
  proxy.actions_topic = wire::vda_topic(id, "instantActions", interface_name_);
  proxy.first_received = now;
  for (const auto topic :
       {VehicleTopic::connection, VehicleTopic::state, VehicleTopic::visualization, VehicleTopic::factsheet})
    topics_.emplace(wire::vda_topic(id, to_string(topic), interface_name_), Address{index, topic});
  topics_.emplace(wire::own_topic(wire::virtual_obstacles_ack_topic_prefix, id),
                  Address{index, VehicleTopic::perceived});
  topics_.emplace(wire::own_topic(wire::detected_obstacle_topic_prefix, id), Address{index, VehicleTopic::detected});
  topics_.emplace(wire::own_topic(wire::boards_topic_prefix, id), Address{index, VehicleTopic::boards});
  proxy.augmented = id.manufacturer == wire::virtual_manufacturer;
  names_.emplace(proxy.name, index);
  proxies_.push_back(std::move(proxy));
  return index;
}

void Registry::renew(VehicleIndex index, SimTime now) {
  AivProxy& old = proxies_[index];
  AivProxy next;
  next.id = old.id;
  next.name = old.name;
  next.number = old.number;
  next.order_topic = old.order_topic;
  next.actions_topic = old.actions_topic;
  next.augmented = old.augmented;
  next.priority = old.priority;
  next.first_received = now;
  next.twin = old.twin;
  next.entity = old.entity;
  next.messages = old.messages;
  next.headers_missed = old.headers_missed;
  next.refused = old.refused;
  next.outdated = old.outdated;
  next.order_header_id = old.order_header_id;
  next.actions_header_id = old.actions_header_id;
  old = std::move(next);
}

}  // namespace cosiva::virtual_side
