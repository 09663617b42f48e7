#include "cosiva/virtual/server/registry/registry.h"

#include <array>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::virtual_side {

namespace {

constexpr std::array vda_topics{VehicleTopic::connection, VehicleTopic::state, VehicleTopic::visualization,
                                VehicleTopic::factsheet};
constexpr std::array own_topics{VehicleTopic::perceived, VehicleTopic::detected, VehicleTopic::boards};
static_assert(vda_topics.size() + own_topics.size() == vehicle_topics);

}  // namespace

Registry::Registry(std::string interface_name, std::size_t vehicles_max)
    : interface_name_{std::move(interface_name)}, vehicles_max_{vehicles_max} {
  COSIVA_EXPECT(vehicles_max_ > 0 && vehicles_max_ <= vehicles_max_limit);
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
  std::uint64_t digits = 0;
  std::uint64_t position = 1;
  for (std::size_t i = serial.size(); i > 0 && serial[i - 1] >= '0' && serial[i - 1] <= '9' && position <= 100'000;
       --i) {
    digits += position * static_cast<std::uint64_t>(serial[i - 1] - '0');
    position *= 10;
  }
  const auto number = static_cast<std::uint32_t>(digits);
  if (number != 0 && !numbers_.contains(number)) return number;
  std::uint32_t running = 1;
  for (const std::uint32_t taken : numbers_) {
    if (taken != running) break;
    ++running;
  }
  return running;
}

std::vector<std::string> Registry::topics_of(const wire::VehicleId& id) const {
  std::vector<std::string> topics;
  topics.reserve(vehicle_topics);
  for (const auto topic : vda_topics) topics.push_back(wire::vda_topic(id, to_string(topic), interface_name_));
  for (const auto prefix :
       {wire::virtual_obstacles_ack_topic_prefix, wire::detected_obstacle_topic_prefix, wire::boards_topic_prefix})
    topics.push_back(wire::own_topic(prefix, id));
  return topics;
}

void Registry::add_topics(const wire::VehicleId& id, VehicleIndex index) {
  const std::vector<std::string> topics = topics_of(id);
  for (std::size_t i = 0; i < topics.size(); ++i)
    topics_.emplace(topics[i],
                    Address{index, i < vda_topics.size() ? vda_topics[i] : own_topics[i - vda_topics.size()]});
}

std::optional<VehicleIndex> Registry::add(const wire::VehicleId& id, SimTime now) {
  if (full()) return std::nullopt;
  const auto index = vacant_.empty() ? static_cast<VehicleIndex>(proxies_.size()) : *vacant_.begin();
  Identity identity{id, display_number_for(id.serial_number), interface_name_};
  const bool is_new = names_.emplace(identity.name(), index).second;
  COSIVA_EXPECT(is_new);
  add_topics(id, index);
  numbers_.insert(identity.number());
  if (vacant_.erase(index) > 0)
    proxies_[index] = AivProxy{std::move(identity), now};
  else
    proxies_.emplace_back(std::move(identity), now);
  check();
  return index;
}

void Registry::remove(VehicleIndex index) {
  AivProxy& proxy = proxies_[index];
  COSIVA_EXPECT(proxy.retired() && !vacant(index));
  for (const std::string& topic : topics_of(proxy.id())) topics_.erase(topic);
  names_.erase(proxy.name());
  numbers_.erase(proxy.identity.number());
  vacant_.insert(index);
  check();
}

std::optional<VehicleIndex> Registry::removable() const {
  std::optional<VehicleIndex> oldest;
  for (VehicleIndex v = 0; v < proxies_.size(); ++v) {
    const AivProxy& proxy = proxies_[v];
    if (vacant(v) || !proxy.unconfirmed() || proxy.state() != nullptr) continue;
    if (!oldest || proxy.membership.last_received() < proxies_[*oldest].membership.last_received()) oldest = v;
  }
  return oldest;
}

void Registry::check() const {
  COSIVA_EXPECT(names_.size() == known() && topics_.size() == known() * vehicle_topics && numbers_.size() == known());
}

bool Registry::add_again(const wire::VehicleId& id, std::uint32_t number, bool is_vacant) {
  const auto index = static_cast<VehicleIndex>(proxies_.size());
  Identity identity{id, number, interface_name_};
  if (is_vacant) {
    vacant_.insert(index);
  } else {
    if (full() || find(identity.name()) || !numbers_.insert(number).second) return false;
    names_.emplace(identity.name(), index);
    add_topics(id, index);
  }
  proxies_.emplace_back(std::move(identity), SimTime{});
  check();
  return true;
}

void Registry::archive(Archive& archive) {
  const std::size_t vehicles = archive.count(proxies_.size());
  if (archive.reads() && !proxies_.empty()) return archive.fail("vehicles are registered already");
  for (std::size_t i = 0; i < vehicles && !archive.failed(); ++i) {
    const auto index = static_cast<VehicleIndex>(i);
    bool is_vacant = vacant(index);
    wire::VehicleId id = archive.reads() ? wire::VehicleId{} : proxies_[i].id();
    std::uint32_t number = archive.reads() ? 0 : proxies_[i].identity.number();
    archive(is_vacant, id, number);
    if (archive.failed()) return;
    if (archive.reads() && !add_again(id, number, is_vacant))
      return archive.fail("a vehicle is registered twice, or there are too many");
    archive(proxies_[i]);
  }
}

}  // namespace cosiva::virtual_side
