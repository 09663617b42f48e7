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
  /// One for each of the plan's zones; zones of one file share theirs.
  std::vector<std::shared_ptr<const zone::TrafficZone>> zones;
  double jobs_per_hour{0.0};  ///< in each zone; 0: everybody circulates
  double away_ratio{0.2};     ///< of jobs, that lead into a neighbouring zone, where there is one
};

/// Zones with passages, each zone stepped by one rank. Between two meetings of the ranks every zone is on its own: a
/// meeting comes as often as the shortest passage takes, so nobody arrives before it has been heard of.
class SiteRun {
 public:
  /// Fails as TrafficRun::make does, naming the zone; ("site.passage") where a passage names a zone or station that is
  /// not there, or leads to a place that no vehicle may stand at; ("site.options") on options out of range.
  [[nodiscard]] static Result<SiteRun> make(SiteOptions options, Ranks& ranks);

  /// To the next meeting. False: it is over. All ranks call it equally often.
  bool advance(Workers& workers);
  [[nodiscard]] double time_s() const;
  [[nodiscard]] double end_s() const { return options_.warm_up_s + options_.duration_s; }
  /// All ranks call it.
  [[nodiscard]] SiteMetrics metrics() const;

 private:
  struct Transfer {  ///< a passage, worked out
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
    std::deque<Arrival> arrivals;                         ///< by due_step, then passage, then AIV
    std::vector<std::pair<std::size_t, Traveller>> left;  ///< by passage, since the last meeting
  };
  SiteRun(SiteOptions options, Ranks& ranks) : options_{std::move(options)}, ranks_{&ranks} {}
  [[nodiscard]] Result<void> lay_transfers();
  [[nodiscard]] Result<void> open_zones();
  [[nodiscard]] Result<TrafficOptions> options_of(std::size_t zone, std::uint32_t first_aiv) const;
  [[nodiscard]] std::size_t owner_of(std::size_t zone) const;
  /// Of a zone that this rank owns.
  [[nodiscard]] SiteZone& site_zone_of(std::size_t zone);
  void drive(SiteZone& site_zone, std::uint64_t until_step) const;
  void meet();

  SiteOptions options_;
  Ranks* ranks_;
  std::vector<Transfer> transfers_;              ///< by passage
  std::vector<std::vector<std::size_t>> exits_;  ///< by zone: passages, as its jobs count them
  std::vector<SiteZone> site_zones_;             ///< of zones one after another
  std::uint64_t meeting_steps_{10};
  std::uint64_t steps_{0};
  std::uint64_t end_steps_{0};
};

}  // namespace cosiva::experiments
