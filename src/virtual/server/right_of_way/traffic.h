#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/right_of_way/convoys.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {

/// Why one vehicle waits for another.
enum class WaitReason : std::uint8_t {
  ahead,      ///< that one stands before it on its way, or where it needs room beyond a crossing
  crossing,   ///< that one holds a crossing, or stands in it
  turn,       ///< that one asked for a crossing before it, or goes before it by its priority
  off_path,  ///< its body, or its way onto the line, would be too near
  sensors,    ///< this one's own eyes make it stand before that one
};

/// Distances that keep vehicles apart; all between the vehicles' middles, beyond one vehicle's length.
struct TrafficRules {
  double gap_m{0.10};            ///< from the end of a base to the vehicle ahead
  double room_m{0.15};           ///< from a crossing's exit to the vehicle ahead
  double request_within_m{0.7};  ///< of the stop line: nearer than this, a crossing is asked for
  double look_ahead_m{6.0};      ///< for the vehicle ahead, unless a base is to reach further
  SimDuration overtaken_at_most{std::chrono::seconds{10}};  ///< one that has asked for so long is overtaken by nobody
  double lost_s_max{5.0};     ///< what one that asks loses at most, in all, by those who go before it out of their turn
  bool convoys{true};         ///< several of one way may pass a chain together, when it pays
  std::size_t convoy_max{3};  ///< so many in a row
};

/// Who may go where: the vehicle ahead, and the crossings (release is reservation).
///
/// What a vehicle holds follows from where it last said it was and from the base it was given: every crossing on the
/// way between. So nothing has to be given back by hand, a crossing lost in a restart is found again, and a vehicle
/// that stands in one holds it whatever happened. New crossings are granted in whole chains or not at all, so nobody
/// holds one while waiting for the next. Of those that ask, the higher priority goes first, and among equals who asked
/// first; but a request that has waited `overtaken_at_most` is overtaken by nobody, so nobody starves either.
///
/// A vehicle may be put between another and the crossing that the other holds already (virtual AIVs are). The other can
/// only follow it, so it goes first: what somebody behind it on the same way holds or asks for keeps nobody back.
///
/// Convoys: the one directly behind the last that was given a chain, at most `request_within_m` before its stop line,
/// may pass it together with that one, without its being given back between them. There must be room for it beyond
/// whatever those ahead do: each of them may come to stand for good at the end of the base that it has, or behind the
/// one ahead. And it must pay: the seconds that all those together lose who ask for the chain must be fewer than the
/// seconds that it would lose by waiting for them, times the members of the convoy still to come (it and those directly
/// behind it). At most `convoy_max` go in a row, never before a higher priority, and never before a request that has
/// waited `overtaken_at_most` or would lose more than `lost_s_max` in all.
///
/// With convoys, one that has to wait for a third one anyway also lets others by who will be gone by then, or cost it
/// no more than what is left of its `lost_s_max`. Without that, opposite ways that have come out of step pass one after
/// the other for ever, where they could pass together.
///
/// Each vehicle looks along its own course; without one, along default successors. Of two that took different branches
/// neither is ahead of the other once their bodies have parted.
///
/// Invariant: each crossing has at most one holder, which is one of the vehicles.
class Traffic {
 public:
  explicit Traffic(TrafficRules rules = {}) : rules_{rules} {}

  [[nodiscard]] const TrafficRules& rules() const { return rules_; }
  void set_map(const WaypointGraph* map);  ///< forgets every place, course, hold and request
  void resize(std::size_t vehicles);

  /// The last reported place; nothing: it is not on the way of others.
  void set_position(VehicleIndex vehicle, std::optional<zone::TrackPosition> position);
  void set_priority(VehicleIndex vehicle, std::int32_t priority) { vehicles_[vehicle].priority = priority; }
  void set_time(SimTime now) { now_ = now; }
  /// It has been taken away.
  void forget(VehicleIndex vehicle);
  /// The end of the base it was given, whether it has said so or not; no_waypoint: none.
  void set_base_end(VehicleIndex vehicle, WaypointIndex end);
  /// It says that it has driven its base to the end; until the next base.
  void set_base_passed(VehicleIndex vehicle, bool passed);
  [[nodiscard]] WaypointIndex base_end(VehicleIndex vehicle) const { return vehicles_[vehicle].base_end; }
  [[nodiscard]] const std::optional<zone::TrackPosition>& track_position(VehicleIndex vehicle) const {
    return vehicles_[vehicle].position;
  }

  void set_course(VehicleIndex vehicle, zone::Course course);
  void extend_course(VehicleIndex vehicle, Sections more);
  /// Keeps the next `keep` sections of what is to come.
  void cut_course(VehicleIndex vehicle, std::size_t keep);
  /// It is there, whether in the way of others or not.
  void follow(VehicleIndex vehicle, zone::TrackPosition position);
  [[nodiscard]] const zone::Course& course(VehicleIndex vehicle) const { return vehicles_[vehicle].course; }
  [[nodiscard]] bool on_course(VehicleIndex vehicle) const { return vehicles_[vehicle].on_course; }
  /// After the section it is on; empty when it is off its course, or has none.
  [[nodiscard]] Sections remaining(VehicleIndex vehicle) const {
    return vehicles_[vehicle].on_course ? vehicles_[vehicle].course.remaining() : Sections{};
  }
  [[nodiscard]] Sections traversed(VehicleIndex vehicle) const {
    return vehicles_[vehicle].on_course ? vehicles_[vehicle].course.traversed() : Sections{};
  }
  /// From `place` along its course to the end of its base; nothing: it has none, or that is not where its way leads.
  [[nodiscard]] std::optional<double> base_left_m(VehicleIndex vehicle, zone::TrackPosition position) const;
  /// What its course holds beyond the end of its base.
  struct Beyond {
    std::size_t keep;                       ///< sections of coming() up to the one that the base ends on
    std::vector<zone::SectionId> sections;  ///< after that one
  };
  [[nodiscard]] Beyond beyond_base(VehicleIndex vehicle, zone::TrackPosition position) const;
  [[nodiscard]] bool base_passed(VehicleIndex vehicle) const { return vehicles_[vehicle].base_passed; }
  [[nodiscard]] double base_m_max(VehicleIndex vehicle) const { return vehicles_[vehicle].base_m_max; }

  /// Works out vehicles ahead and holds from places, courses and bases; call after changes and before asking.
  void update();

  struct Leader {
    VehicleIndex vehicle{no_vehicle};
    double distance_m{std::numeric_limits<double>::infinity()};
  };
  [[nodiscard]] const Leader& ahead(VehicleIndex vehicle) const { return vehicles_[vehicle].ahead; }
  /// Looks as far as `limit_m`, be it further than usual.
  [[nodiscard]] Leader ahead_within(VehicleIndex vehicle, double limit_m) const;
  /// How far the end of a base may reach from the vehicle's last reported place, where it is to reach `wanted_m`.
  [[nodiscard]] double reach_m(VehicleIndex vehicle, double wanted_m = 0.0) const;
  [[nodiscard]] bool holds_all(VehicleIndex vehicle, double distance_m);

  struct Response {
    bool granted{false};
    CrossingIndex waits_for{0};           ///< the first that is not free, when a crossing is what it waits for
    VehicleIndex blocked_by{no_vehicle};  ///< who holds it, stands in the way beyond, or asked earlier
    WaitReason why{WaitReason::crossing};
  };
  /// Asks for all crossings up to the exit of a chain, `exit_m` ahead of the vehicle's place; its stop line is `stop_m`
  /// ahead. The first asking fixes its turn. Of those that stand in one crossing together its holder may leave it:
  /// whether body passes body is for who asks to see.
  Response request(VehicleIndex vehicle, double exit_m, double stop_m = 0.0);
  /// Whether it may pass that chain in convoy with the one ahead, whatever the turns. Its base then reaches beyond that
  /// one's place: its own eyes keep it apart.
  [[nodiscard]] bool may_join(VehicleIndex vehicle, double exit_m, double stop_m);
  struct Convoy {
    std::size_t size;  ///< with who joined last
    std::vector<CrossingIndex> crossings;
  };
  /// It joins it (it may: checked). A base has to follow.
  Convoy join(VehicleIndex vehicle);
  void withdraw(VehicleIndex vehicle);
  [[nodiscard]] bool requests(VehicleIndex vehicle, CrossingIndex crossing) const;
  /// It stands, without a base, in a crossing that somebody else holds, as may be after a switch of zones.
  [[nodiscard]] bool is_in_others_crossing(VehicleIndex vehicle) const;

  [[nodiscard]] VehicleIndex holder(CrossingIndex crossing) const { return holders_[crossing]; }
  /// Who waits for a crossing, in the order in which they will be served.
  [[nodiscard]] std::vector<VehicleIndex> waiting(CrossingIndex crossing) const;
  /// How often somebody joined one.
  [[nodiscard]] std::uint64_t convoys() const { return convoys_.count(); }
  [[nodiscard]] double stopped_m() const;  ///< a vehicle's length and the gap

  struct Request {
    VehicleIndex vehicle;
    std::vector<CrossingIndex> crossings;
    SimTime since{};
    bool has_room{false};
    double stop_m{0.0};
    double exit_m{0.0};
    double lost_s{0.0};  ///< by those who were let by, as guessed when they were
  };
  /// The open requests for crossings, oldest first.
  [[nodiscard]] const std::vector<Request>& requests() const { return queue_; }
  [[nodiscard]] bool has_waited(const Request& request) const {
    return now_ - request.since >= rules_.overtaken_at_most;
  }
  /// From a vehicle's report over its order to its wheels.
  static constexpr double latency_s = 0.3;
  /// Of one that asks: to its stop line, which is `stop_m` ahead, and so far, at the medium speed.
  [[nodiscard]] double run_s(double stop_m, double length_m) const;
  [[nodiscard]] const WaypointGraph& map() const { return *map_; }
  [[nodiscard]] VehicleIndex vehicle_count() const { return static_cast<VehicleIndex>(vehicles_.size()); }
  [[nodiscard]] std::int32_t priority(VehicleIndex vehicle) const { return vehicles_[vehicle].priority; }
  /// The crossings up to the end of its base.
  [[nodiscard]] const std::vector<CrossingIndex>& needs(VehicleIndex vehicle) const { return vehicles_[vehicle].needs; }

  void fold(Digest& digest) const;

 private:
  struct Vehicle {
    std::optional<zone::TrackPosition> position;
    zone::Course course;
    bool on_course{false};
    WaypointIndex base_end{no_waypoint};
    bool base_passed{false};
    double base_m_max{};  ///< how long the base can be at most; one that seems longer has been driven to its end
    Leader ahead;
    std::vector<CrossingIndex> needs;
    std::int32_t priority{0};
  };
  [[nodiscard]] bool goes_before(const Request& a, const Request& b) const;
  /// Of `other`, whose turn is before and who waits for a third one: so long it waits for `mine` beyond that. Nothing:
  /// it waits for no third one.
  [[nodiscard]] std::optional<double> loses_s(const Request& other, const Request& mine) const;
  [[nodiscard]] bool lets_by(const Request& other, const Request& mine) const;
  [[nodiscard]] bool only_follows(VehicleIndex other, VehicleIndex self, const std::vector<CrossingIndex>& crossings);
  void sort_by_position();
  void search_on(zone::SectionId section, double start_m, double from_s_m, double to_s_m, VehicleIndex self,
                 Leader& nearest) const;
  void update_holds();
  void measure_base(VehicleIndex vehicle);
  void check_again(VehicleIndex vehicle);

  TrafficRules rules_;
  const WaypointGraph* map_{};
  std::vector<Vehicle> vehicles_;
  std::vector<std::pair<zone::SectionId, VehicleIndex>> by_section_;  ///< those with a place, sorted
  std::vector<VehicleIndex> holders_;                                 ///< by crossing
  std::vector<Request> queue_;                                        ///< oldest first
  Convoys convoys_;
  std::vector<CrossingIndex> scratch_;
  std::vector<CrossingIndex> between_;
  SimTime now_{};
  bool positions_dirty_{true};
  bool holds_dirty_{true};
};

}  // namespace cosiva::virtual_side
