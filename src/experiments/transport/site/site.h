#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/base/ranks.h"
#include "cosiva/base/result.h"
#include "cosiva/base/workers.h"
#include "cosiva/experiments/transport/site/site_metrics.h"
#include "cosiva/experiments/transport/site/site_plan.h"
#include "cosiva/experiments/transport/traffic/traffic.h"

namespace cosiva::experiments {

struct SiteOptions : TrafficTerms {
  SitePlan plan;
  /// One for each of the plan's zones; zones of one file have the same object.
  std::vector<std::shared_ptr<const zone::TrafficZone>> zones;
  double jobs_per_hour{0.0};  ///< in each zone; 0: all vehicles circulate
  double away_ratio{0.2};     ///< ratio of jobs that lead into a neighbouring zone, if there is one
};

/// Zones with transfer points, each zone stepped by one rank. Between two synchronisations of the ranks every zone is
/// independent: the period is the shortest transfer time, so that no vehicle arrives before its rank knows of it.
///
/// Invariant: the zones of a rank are consecutive, and every arrival is at a transfer point of the plan.
class SiteRun {
 public:
  /// Fails as TrafficRun::make does, naming the zone; ("site.transfer_point") where a transfer point names an unknown
  /// zone or station, or leads to a position where no vehicle may stop; ("site.options") on options out of range.
  [[nodiscard]] static Result<SiteRun> make(SiteOptions options, Ranks& ranks);

  /// Runs to the next synchronisation. False: the run is over. Must be called equally often on all ranks.
  bool advance(Workers& workers);
  [[nodiscard]] double time_s() const;
  [[nodiscard]] double end_s() const { return options_.warm_up_s + options_.duration_s; }
  /// Must be called on all ranks.
  [[nodiscard]] SiteMetrics metrics() const;

 private:
  struct Transfer {  ///< a transfer point with its positions
    std::size_t to_zone;
    zone::TrackPosition enter;
    std::uint64_t takes_steps;
  };
  struct Arrival {
    std::uint64_t due_step;
    std::size_t transfer_point;
    Traveller traveller;
  };
  struct SiteZone {  ///< a zone of this rank
    std::size_t index;
    std::unique_ptr<TrafficRun> run;
    std::deque<Arrival> arrivals;                         ///< by due_step, then transfer point, then AIV
    std::vector<std::pair<std::size_t, Traveller>> left;  ///< by transfer point, since the last synchronisation
  };
  SiteRun(SiteOptions options, Ranks& ranks) : options_{std::move(options)}, ranks_{&ranks} {}
  [[nodiscard]] Result<void> lay_transfers();
  [[nodiscard]] Result<void> open_zones();
  [[nodiscard]] Result<TrafficOptions> options_of(std::size_t zone, std::uint32_t first_aiv) const;
  [[nodiscard]] std::size_t owner_of(std::size_t zone) const;
  /// The zone, which this rank must own.
  [[nodiscard]] SiteZone& site_zone_of(std::size_t zone);
  void drive(SiteZone& site_zone, std::uint64_t until_step) const;
  void meet();

  SiteOptions options_;
  Ranks* ranks_;
  std::vector<Transfer> transfers_;              ///< by transfer point
  std::vector<std::vector<std::size_t>> exits_;  ///< by zone: transfer points, in the order of its jobs' exits
  std::vector<SiteZone> site_zones_;             ///< of consecutive zones
  std::uint64_t meeting_steps_{10};
  std::uint64_t steps_{0};
  std::uint64_t end_steps_{0};
};

}  // namespace cosiva::experiments
