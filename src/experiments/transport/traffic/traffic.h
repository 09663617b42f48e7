#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/experiments/transport/traffic/dispatcher.h"
#include "cosiva/experiments/transport/traffic/metrics.h"
#include "cosiva/virtual/fleet/fleet.h"

namespace cosiva::experiments {

/// The energy that driving takes from a battery: for comparing runs, with rounded parameters of the article's small
/// vehicle.
/// W = P·t + (c·m·g·s + ½·m·Σ max(0, v₂² − v₁²)) / η, without recuperation.
struct DriveEnergy {
  double base_load_w{2.2};  ///< P: boards and radio
  double mass_kg{3.0};      ///< m
  double rolling{0.03};     ///< c
  double efficiency{0.5};   ///< η, of motors and gears
};

/// Options common to one zone and several.
struct TrafficTerms {
  double duration_s{3600.0};  ///< after the warm-up
  double warm_up_s{60.0};     ///< not included in the metrics
  std::uint64_t seed{1};
  SimDuration step{std::chrono::milliseconds{100}};
  std::shared_ptr<const aiv::AgentRules> rules;  ///< null: crisp
  std::string rules_name{"crisp"};
  double handling_s{10.0};
  DriveEnergy energy;
};

/// The number of steps in a time, to the nearest.
[[nodiscard]] std::uint64_t steps_in(double seconds, SimDuration step);

struct TrafficOptions : TrafficTerms {
  std::shared_ptr<const zone::TrafficZone> zone;
  std::size_t aivs{12};
  std::vector<Job> jobs;  ///< in the order of their times; none: all vehicles circulate
  // Of a zone in a site (experiments/transport/site):
  std::vector<zone::TrackPosition> exits;  ///< where vehicles leave the zone
  std::size_t spare{0};                    ///< capacity for vehicles in addition to its initial ones
  std::uint32_t first_aiv{0};              ///< number of its first vehicle among all zones'
};

/// A vehicle with a load in transfer from one zone to another.
struct Traveller {
  std::uint32_t aiv{};  ///< its number among all zones' vehicles
  Job job;              ///< its exit is the one through which it left
  std::uint64_t left_step{};
};

/// A fleet's traffic on a zone in virtual time, and its metrics.
///
/// Invariant: the vehicles that are away are vehicles of the fleet, each once.
class TrafficRun {
 public:
  /// Fails ("traffic.room") where the zone has too little room, ("traffic.options") on options out of range, and as
  /// Fleet::make does.
  [[nodiscard]] static Result<TrafficRun> make(TrafficOptions options);

  /// Advances by a time, at most to the end. False: the end is reached.
  bool advance(double seconds);
  bool advance(double seconds, Workers& workers);
  /// Advances by one step; advance() consists of such steps.
  void step(Workers& workers);
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// The vehicles that have left the zone in this step.
  [[nodiscard]] std::vector<Traveller> take_leaving();
  /// False: there is no room now, at that position or in the whole zone.
  [[nodiscard]] bool bring(const Traveller& traveller, zone::TrackPosition position);
  [[nodiscard]] double time_s() const;  ///< including the warm-up
  [[nodiscard]] double end_s() const { return options_.warm_up_s + options_.duration_s; }
  [[nodiscard]] const virtual_side::Fleet& fleet() const { return *fleet_; }
  [[nodiscard]] TrafficMetrics metrics() const;
  [[nodiscard]] const Dispatcher& dispatcher() const { return *dispatcher_; }

 private:
  TrafficRun(TrafficOptions options, std::unique_ptr<virtual_side::Fleet> fleet);
  void take_sample();
  void record_near_misses();
  void end_warm_up();

  /// Totals, so that the totals at the end of the warm-up can be subtracted.
  struct Totals {
    double distance_m{};
    double waiting_s{};
    double busy_s{};
    double present_s{};
    double gained_m2ps2{};
    std::vector<virtual_side::Fleet::CrossingMetrics> crossings;
  };
  [[nodiscard]] Totals totals() const;

  TrafficOptions options_;
  std::unique_ptr<virtual_side::Fleet> fleet_;
  std::unique_ptr<Dispatcher> dispatcher_;
  std::uint64_t steps_{0};
  std::uint64_t steps_per_sample_;
  std::uint64_t warm_up_steps_;
  std::uint64_t end_steps_;
  Totals before_;
  TrafficMetrics sampled_;  ///< metrics from samples
  struct {
    double count{};
    double stopped{};
    double open_jobs{};
  } curve_;                                         ///< sums since the last point
  std::vector<std::uint32_t> numbers_;              ///< number of the AIV of each vehicle
  std::vector<virtual_side::Fleet::Vehicle> away_;  ///< the last is added next
  double present_s_{0.0};
  std::vector<double> speed_mps_;  ///< in the previous step
  double gained_m2ps2_{0.0};       ///< of squared speed, over all vehicles
  std::vector<char> is_near_;      ///< by vehicle; empty until a vehicle was near
  std::uint64_t near_misses_{0};
  std::vector<std::uint32_t> laps_;
  std::vector<double> lap_began_s_;
};

}  // namespace cosiva::experiments
