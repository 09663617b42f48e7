#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/right_of_way/convoys.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {

/// Why one vehicle waits for another.
enum class WaitReason : std::uint8_t {
  ahead,     ///< the other vehicle is ahead on its path, or where it needs room beyond a crossing
  crossing,  ///< the other vehicle holds a crossing, or is in it
  turn,      ///< the other vehicle requested a crossing earlier, or has the higher priority
  off_path,  ///< the other vehicle's body, or its path onto the circuit, would be too close
  sensors,   ///< the vehicle's own obstacle sensor stops it in front of the other
  plan,      ///< by the plan of the fleet, the other vehicle passes first
};

/// Distances that keep vehicles apart; all are between the vehicles' body origins, in addition to one vehicle length.
struct TrafficRules {
  double gap_m{0.10};            ///< from the end of a base to the vehicle ahead
  double room_m{0.15};           ///< from a crossing's exit to the vehicle ahead
  double request_within_m{0.7};  ///< distance to the stop line from which on a crossing is requested
  double look_ahead_m{6.0};      ///< for the leader, unless a base is to reach further
  SimDuration overtaken_at_most{std::chrono::seconds{10}};  ///< an older request is not overtaken
  double lost_s_max{5.0};     ///< maximum total time that a request loses to vehicles that go before it out of turn
  bool convoys{true};         ///< several vehicles of one direction may pass a chain together when this saves time
  std::size_t convoy_max{3};  ///< maximum number in a row
  bool negotiated{false};     ///< vehicles agree on crossings among themselves; a chain needs only room beyond it
};

/// Decides which vehicle may drive where: the leader of each vehicle, and the crossings (release is reservation).
///
/// The crossings that a vehicle holds follow from its last reported position and from the base it was given: every
/// crossing on the path between. Therefore no crossing has to be released explicitly, holds are found again after a
/// restart, and a vehicle that is stopped in a crossing always holds it. New crossings are granted in whole chains or
/// not at all, so no vehicle holds one crossing while waiting for the next. Of several requests, the one of the vehicle
/// with the higher priority goes first, and among equal priorities the earlier request; but a request that has waited
/// `overtaken_at_most` is not overtaken, so no vehicle starves.
///
/// A vehicle may be placed between another vehicle and the crossing that the other already holds (virtual AIVs are).
/// The other can only follow, so the placed vehicle goes first: crossings that are held or requested by a vehicle
/// behind it on the same path do not block it.
///
/// Convoys: the vehicle directly behind the last one that was granted a chain, at most `request_within_m` before its
/// stop line, may pass the chain together with its leader, without a release of the chain between them. There must be
/// room for the vehicle beyond the chain, whatever the vehicles ahead do: each of them may finally stop at the end of
/// its present base, or behind its leader. In addition, the convoy must save time: the total time that all vehicles
/// requesting the chain lose must be less than the time that the joining vehicle would lose by waiting for them,
/// multiplied by the number of convoy members still to come (that vehicle and those directly behind it). At most
/// `convoy_max` vehicles go in a row, never before a higher priority, and never before a request that has waited
/// `overtaken_at_most` or would lose more than `lost_s_max` in total.
///
/// With convoys, a vehicle that has to wait for a third vehicle also lets other vehicles pass that will have left by
/// then, or that cost it no more than the remainder of its `lost_s_max`. Without this rule, vehicles of opposite
/// directions that are out of step would pass one after the other permanently, where they could pass together.
///
/// Where vehicles agree on crossings among themselves (`negotiated`), a request is granted when there is room beyond
/// the chain: bases of several vehicles lead through one crossing, and holds only show where bases lead.
///
/// The leader of a vehicle is searched for along its own course; without a course, along default successors. Of two
/// vehicles that took different branches neither is ahead of the other once their bodies are clear of each other.
///
/// Invariant: each crossing has at most one holder, and the holder is one of the vehicles.
class Traffic {
 public:
  explicit Traffic(TrafficRules rules = {}) : rules_{rules} {}

  [[nodiscard]] const TrafficRules& rules() const { return rules_; }
  void set_map(const WaypointGraph* map);  ///< discards all positions, courses, holds and requests
  void resize(std::size_t vehicles);

  /// The last reported track position; nothing: the vehicle is not on the path of others.
  void set_position(VehicleIndex vehicle, std::optional<zone::TrackPosition> position);
  void set_priority(VehicleIndex vehicle, std::int32_t priority) { vehicles_[vehicle].priority = priority; }
  void set_time(SimTime now) { now_ = now; }
  /// The vehicle has been removed.
  void forget(VehicleIndex vehicle);
  /// The end of the base that was sent to the vehicle, whether or not the vehicle has reported the base; no_waypoint:
  /// none.
  void set_base_end(VehicleIndex vehicle, WaypointIndex end);
  /// The crossings that a vehicle holds in addition, because its base from before a restart of the server, which is not
  /// known, may lead through them; until the next call.
  void reserve(VehicleIndex vehicle, std::vector<CrossingIndex> crossings);
  /// The vehicle reports that it has reached the end of its base; valid until the next base.
  void set_base_passed(VehicleIndex vehicle, bool passed);
  [[nodiscard]] WaypointIndex base_end(VehicleIndex vehicle) const { return vehicles_[vehicle].base_end; }
  [[nodiscard]] const std::optional<zone::TrackPosition>& track_position(VehicleIndex vehicle) const {
    return vehicles_[vehicle].position;
  }

  void set_course(VehicleIndex vehicle, zone::Course course);
  void extend_course(VehicleIndex vehicle, Sections more);
  /// Retains the next `keep` sections of coming().
  void cut_course(VehicleIndex vehicle, std::size_t keep);
  /// The vehicle's track position, whether or not the vehicle is on the path of others.
  void follow(VehicleIndex vehicle, zone::TrackPosition position);
  [[nodiscard]] const zone::Course& course(VehicleIndex vehicle) const { return vehicles_[vehicle].course; }
  [[nodiscard]] bool on_course(VehicleIndex vehicle) const { return vehicles_[vehicle].on_course; }
  /// The sections of the course after the present one; empty when the vehicle is off its course or has none.
  [[nodiscard]] Sections remaining(VehicleIndex vehicle) const {
    return vehicles_[vehicle].on_course ? vehicles_[vehicle].course.remaining() : Sections{};
  }
  [[nodiscard]] Sections traversed(VehicleIndex vehicle) const {
    return vehicles_[vehicle].on_course ? vehicles_[vehicle].course.traversed() : Sections{};
  }
  /// From `place` along the vehicle's course to the end of its base; nothing: the vehicle has no base, or its course
  /// does not lead to that end.
  [[nodiscard]] std::optional<double> base_left_m(VehicleIndex vehicle, zone::TrackPosition position) const;
  [[nodiscard]] bool base_passed(VehicleIndex vehicle) const { return vehicles_[vehicle].base_passed; }
  [[nodiscard]] double base_m_max(VehicleIndex vehicle) const { return vehicles_[vehicle].base_m_max; }

  /// Computes leaders and holds from positions, courses and bases; to be called after changes and before queries.
  void update();

  struct Leader {
    VehicleIndex vehicle{no_vehicle};
    double distance_m{std::numeric_limits<double>::infinity()};
  };
  [[nodiscard]] const Leader& ahead(VehicleIndex vehicle) const { return vehicles_[vehicle].ahead; }
  /// Searches as far as `limit_m`, even when this is further than usual.
  [[nodiscard]] Leader ahead_within(VehicleIndex vehicle, double limit_m) const;
  /// How far the end of a base may be from the vehicle's last reported position, when `wanted_m` is wanted.
  [[nodiscard]] double reach_m(VehicleIndex vehicle, double wanted_m = 0.0) const;
  [[nodiscard]] bool holds_all(VehicleIndex vehicle, double distance_m);

  struct Response {
    bool granted{false};
    CrossingIndex waits_for{0};  ///< the first crossing that is not free, when the vehicle waits for a crossing
    VehicleIndex blocked_by{no_vehicle};  ///< holds it, obstructs the path beyond, or requested earlier
    WaitReason why{WaitReason::crossing};
  };
  /// Requests all crossings up to the exit of a chain, `exit_m` ahead of the vehicle's position; the chain's stop line
  /// is `stop_m` ahead. The first request determines the vehicle's turn. Of several vehicles in one crossing its holder
  /// may leave it: the caller has to check that the bodies pass each other.
  Response request(VehicleIndex vehicle, double exit_m, double stop_m = 0.0);
  /// Whether the vehicle may pass that chain in convoy with its leader, regardless of the order of requests. Its base
  /// then reaches beyond its leader's position: its own obstacle sensor keeps the distance.
  [[nodiscard]] bool may_join(VehicleIndex vehicle, double exit_m, double stop_m);
  struct Convoy {
    std::size_t size;  ///< including the vehicle that joined last
    std::vector<CrossingIndex> crossings;
  };
  /// The vehicle joins the convoy (may_join() holds: checked). A base has to follow.
  Convoy join(VehicleIndex vehicle);
  void withdraw(VehicleIndex vehicle);

  [[nodiscard]] VehicleIndex holder(CrossingIndex crossing) const { return holders_[crossing]; }
  /// Number of times that a crossing got a holder.
  [[nodiscard]] std::uint64_t holds() const { return holds_; }
  /// The vehicles that wait for a crossing, in the order in which they will be served.
  [[nodiscard]] std::vector<VehicleIndex> waiting(CrossingIndex crossing) const;
  /// Number of times that a vehicle joined a convoy.
  [[nodiscard]] std::uint64_t convoys() const { return convoys_.count(); }
  [[nodiscard]] double stopped_m() const;  ///< a vehicle's length and the gap

  struct Request {
    VehicleIndex vehicle;
    std::vector<CrossingIndex> crossings;
    SimTime since{};
    bool has_room{false};
    double stop_m{0.0};
    double exit_m{0.0};
    double lost_s{0.0};  ///< to vehicles that were let pass, as estimated at that time
  };
  /// The open requests for crossings, oldest first.
  [[nodiscard]] const std::vector<Request>& requests() const { return queue_; }
  [[nodiscard]] bool has_waited(const Request& request) const {
    return now_ - request.since >= rules_.overtaken_at_most;
  }
  /// From a vehicle's report through its order to its wheels.
  static constexpr double latency_s = 0.3;
  /// The time for `length_m` at the medium speed, plus the acceleration time of a vehicle that is stopped at its stop
  /// line, `stop_m` ahead.
  [[nodiscard]] double run_s(double stop_m, double length_m) const;
  [[nodiscard]] const WaypointGraph& map() const { return *map_; }
  [[nodiscard]] VehicleIndex vehicle_count() const { return static_cast<VehicleIndex>(vehicles_.size()); }
  [[nodiscard]] std::int32_t priority(VehicleIndex vehicle) const { return vehicles_[vehicle].priority; }
  /// The crossings up to the end of the vehicle's base.
  [[nodiscard]] const std::vector<CrossingIndex>& needs(VehicleIndex vehicle) const { return vehicles_[vehicle].needs; }

  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Vehicle {
    std::optional<zone::TrackPosition> position;
    zone::Course course;
    bool on_course{false};
    WaypointIndex base_end{no_waypoint};
    bool base_passed{false};
    double base_m_max{};  ///< maximum length of the base; a base that seems longer has been driven to its end
    Leader ahead;
    std::vector<CrossingIndex> needs;
    std::vector<CrossingIndex> reserved;  ///< part of `needs`
    std::int32_t priority{0};
  };
  /// What base_left_m() found at this position last.
  struct BaseLeft {
    zone::TrackPosition position;
    std::optional<double> left_m;
    bool needs_known{false};  ///< Vehicle::needs are those of this base
  };
  [[nodiscard]] bool goes_before(const Request& a, const Request& b) const;
  /// The time that `other`, whose turn is earlier and which waits for a third vehicle, would wait for `mine` in
  /// addition. Nothing: `other` waits for no third vehicle.
  [[nodiscard]] std::optional<double> loses_s(const Request& other, const Request& mine) const;
  [[nodiscard]] bool lets_by(const Request& other, const Request& mine) const;
  [[nodiscard]] bool only_follows(VehicleIndex other, VehicleIndex self, const std::vector<CrossingIndex>& crossings);
  void sort_by_position();
  void search_on(zone::SectionId section, double start_m, double from_s_m, double to_s_m, VehicleIndex self,
                 Leader& nearest) const;
  void update_holds();
  void hold(CrossingIndex crossing, VehicleIndex vehicle);
  void measure_base(VehicleIndex vehicle);
  void check_again(VehicleIndex vehicle);

  TrafficRules rules_;
  const WaypointGraph* map_{};
  std::vector<Vehicle> vehicles_;
  /// By vehicle, needed several times in each cycle; nothing where the vehicle's course or base has changed since.
  mutable std::vector<std::optional<BaseLeft>> base_left_;
  std::vector<std::pair<zone::SectionId, VehicleIndex>> by_section_;  ///< the vehicles with a position, sorted
  std::vector<VehicleIndex> holders_;                                 ///< by crossing
  std::uint64_t holds_{0};
  std::vector<Request> queue_;  ///< oldest first
  Convoys convoys_;
  std::vector<CrossingIndex> scratch_;
  std::vector<CrossingIndex> between_;
  SimTime now_{};
  bool positions_dirty_{true};
  bool holds_dirty_{true};
};

/// The vehicle is stopped, without a base, in a crossing that another vehicle holds; possible after a switch of zones.
[[nodiscard]] bool is_in_others_crossing(const Traffic& traffic, VehicleIndex vehicle);
[[nodiscard]] bool requests(const Traffic& traffic, VehicleIndex vehicle, CrossingIndex crossing);

/// The part of a vehicle's course beyond the end of its base.
struct BeyondBase {
  std::size_t keep;                       ///< sections of coming() up to the one that the base ends on
  std::vector<zone::SectionId> sections;  ///< after that section
};
[[nodiscard]] BeyondBase beyond_base(const Traffic& traffic, VehicleIndex vehicle, zone::TrackPosition position);
/// BeyondBase::keep alone.
[[nodiscard]] std::size_t sections_of_base(const Traffic& traffic, VehicleIndex vehicle, zone::TrackPosition position);
/// BeyondBase::sections alone, in a list whose memory is used again.
void list_beyond_base(const Traffic& traffic, VehicleIndex vehicle, zone::TrackPosition position,
                      std::vector<zone::SectionId>& sections);

}  // namespace cosiva::virtual_side
