#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/text_hash.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/registry/vehicle_topic.h"
#include "cosiva/virtual/server/right_of_way/convoys.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::virtual_side {

/// All proxies in the order of arrival, at most vehicles_max() of them. An entry that proved to be no vehicle can be
/// removed: its index is vacant until the next vehicle takes it, so that all other indices remain valid.
///
/// Invariant: each vehicle has one proxy, one name, and a display number that no other vehicle has, and each of its
/// topics leads to it. A vacant entry has neither name nor topic, and is retired.
class Registry {
 public:
  static constexpr std::size_t vehicles_max_default = 2'000;
  static constexpr std::size_t vehicles_max_limit = 100'000;  ///< the largest that can be chosen

  /// @param vehicles_max  limits the memory that a flood of invented names can occupy; at least 1 (checked)
  explicit Registry(std::string interface_name, std::size_t vehicles_max = vehicles_max_default);

  struct Address {
    VehicleIndex vehicle;
    VehicleTopic topic;
  };
  /// The vehicle and the kind of a known topic.
  [[nodiscard]] std::optional<Address> find_topic(std::string_view topic) const;
  [[nodiscard]] std::optional<VehicleIndex> find(std::string_view name) const;
  /// Gives a vehicle its proxy and display number; nothing when the registry is full.
  /// @param id  of a vehicle that has no proxy yet (checked)
  std::optional<VehicleIndex> add(const wire::VehicleId& id, SimTime now);
  /// Removes an entry, which is retired (checked) and not vacant (checked).
  void remove(VehicleIndex index);
  [[nodiscard]] bool vacant(VehicleIndex index) const { return vacant_.contains(index); }
  /// Of the entries that are no vehicle so far and never sent a state, the one without a message for the longest time:
  /// it makes room for another. Nothing: there is none.
  [[nodiscard]] std::optional<VehicleIndex> removable() const;
  [[nodiscard]] bool full() const { return known() >= vehicles_max_; }
  /// Number of vehicles; size() counts the vacant entries, too.
  [[nodiscard]] std::size_t known() const { return proxies_.size() - vacant_.size(); }
  [[nodiscard]] std::size_t vehicles_max() const { return vehicles_max_; }

  [[nodiscard]] std::size_t size() const { return proxies_.size(); }
  [[nodiscard]] AivProxy& operator[](VehicleIndex index) { return proxies_[index]; }
  [[nodiscard]] const AivProxy& operator[](VehicleIndex index) const { return proxies_[index]; }
  [[nodiscard]] auto begin() { return proxies_.begin(); }
  [[nodiscard]] auto end() { return proxies_.end(); }
  [[nodiscard]] auto begin() const { return proxies_.begin(); }
  [[nodiscard]] auto end() const { return proxies_.end(); }
  [[nodiscard]] const std::string& interface_name() const { return interface_name_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] std::uint32_t display_number_for(std::string_view serial) const;
  [[nodiscard]] std::vector<std::string> topics_of(const wire::VehicleId& id) const;
  void add_topics(const wire::VehicleId& id, VehicleIndex index);
  /// An entry of a snapshot, behind those before it; false where it cannot be one.
  [[nodiscard]] bool add_again(const wire::VehicleId& id, std::uint32_t number, bool is_vacant);
  void check() const;

  std::string interface_name_;
  std::size_t vehicles_max_;
  std::deque<AivProxy> proxies_;
  TextTable<Address> topics_;
  std::map<std::string, VehicleIndex, std::less<>> names_;
  std::set<std::uint32_t> numbers_;  ///< display numbers that are taken
  std::set<VehicleIndex> vacant_;
};

}  // namespace cosiva::virtual_side
