#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/digest.h"
#include "virtual/server/outbox.h"
#include "virtual/server/proxy.h"
#include "virtual/server/traffic.h"
#include "virtual/server/way_map.h"

namespace cosiva::virtual_side {

struct RollerRules {
  double base_ahead_m{1.2};  ///< as much may be driven blind when the link breaks
  std::size_t horizon{4};    ///< nodes shown beyond the base
  std::size_t base_nodes_max{16};
  double deviation_m{0.10};   ///< allowedDeviationXY of every node but the first of a new order
  double on_circuit_m{0.30};  ///< a vehicle further off is not given orders
  double on_way_m{0.20};      ///< a vehicle nearer than this to the circuit stands in the way of others
  SimDuration resend_after{std::chrono::milliseconds{300}};
  SimDuration update_period{std::chrono::milliseconds{200}};
  SimDuration after_refusal{std::chrono::seconds{2}};
  SimDuration cancel_again{std::chrono::seconds{5}};
};

/// Rolls orders round the circuit for ever: an idle vehicle gets a new order, whose base is then pushed forward by
/// updates stitched at the last base node, as far as traffic allows. One update is on its way at a time, and is sent
/// again unchanged until the vehicle's state acknowledges it.
class OrderRoller {
 public:
  OrderRoller(Registry& registry, Traffic& traffic, Outbox& outbox, ActionDesk& desk)
      : registry_{registry}, traffic_{traffic}, outbox_{outbox}, desk_{desk} {}

  void set_map(const WayMap* map);  ///< takes back what was ordered on the old zone
  void resize(std::size_t vehicles) { plans_.resize(vehicles); }

  /// After the proxy took the state in. `before` is the state before it, if any.
  void on_state(VehicleIndex vehicle, const wire::State* before);
  /// An operator cancelled: no more updates of the order at hand.
  void stop_rolling(VehicleIndex vehicle);
  /// It has been taken away.
  void forget(VehicleIndex vehicle) { plans_[vehicle] = {}; }
  /// @param drive  give orders at all; otherwise only what is on its way is followed
  void tick(bool drive, SimDuration lost_after);

  /// Is this vehicle's last reported place good enough to drive from; set by the server at each report.
  struct Standing {
    std::optional<zone::Place> place;  ///< nearest on the circuit
    double off_m{};
    double heading_off_rad{};
  };
  void set_standing(VehicleIndex vehicle, const Standing& standing);

  /// Why it does not go on: a crossing or a vehicle; empty when nothing holds it.
  [[nodiscard]] std::string waits_for(VehicleIndex vehicle) const;
  /// How long it has waited for that, and the longest so far.
  [[nodiscard]] SimDuration longest_wait() const { return longest_wait_; }
  [[nodiscard]] std::uint64_t orders_sent() const { return orders_sent_; }
  [[nodiscard]] std::uint64_t updates_sent() const { return updates_sent_; }
  [[nodiscard]] std::uint64_t resent() const { return resent_; }
  void fold(Digest& digest) const;

 private:
  struct Plan {
    enum class Stage { none, running, cancelling };
    Stage stage{Stage::none};
    std::string order_id;
    std::uint32_t update_id{0};
    bool acknowledged{false};
    bool ever_acknowledged{false};
    WaypointIndex base_end{no_waypoint};
    std::uint32_t base_end_sequence{0};
    std::string payload;
    SimTime sent_at{};
    SimTime wait_until{};
    SimTime cancelled_at{};
    Standing standing;
    std::string strange_order;  ///< an order of somebody else's, noted once
    std::optional<CrossingIndex> waits_for_crossing;
    VehicleIndex waits_for_vehicle{no_vehicle};
    std::optional<SimTime> waits_since;
  };
  struct Extension {
    WaypointIndex from{no_waypoint};
    double reach_m{};
  };

  void follow(VehicleIndex vehicle, const wire::State& state);
  void adopt(VehicleIndex vehicle, const wire::State& state);
  bool refused(const Plan& plan, const wire::State& state, const wire::State* before, std::string& why) const;
  void give_up(VehicleIndex vehicle, const wire::State& state, const std::string& why);
  void drop(Plan& plan, VehicleIndex vehicle);
  void cancel(VehicleIndex vehicle);
  [[nodiscard]] bool may_roll(VehicleIndex vehicle, SimDuration lost_after) const;
  void step(VehicleIndex vehicle, bool drive, SimDuration lost_after);
  [[nodiscard]] std::optional<Extension> start_of_extension(VehicleIndex vehicle);
  void extend(VehicleIndex vehicle, const Extension& from);
  bool enter(VehicleIndex vehicle, WaypointIndex stop, double reach_m);
  void send(VehicleIndex vehicle, WaypointIndex first);
  void note_waiting(Plan& plan, SimTime now);

  Registry& registry_;
  Traffic& traffic_;
  Outbox& outbox_;
  ActionDesk& desk_;
  RollerRules rules_;
  const WayMap* map_{};
  std::vector<Plan> plans_;
  std::vector<WaypointIndex> extension_;  ///< of the vehicle at hand
  SimDuration longest_wait_{};
  std::uint64_t orders_sent_{0};
  std::uint64_t updates_sent_{0};
  std::uint64_t resent_{0};
};

}  // namespace cosiva::virtual_side
