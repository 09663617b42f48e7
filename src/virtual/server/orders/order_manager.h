#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/orders/missions.h"
#include "cosiva/virtual/server/orders/wait_graph.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

struct OrderRules {
  double base_ahead_m{1.2};  ///< maximum distance driven without control when the link breaks
  std::size_t horizon{4};    ///< nodes announced beyond the base
  std::size_t base_nodes_max{16};
  double deviation_m{0.10};   ///< allowedDeviationXY of every node but the first of a new order
  double arrived_m{0.06};     ///< a vehicle stopped nearer than this to its goal has arrived; past it, `deviation_m`
  double on_circuit_m{0.30};  ///< a vehicle further from the circuit gets no orders
  double on_path_m{0.20};     ///< a vehicle nearer than this to the circuit obstructs others
  SimDuration resend_after{std::chrono::milliseconds{300}};
  SimDuration update_period{std::chrono::milliseconds{200}};
  SimDuration after_refusal{std::chrono::seconds{2}};
  SimDuration let_in_for{std::chrono::seconds{5}};  ///< a vehicle that waits off the path
  SimDuration other_position_after{std::chrono::seconds{1}};
  SimDuration make_room_after{std::chrono::seconds{4}};  ///< then joins the path even where it cannot continue
  SimDuration join_timeout{std::chrono::seconds{15}};
  SimDuration cancel_again{std::chrono::seconds{5}};
  SimDuration unresponsive_for{std::chrono::seconds{12}};  ///< a CoSiVA vehicle stopped with base ahead for no reason
  SimDuration yield_time_max{std::chrono::seconds{12}};    ///< at most
  double others_left_m{0.5};                               ///< continues when the others have moved this far
  double back_up_m_max{0.5};
};

/// The means by which a vehicle lets others out of a deadlock, the cheapest first.
enum class Means : std::uint8_t {
  move_up,  ///< closes up to its leader as far as its obstacle sensor permits, so that its follower leaves a crossing
  wait,     ///< releases what it requested and holds ahead, and lets the others go first
  detour,   ///< takes another route
  other_position,  ///< joins the path at another position
  back_up,         ///< drives backwards along the path, and lets the others go first
};

/// Extends orders along each vehicle's mission: an idle vehicle gets a new order, whose base is then extended by
/// updates stitched at the last base node, as far as traffic permits. One update is pending at a time, and is repeated,
/// with the same content under a new header, until the vehicle's state acknowledges it. order_way.cpp finds the route,
/// order_roller.cpp manages the orders, order_join.cpp brings off-path vehicles onto the path, order_waits.cpp finds
/// which vehicle waits for which, order_give_way.cpp resolves deadlocks.
class OrderManager {
 public:
  OrderManager(Registry& registry, Traffic& traffic, MessagePublisher& publisher, InstantActionSender& action_sender,
               Missions& missions, Simulator& simulator)
      : registry_{registry},
        traffic_{traffic},
        publisher_{publisher},
        action_sender_{action_sender},
        missions_{missions},
        simulator_{simulator} {}

  void set_map(const WaypointGraph* map);  ///< cancels the orders on the old zone
  void resize(std::size_t vehicles) { plans_.resize(vehicles); }

  /// To be called after the proxy has stored the state. `before` is the previous state, if any.
  void on_state(VehicleIndex vehicle, const wire::State* before);
  /// An operator has cancelled: the present order gets no more updates.
  void stop_rolling(VehicleIndex vehicle);
  /// The vehicle has been removed.
  void forget(VehicleIndex vehicle) { plans_[vehicle] = {}; }
  /// @param drive     send orders; otherwise only pending orders are tracked
  /// @param send_off  send orders to vehicles that have none
  void tick(bool drive, bool send_off, SimDuration lost_after);

  /// The vehicle's last reported pose relative to the circuit; set by the server at each report.
  struct ReportedPose {
    std::optional<zone::TrackPosition> position;  ///< nearest on the circuit
    double off_m{};
    double heading_off_rad{};
    Pose2 X_MB{};
  };
  void set_reported_pose(VehicleIndex vehicle, const ReportedPose& reported);

  /// The vehicle has an order on the zone in force.
  [[nodiscard]] bool has_order(VehicleIndex vehicle) const { return plans_[vehicle].stage == Plan::Stage::running; }
  /// The position at which an off-path vehicle joins the path; nothing: the vehicle is on the path, or has not been
  /// sent there.
  [[nodiscard]] const std::optional<zone::TrackPosition>& entry_point(VehicleIndex vehicle) const {
    return plans_[vehicle].entry_point;
  }
  /// The name of the vehicle that occupies the goal of this vehicle's mission; empty: none.
  [[nodiscard]] std::string blocker_at_goal(VehicleIndex vehicle) const;

  /// What the vehicle waits for: a crossing or a vehicle; empty: nothing.
  [[nodiscard]] std::string waits_for(VehicleIndex vehicle) const;
  /// The longest wait so far.
  [[nodiscard]] SimDuration longest_wait() const { return longest_wait_; }
  /// Adds the waits of this tick; only of stopped vehicles.
  void add_waits(WaitGraph& graph) const;
  [[nodiscard]] bool is_off_path(VehicleIndex vehicle) const { return goes_onto_line(vehicle); }
  /// "CoSiVA/AIV1 waits for X3, where CoSiVA/AIV2 is".
  [[nodiscard]] std::string sentence(const Wait& wait) const;

  /// The cost of yielding so that `waits`, all of which are for this vehicle, end: the distance to back up [m], 0 for
  /// all other means. Nothing: the vehicle cannot yield by `means`.
  [[nodiscard]] std::optional<double> can_yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits);
  /// False: the means could not be applied.
  bool yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits);
  /// The deadlock is resolved: the vehicle may use the avoided sections again.
  void need_not_avoid(VehicleIndex vehicle) { missions_.need_not_avoid(vehicle); }
  /// The vehicle is stopped for others, or is backing up for them.
  [[nodiscard]] bool yields(VehicleIndex vehicle) const { return plans_[vehicle].yielding.has_value(); }

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
    bool has_horizon{false};  ///< the last order announces nodes beyond its base
    std::uint32_t base_end_sequence{0};
    MessagePublisher::SentOrder sent;  ///< the last order sent by this server
    SimTime sent_at{};
    SimTime wait_until{};
    SimTime cancelled_at{};
    ReportedPose reported;
    std::string strange_order;  ///< an order from another sender, logged once
    std::optional<CrossingIndex> waits_for_crossing;
    VehicleIndex waits_for_vehicle{no_vehicle};
    WaitReason waits_why{WaitReason::ahead};
    std::optional<SimTime> waits_since;
    std::optional<SimTime> unresponsive_since;           ///< stopped with base ahead, no reason reported
    InstantActionSender::ActionHandle cancel_handle{0};  ///< of the pending cancelOrder; 0: none
    std::uint64_t route_of{0};                ///< revision of the missions for which its course was planned; 0: none
    std::optional<zone::SectionId> no_route;  ///< section from which there is no route
    std::optional<zone::TrackPosition> entry_point;    ///< where it joins the path
    InstantActionSender::ActionHandle join_handle{0};  ///< of the pending joinLine; 0: none
    SimTime join_sent_at{};
    struct Yielding {
      SimTime until{};
      std::vector<std::pair<VehicleIndex, Point2>> others;  ///< the other vehicles, and their positions at the start
      bool drops_order{false};
      double back_m{0.0};                           ///< 0: does not back up
      InstantActionSender::ActionHandle handle{0};  ///< of its backUp; 0: not sent yet
      double clear_m{0.0};                          ///< stops when any body is nearer
      bool stopped{false};                          ///< while backing up, as a body came near
    };
    std::optional<Yielding> yielding;
    bool moves_up{false};  ///< the next stretch may end nearer to the leader than the gap
  };
  struct Extension {
    WaypointIndex from{no_waypoint};
    double reach_m{};
  };

  void follow(VehicleIndex vehicle, const wire::State& state);
  void adopt(VehicleIndex vehicle, const wire::State& state);
  [[nodiscard]] std::optional<WaypointIndex> adopt_course(VehicleIndex vehicle, const wire::State& state);
  bool refused(const Plan& plan, const wire::State& state, const wire::State* before, std::string& why) const;
  void give_up(VehicleIndex vehicle, const wire::State& state, const std::string& why);
  void drop(Plan& plan, VehicleIndex vehicle);
  void cancel(VehicleIndex vehicle);
  [[nodiscard]] bool may_roll(VehicleIndex vehicle) const;
  void step(VehicleIndex vehicle, bool drive, bool send_off);
  void extend(VehicleIndex vehicle, const Extension& from);
  [[nodiscard]] bool leads_too_far(VehicleIndex vehicle);
  [[nodiscard]] bool comes_again(VehicleIndex vehicle, const Extension& from, std::size_t passed,
                                 const WaypointGraph::Stretch& stretch) const;
  bool enter(VehicleIndex vehicle, double stop_m, double exit_m);
  /// Distances of a chain to its stop line, to the next waypoint and to its exit.
  struct ChainAhead {
    double stop_m;
    double next_m;
    double exit_m;
  };
  /// The base may reach up to the leader: the vehicle's obstacle sensor keeps the distance.
  [[nodiscard]] bool detects_leader(VehicleIndex vehicle, VehicleIndex ahead) const;
  [[nodiscard]] bool joins_convoy(VehicleIndex vehicle, const ChainAhead& chain);
  void join_convoy(VehicleIndex vehicle);
  void send(VehicleIndex vehicle, const Extension& from);

  // order_way.cpp
  [[nodiscard]] std::optional<Extension> start_of_extension(VehicleIndex vehicle);
  [[nodiscard]] std::optional<Extension> end_of_base(VehicleIndex vehicle);
  [[nodiscard]] std::optional<Extension> first_node(VehicleIndex vehicle);
  bool plan_course(VehicleIndex vehicle);
  bool plan_course_again(VehicleIndex vehicle);
  /// The vehicle has passed the end of its mission's route.
  [[nodiscard]] bool past_goal(VehicleIndex vehicle) const;
  /// The vehicle has no order and needs none: it is stopped at its goal, or is about to stop there.
  [[nodiscard]] bool stays_at_goal(VehicleIndex vehicle);
  bool regain_course(VehicleIndex vehicle);
  void take_course(VehicleIndex vehicle, zone::Course course);
  [[nodiscard]] const WaypointGraph::Stretch* next_stretch(VehicleIndex vehicle, WaypointIndex at, std::size_t passed);
  [[nodiscard]] bool off_path(VehicleIndex vehicle) const;
  [[nodiscard]] bool goes_onto_line(VehicleIndex vehicle) const;
  [[nodiscard]] VehicleIndex obstructs_line_entry(VehicleIndex vehicle, zone::TrackPosition entry_point) const;
  /// An off-path vehicle, or one joining the path, that prevents this vehicle from driving from `from_m` to `to_m`
  /// ahead.
  [[nodiscard]] VehicleIndex off_path_obstruction(VehicleIndex vehicle, double from_m, double to_m) const;
  /// The position where an off-path vehicle is to join the path, or would join if it were let in.
  [[nodiscard]] std::optional<zone::TrackPosition> comes_onto_line_at(VehicleIndex vehicle) const;
  void follow_line(VehicleIndex vehicle);
  void keep_off_path(VehicleIndex vehicle);

  // order_join.cpp
  /// The vehicle has a pending joinLine.
  [[nodiscard]] bool joining(VehicleIndex vehicle);
  /// Sends the vehicle to another position on the path when the nearest one is not free.
  void try_other_positions(VehicleIndex vehicle);
  /// @param drives_on  only positions from which it can continue; otherwise to make room
  bool join_elsewhere(VehicleIndex vehicle, bool drives_on, double within_m);
  [[nodiscard]] bool is_free_entry(VehicleIndex vehicle, zone::TrackPosition position, bool drives_on);
  /// A vehicle stopped at X_MB would prevent `other` from joining the path.
  [[nodiscard]] bool blocks_entry(VehicleIndex other, const Pose2& X_MB) const;
  [[nodiscard]] std::vector<zone::TrackPosition> positions_near(VehicleIndex vehicle, double within_m) const;
  void end_join(VehicleIndex vehicle);

  // order_waits.cpp
  void record_waiting(Plan& plan, SimTime now);
  void wait_for(Plan& plan, VehicleIndex other, WaitReason why);
  [[nodiscard]] bool is_stopped(VehicleIndex vehicle) const;
  /// True once when a CoSiVA vehicle has been stopped with base ahead and no reason for so long that it needs a new
  /// order.
  bool is_stopped_without_reason(VehicleIndex vehicle);
  /// The vehicle at which its own obstacle sensor stops it; no_vehicle: no known vehicle.
  [[nodiscard]] VehicleIndex detected_in_path(VehicleIndex vehicle) const;
  [[nodiscard]] Pose2 body(VehicleIndex vehicle) const;

  // order_give_way.cpp
  /// Whether the body of `wait.whom` would still obstruct `wait.who` if it were stopped at `place`.
  [[nodiscard]] bool keeps_off(const Wait& wait, zone::TrackPosition position) const;
  /// By closing up to its leader the vehicle lets its follower out of a crossing that another vehicle waits for.
  [[nodiscard]] bool makes_room_by_moving_up(VehicleIndex vehicle, std::span<const Wait> waits) const;
  [[nodiscard]] bool has_what_to_give_back(VehicleIndex vehicle) const;
  [[nodiscard]] std::optional<double> distance_back_m(VehicleIndex vehicle, std::span<const Wait> waits) const;
  /// Whether the vehicle may back up this far: no vehicle is there, and none approaches.
  [[nodiscard]] bool is_free_behind(VehicleIndex vehicle, double back_m) const;
  [[nodiscard]] bool near_anything(VehicleIndex vehicle, const Pose2& X_MB, double clear_m) const;
  [[nodiscard]] std::vector<zone::SectionId> contested(VehicleIndex vehicle) const;
  /// True while the vehicle has to remain stopped.
  bool continue_yielding(VehicleIndex vehicle);
  void follow_back_up(VehicleIndex vehicle, Plan::Yielding& yielding);
  void end_yielding(VehicleIndex vehicle);

  Registry& registry_;
  Traffic& traffic_;
  MessagePublisher& publisher_;
  InstantActionSender& action_sender_;
  Missions& missions_;
  Simulator& simulator_;
  OrderRules rules_;
  const WaypointGraph* map_{};
  std::vector<Plan> plans_;
  std::vector<zone::SectionId> route_;  ///< of the vehicle being processed, after its extension's first section
  std::vector<const WaypointGraph::Stretch*> extension_;  ///< of the vehicle being processed
  std::vector<VehicleIndex> neighbour_;                   ///< vehicles whose bodies count, not their track positions
  SimDuration longest_wait_{};
  SimDuration lost_after_{};  ///< of this tick
  std::uint64_t orders_sent_{0};
  std::uint64_t updates_sent_{0};
  std::uint64_t resent_{0};
};

}  // namespace cosiva::virtual_side
