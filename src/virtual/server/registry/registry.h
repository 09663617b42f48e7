#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/registry/vehicle_topic.h"
#include "cosiva/virtual/server/right_of_way/convoys.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::virtual_side {

/// All proxies in the order of arrival; no proxy is ever removed.
///
/// Invariant: each vehicle has one proxy, one name, and a display number that no other vehicle has, and each of its
/// topics leads to it.
class Registry {
 public:
  static constexpr std::size_t vehicles_max = 256;  ///< limits the memory that a flood of invented names can occupy

  explicit Registry(std::string interface_name) : interface_name_{std::move(interface_name)} {}

  struct Address {
    VehicleIndex vehicle;
    VehicleTopic topic;
  };
  /// The vehicle and the kind of a known topic.
  [[nodiscard]] std::optional<Address> find_topic(std::string_view topic) const;
  [[nodiscard]] std::optional<VehicleIndex> find(std::string_view name) const;
  /// Gives a vehicle its proxy and display number; nothing when there are too many vehicles.
  /// @param id  of a vehicle that has no proxy yet (checked)
  std::optional<VehicleIndex> add(const wire::VehicleId& id, SimTime now);

  [[nodiscard]] std::size_t size() const { return proxies_.size(); }
  [[nodiscard]] AivProxy& operator[](VehicleIndex index) { return proxies_[index]; }
  [[nodiscard]] const AivProxy& operator[](VehicleIndex index) const { return proxies_[index]; }
  [[nodiscard]] auto begin() { return proxies_.begin(); }
  [[nodiscard]] auto end() { return proxies_.end(); }
  [[nodiscard]] auto begin() const { return proxies_.begin(); }
  [[nodiscard]] auto end() const { return proxies_.end(); }
  [[nodiscard]] const std::string& interface_name() const { return interface_name_; }

 private:
  [[nodiscard]] std::uint32_t display_number_for(std::string_view serial) const;
  void add_topics(const wire::VehicleId& id, VehicleIndex index);

  std::string interface_name_;
  std::deque<AivProxy> proxies_;
  std::map<std::string, Address, std::less<>> topics_;
  std::map<std::string, VehicleIndex, std::less<>> names_;
};

}  // namespace cosiva::virtual_side
