#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/aiv/estimation/track.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/campaign/plan.h"
#include "cosiva/experiments/positioning/campaign/vote.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// The zone and the path of a campaign.
struct CampaignGround {
  std::shared_ptr<const zone::TrafficZone> zone;
  std::shared_ptr<const estimation::Track> track;
};

/// A plan cut into units: blocks of runs in one environment, with all algorithms on the same runs. The units depend on
/// the plan alone; the result of a unit depends only on the plan, the ground and the unit's number.
class CampaignWork {
 public:
  /// Fails ("simulation.…", "campaign.grid") where an environment is impossible, with its values as the location.
  [[nodiscard]] static Result<CampaignWork> make(CampaignPlan plan, CampaignGround ground);

  struct Unit {
    std::size_t environment;
    std::uint32_t first_run;
    std::uint32_t runs;
  };
  [[nodiscard]] const CampaignPlan& plan() const { return plan_; }
  [[nodiscard]] const CampaignGround& ground() const { return ground_; }
  [[nodiscard]] std::size_t units() const;
  [[nodiscard]] Unit unit(std::size_t number) const;
  /// The unit that contains a run of an environment.
  [[nodiscard]] std::size_t unit_of(std::size_t environment, std::size_t run) const;
  /// The number of iterations of a unit, over all algorithms: its approximate cost.
  [[nodiscard]] double cost(std::size_t number) const;
  /// Digest of all inputs of the runs, as 16 hexadecimal digits: another digest means other runs. The plan's name and
  /// its tolerance are not included.
  [[nodiscard]] std::string identity() const;
  [[nodiscard]] bool backtracks(std::size_t algorithm) const { return algorithms_[algorithm].backtracks; }

  /// Thread-safe. Fails where an algorithm does.
  [[nodiscard]] Result<UnitRecord> done(std::size_t number) const;

 private:
  CampaignWork(CampaignPlan plan, CampaignGround ground) : plan_{std::move(plan)}, ground_{std::move(ground)} {}
  [[nodiscard]] Result<void> checked(const SweptValues& values) const;
  [[nodiscard]] Simulation bare(const SweptValues& values) const;  ///< without the fiducials of a grid
  [[nodiscard]] Simulation simulation(const SweptValues& values) const;
  [[nodiscard]] std::optional<zone::BeaconGrid> grid(const SweptValues& values) const;
  [[nodiscard]] FiducialsFound found(const Simulation& simulation) const;

  CampaignPlan plan_;
  CampaignGround ground_;
  std::vector<estimation::Registered> algorithms_;
  std::uint32_t block_{1};  ///< runs of a unit; the last of an environment may have fewer
};

/// "pitch_m = 0.5, missed_ratio = 0.3": the swept factors.
[[nodiscard]] std::string to_string(const CampaignPlan& plan, const SweptValues& values);

}  // namespace cosiva::experiments
