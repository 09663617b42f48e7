#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/ranks.h"
#include "cosiva/base/workers.h"
#include "cosiva/experiments/positioning/campaign/state.h"
#include "cosiva/experiments/positioning/campaign/work.h"

namespace cosiva::experiments {

/// A campaign in progress: runs all units that no earlier run has finished, on the threads of all ranks. The run
/// proceeds in rounds: each rank takes its part of the remaining units, until its time is up; then all ranks exchange
/// what they have done. Therefore no rank has to distribute work, a slow rank does less, and a killed process loses one
/// round.
///
/// Invariant: the units that are left rise, the same on all ranks.
class CampaignRun {
 public:
  /// Stores lines of finished units; only rank 0's function is used. Its failure ends the campaign.
  using Keep = std::function<Result<void>(std::string_view lines)>;
  /// Whether no more units should be begun in this round; called by several threads. Each round does at least one unit.
  using TimeIsUp = std::function<bool()>;

  /// @param work  outlives this
  /// @param known  the units finished already, or why they are unknown: rank 0's counts, the others may pass nothing
  /// Fails, on all ranks alike, with rank 0's error, and ("campaign.ranks") where the ranks do not have the same plan
  /// and zone.
  [[nodiscard]] static Result<CampaignRun> make(const CampaignWork& work, Result<std::vector<UnitRecord>> known,
                                                Ranks& ranks);

  /// Does one round. False when no unit is left. Fails on all ranks alike.
  [[nodiscard]] Result<bool> advance(Workers& workers, const TimeIsUp& time_is_up, const Keep& keep);

  [[nodiscard]] double cost_done() const { return cost_done_; }  ///< in the unit of CampaignWork::cost()
  [[nodiscard]] double cost_all() const { return cost_all_; }
  [[nodiscard]] std::size_t units_done() const { return work_->units() - left_.size(); }
  /// All units in order once no unit is left; on rank 0 only.
  [[nodiscard]] std::vector<UnitRecord> take_records();

 private:
  CampaignRun(const CampaignWork& work, Ranks& ranks) : work_{&work}, ranks_{&ranks} {}
  [[nodiscard]] std::vector<std::size_t> ratio() const;
  void record_done(const std::vector<bool>& finished);
  [[nodiscard]] Result<void> report(const std::vector<std::optional<UnitRecord>>& mine,
                                    const std::optional<Error>& fault, const Keep& keep);
  [[nodiscard]] Result<void> take(const std::vector<std::string>& messages, const Keep& keep);

  const CampaignWork* work_;
  Ranks* ranks_;
  std::vector<std::size_t> left_;    ///< rising; the same on all ranks
  std::vector<UnitRecord> records_;  ///< on rank 0: those of all ranks, by unit
  double cost_done_{};
  double cost_all_{};
};

}  // namespace cosiva::experiments
