#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/experiments/transport/traffic/dispatcher.h"
#include "cosiva/experiments/transport/traffic/metrics.h"
#include "cosiva/virtual/fleet/fleet.h"

namespace cosiva::experiments {

/// What driving takes from a battery: for comparing runs, by round figures of the article's small vehicle.
/// W = P·t + (c·m·g·s + ½·m·Σ max(0, v₂² − v₁²)) / η, nothing won back by braking.
struct DriveEnergy {
  double base_load_w{2.2};  ///< P: boards and radio
  double mass_kg{3.0};      ///< m
  double rolling{0.03};     ///< c
  double efficiency{0.5};   ///< η, of motors and gears
};

/// What is the same for one zone and for many.
struct TrafficTerms {
  double duration_s{3600.0};  ///< after the warm-up
  double warm_up_s{60.0};     ///< counts in no figure
  std::uint64_t seed{1};
  SimDuration step{std::chrono::milliseconds{100}};
  std::shared_ptr<const aiv::AgentRules> rules;  ///< null: crisp
  std::string rules_name{"crisp"};
  double handling_s{10.0};
  DriveEnergy energy;
};

/// How many steps make so many seconds, to the nearest.
[[nodiscard]] std::uint64_t steps_in(double seconds, SimDuration step);

struct TrafficOptions : TrafficTerms {
  std::shared_ptr<const zone::TrafficZone> zone;
  std::size_t aivs{12};
  std::vector<Job> jobs;  ///< in the order of their times; none: everybody circulates
  // Of a zone that is one of many (experiments/transport/site):
  std::vector<zone::TrackPosition> exits;  ///< where vehicles leave it
  std::size_t spare{0};                    ///< so many more than it begins with can be in it at a time
  std::uint32_t first_aiv{0};              ///< number of its first vehicle among all zones'
};

/// A vehicle with a load on its way from one zone to another.
struct Traveller {
  std::uint32_t aiv{};  ///< its number among all zones' vehicles
  Job job;              ///< its exit is the one it left by
  std::uint64_t left_step{};
};

/// A fleet's traffic on a zone in virtual time, and what is counted of it.
class TrafficRun {
 public:
  /// Fails ("traffic.room") where the zone does not hold so many, ("traffic.options") on options out of range, and as
  /// Fleet::make does.
  [[nodiscard]] static Result<TrafficRun> make(TrafficOptions options);

  /// So many seconds further, at most to the end. False: it is there.
  bool advance(double seconds);
  bool advance(double seconds, Workers& workers);
  /// One step further; what advance() is made of.
  void step(Workers& workers);
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// Who has left the zone in this step.
  [[nodiscard]] std::vector<Traveller> take_leaving();
  /// False: there is no room for it now, there or in the whole zone.
  [[nodiscard]] bool bring(const Traveller& traveller, zone::TrackPosition position);
  [[nodiscard]] double time_s() const;  ///< the warm-up included
  [[nodiscard]] double end_s() const { return options_.warm_up_s + options_.duration_s; }
  [[nodiscard]] const virtual_side::Fleet& fleet() const { return *fleet_; }
  [[nodiscard]] TrafficMetrics metrics() const;
  [[nodiscard]] const Dispatcher& dispatcher() const { return *dispatcher_; }

 private:
  TrafficRun(TrafficOptions options, std::unique_ptr<virtual_side::Fleet> fleet);
  void take_sample();
  void record_near_misses();
  void end_warm_up();

  /// Totals, so that what came before the end of the warm-up can be taken away.
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
  TrafficMetrics sampled_;  ///< what samples fill
  struct {
    double count{};
    double stopped{};
    double open_jobs{};
  } curve_;                                         ///< sums since its last point
  std::vector<std::uint32_t> numbers_;              ///< AIVs', of each vehicle
  std::vector<virtual_side::Fleet::Vehicle> away_;  ///< the last comes next
  double present_s_{0.0};
  std::vector<double> speed_mps_;  ///< in the step before
  double gained_m2ps2_{0.0};       ///< of squared speed, by all together
  std::vector<char> is_near_;      ///< by vehicle; empty until anybody ever was
  std::uint64_t near_misses_{0};
  std::vector<std::uint32_t> laps_;
  std::vector<double> lap_began_s_;
};

}  // namespace cosiva::experiments
