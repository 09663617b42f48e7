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
  double base_ahead_m{1.2};  ///< as much may be driven blind when the link breaks
  std::size_t horizon{4};    ///< nodes shown beyond the base
  std::size_t base_nodes_max{16};
  double deviation_m{0.10};   ///< allowedDeviationXY of every node but the first of a new order
  double arrived_m{0.06};     ///< one that stands nearer than this to its goal has arrived; past it, `deviation_m`
  double on_circuit_m{0.30};  ///< a vehicle further off is not given orders
  double on_path_m{0.20};     ///< a vehicle nearer than this to the circuit stands in the way of others
  SimDuration resend_after{std::chrono::milliseconds{300}};
  SimDuration update_period{std::chrono::milliseconds{200}};
  SimDuration after_refusal{std::chrono::seconds{2}};
  SimDuration let_in_for{std::chrono::seconds{5}};  ///< one that waits beside the line
  SimDuration other_position_after{std::chrono::seconds{1}};
  SimDuration make_room_after{std::chrono::seconds{4}};  ///< it goes onto the line where it cannot drive on, either
  SimDuration join_timeout{std::chrono::seconds{15}};
  SimDuration cancel_again{std::chrono::seconds{5}};
  SimDuration unresponsive_for{std::chrono::seconds{12}};  ///< one of ours with way before it and no reason to stand
  SimDuration yield_time_max{std::chrono::seconds{12}};    ///< at most
  double others_left_m{0.5};                               ///< it goes on when those it gave way to have come so far
  double back_up_m_max{0.5};
};

/// How a vehicle lets others out of a deadlock, the cheapest first.
enum class Means : std::uint8_t {
  move_up,         ///< comes as near to the one ahead as its eyes let it, so that the one behind it leaves a crossing
  wait,            ///< gives back what it asked for and holds ahead, and lets the others go first
  detour,          ///< goes another way
  other_position,  ///< comes onto the line elsewhere
  back_up,         ///< drives backwards along the line, and lets the others go first
};

/// Rolls orders along each vehicle's mission: an idle vehicle gets a new order, whose base is then pushed forward by
/// updates stitched at the last base node, as far as traffic allows. One update is on its way at a time, and is sent
/// again, with the same content under a new header, until the vehicle's state acknowledges it. order_way.cpp finds the
/// way, order_roller.cpp keeps the orders, order_join.cpp brings off-path vehicles onto the path, order_waits.cpp
/// finds which vehicle waits for which, order_give_way.cpp resolves deadlocks.
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

  void set_map(const WaypointGraph* map);  ///< takes back what was ordered on the old zone
  void resize(std::size_t vehicles) { plans_.resize(vehicles); }

  /// After the proxy took the state in. `before` is the state before it, if any.
  void on_state(VehicleIndex vehicle, const wire::State* before);
  /// An operator cancelled: no more updates of the order at hand.
  void stop_rolling(VehicleIndex vehicle);
  /// It has been taken away.
  void forget(VehicleIndex vehicle) { plans_[vehicle] = {}; }
  /// @param drive     give orders at all; otherwise only what is on its way is followed
  /// @param send_off  give orders to those that have none
  void tick(bool drive, bool send_off, SimDuration lost_after);

  /// Is this vehicle's last reported place good enough to drive from; set by the server at each report.
  struct ReportedPose {
    std::optional<zone::TrackPosition> position;  ///< nearest on the circuit
    double off_m{};
    double heading_off_rad{};
    Pose2 X_MB{};
  };
  void set_reported_pose(VehicleIndex vehicle, const ReportedPose& reported);

  /// What it was ordered to do is seen: it has an order, on the zone that is there now.
  [[nodiscard]] bool has_order(VehicleIndex vehicle) const { return plans_[vehicle].stage == Plan::Stage::running; }
  /// Where it stands beside the line and goes onto it; nothing: it is on the line, or has not been sent there.
  [[nodiscard]] const std::optional<zone::TrackPosition>& entry_point(VehicleIndex vehicle) const {
    return plans_[vehicle].entry_point;
  }
  /// Of those that stand off the line: the mission's goal is where somebody else stands.
  [[nodiscard]] std::string blocker_at_goal(VehicleIndex vehicle) const;

  /// Why it does not go on: a crossing or a vehicle; empty when nothing holds it.
  [[nodiscard]] std::string waits_for(VehicleIndex vehicle) const;
  /// How long it has waited for that, and the longest so far.
  [[nodiscard]] SimDuration longest_wait() const { return longest_wait_; }
  /// Who cannot go on before whom, as of this tick; only of those that stand.
  void add_waits(WaitGraph& graph) const;
  [[nodiscard]] bool is_off_path(VehicleIndex vehicle) const { return goes_onto_line(vehicle); }
  /// "CoSiVA/AIV1 waits for X3, where CoSiVA/AIV2 is".
  [[nodiscard]] std::string sentence(const Wait& wait) const;

  /// What it costs to give way so that `waits`, which are all for this vehicle, come to an end: metres that it backs
  /// up, 0 for all other means. Nothing: it cannot.
  [[nodiscard]] std::optional<double> can_yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits);
  /// False: it came to nothing after all.
  bool yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits);
  /// The deadlock is over: what it was to keep out of it may take again.
  void need_not_avoid(VehicleIndex vehicle) { missions_.need_not_avoid(vehicle); }
  /// It stands still for others, or is on its way back for them.
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
    bool has_horizon{false};  ///< the last order sent announces more than its base
    std::uint32_t base_end_sequence{0};
    MessagePublisher::SentOrder sent;  ///< the last order of ours
    SimTime sent_at{};
    SimTime wait_until{};
    SimTime cancelled_at{};
    ReportedPose reported;
    std::string strange_order;  ///< an order of somebody else's, noted once
    std::optional<CrossingIndex> waits_for_crossing;
    VehicleIndex waits_for_vehicle{no_vehicle};
    WaitReason waits_why{WaitReason::ahead};
    std::optional<SimTime> waits_since;
    std::optional<SimTime> unresponsive_since;           ///< it stands with base before it, and says no reason
    InstantActionSender::ActionHandle cancel_handle{0};  ///< of the cancelOrder on its way; 0: none
    std::uint64_t route_of{0};                ///< the missions' revision that its course was planned for; 0: none
    std::optional<zone::SectionId> no_route;  ///< there is none from here
    std::optional<zone::TrackPosition> entry_point;    ///< where it comes onto the line
    InstantActionSender::ActionHandle join_handle{0};  ///< of the joinLine on its way; 0: none
    SimTime join_sent_at{};
    struct Yielding {
      SimTime until{};
      std::vector<std::pair<VehicleIndex, Point2>> others;  ///< for whom, and where they stood
      bool drops_order{false};
      double back_m{0.0};                           ///< 0: it does not back up
      InstantActionSender::ActionHandle handle{0};  ///< of its backUp; 0: not sent yet
      double clear_m{0.0};                          ///< it stops when anything comes nearer
      bool stopped{false};                          ///< on its way back, as somebody came
    };
    std::optional<Yielding> yielding;
    bool moves_up{false};  ///< the next stretch may end nearer to the one ahead than the gap
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
  /// Of a chain: from the end of its base on, as far as the next waypoint and the exit.
  struct ChainAhead {
    double stop_m;
    double next_m;
    double exit_m;
  };
  /// Its base may reach up to that one: its eyes will keep it off.
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
  /// It has come to the end of its mission's way, and rolled on.
  [[nodiscard]] bool past_goal(VehicleIndex vehicle) const;
  /// It has no order and needs none: it is where it was to go, or about to come to stand there.
  [[nodiscard]] bool stays_at_goal(VehicleIndex vehicle);
  bool regain_course(VehicleIndex vehicle);
  void take_course(VehicleIndex vehicle, zone::Course course);
  [[nodiscard]] const WaypointGraph::Stretch* next_stretch(VehicleIndex vehicle, WaypointIndex at, std::size_t passed);
  [[nodiscard]] bool off_path(VehicleIndex vehicle) const;
  [[nodiscard]] bool goes_onto_line(VehicleIndex vehicle) const;
  [[nodiscard]] VehicleIndex obstructs_line_entry(VehicleIndex vehicle, zone::TrackPosition entry_point) const;
  /// Who stands beside the line, or is on its way to it, so that this one cannot drive on from `from_m` to `to_m`
  /// ahead.
  [[nodiscard]] VehicleIndex off_path_obstruction(VehicleIndex vehicle, double from_m, double to_m) const;
  /// Of one beside it: where it is to come onto it, or would if it were let in.
  [[nodiscard]] std::optional<zone::TrackPosition> comes_onto_line_at(VehicleIndex vehicle) const;
  void follow_line(VehicleIndex vehicle);
  void keep_off_path(VehicleIndex vehicle);

  // order_join.cpp
  /// Where it is sent onto the line it goes there with a joinLine, which is not over yet.
  [[nodiscard]] bool joining(VehicleIndex vehicle);
  /// Where the nearest place is not free, another may be: sends it there.
  void try_other_positions(VehicleIndex vehicle);
  /// @param drives_on  only places from which it can drive on; otherwise to make room
  bool join_elsewhere(VehicleIndex vehicle, bool drives_on, double within_m);
  [[nodiscard]] bool is_free_entry(VehicleIndex vehicle, zone::TrackPosition position, bool drives_on);
  /// One that stood at X_MB would keep the other off the line.
  [[nodiscard]] bool blocks_entry(VehicleIndex other, const Pose2& X_MB) const;
  [[nodiscard]] std::vector<zone::TrackPosition> positions_near(VehicleIndex vehicle, double within_m) const;
  void end_join(VehicleIndex vehicle);

  // order_waits.cpp
  void record_waiting(Plan& plan, SimTime now);
  void wait_for(Plan& plan, VehicleIndex other, WaitReason why);
  [[nodiscard]] bool is_stopped(VehicleIndex vehicle) const;
  /// True once when one of ours has stood for so long with base before it and no reason that it needs a new order.
  bool is_stopped_without_reason(VehicleIndex vehicle);
  /// Before whom its own eyes make it stand; no_vehicle: before nobody known.
  [[nodiscard]] VehicleIndex detected_in_path(VehicleIndex vehicle) const;
  [[nodiscard]] Pose2 body(VehicleIndex vehicle) const;

  // order_give_way.cpp
  /// Whether the body of who is waited for would still be in the way if it stood at `place`.
  [[nodiscard]] bool keeps_off(const Wait& wait, zone::TrackPosition position) const;
  /// By coming up to the one ahead it lets the one behind it out of a crossing that somebody waits for.
  [[nodiscard]] bool makes_room_by_moving_up(VehicleIndex vehicle, std::span<const Wait> waits) const;
  [[nodiscard]] bool has_what_to_give_back(VehicleIndex vehicle) const;
  [[nodiscard]] std::optional<double> distance_back_m(VehicleIndex vehicle, std::span<const Wait> waits) const;
  /// Whether it may roll back so far: nobody stands there, and nobody comes there.
  [[nodiscard]] bool is_free_behind(VehicleIndex vehicle, double back_m) const;
  [[nodiscard]] bool near_anything(VehicleIndex vehicle, const Pose2& X_MB, double clear_m) const;
  [[nodiscard]] std::vector<zone::SectionId> contested(VehicleIndex vehicle) const;
  /// True while it is to keep still.
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
  std::vector<zone::SectionId> route_;  ///< of the vehicle at hand, after its extension's first section
  std::vector<const WaypointGraph::Stretch*> extension_;  ///< of the vehicle at hand
  std::vector<VehicleIndex> neighbour_;                   ///< whose bodies count, not their places
  SimDuration longest_wait_{};
  SimDuration lost_after_{};  ///< of this tick
  std::uint64_t orders_sent_{0};
  std::uint64_t updates_sent_{0};
  std::uint64_t resent_{0};
};

}  // namespace cosiva::virtual_side
