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

/// A campaign being done: all units that no earlier run has finished, on the threads of all ranks. In rounds: each rank
/// takes its share of what is left, until its time is up; then all tell each other what they have done. So nobody has
/// to hand out work, a slow rank does less, and what is lost with a killed process is a round.
class CampaignRun {
 public:
  /// Keeps lines of finished units; rank 0's alone is used. What it fails with ends the campaign.
  using Keep = std::function<Result<void>(std::string_view lines)>;
  /// Whether no more units should be begun in this round; several threads ask it. Each round does at least one unit.
  using TimeIsUp = std::function<bool()>;

  /// @param work  outlives this
  /// @param known  what is finished already, or why it cannot be told: rank 0's counts, the others may give nothing
  /// Fails, on all ranks alike, with rank 0's error, and ("campaign.ranks") where they do not have the same plan and
  /// zone.
  [[nodiscard]] static Result<CampaignRun> make(const CampaignWork& work, Result<std::vector<UnitRecord>> known,
                                                Ranks& ranks);

  /// One round. False when nothing is left. Fails on all ranks alike.
  [[nodiscard]] Result<bool> advance(Workers& workers, const TimeIsUp& time_is_up, const Keep& keep);

  [[nodiscard]] double cost_done() const { return cost_done_; }  ///< as CampaignWork::cost() says
  [[nodiscard]] double cost_all() const { return cost_all_; }
  [[nodiscard]] std::size_t units_done() const { return work_->units() - left_.size(); }
  /// All units in their order once nothing is left; rank 0's alone.
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
  std::vector<UnitRecord> records_;  ///< rank 0's: of all ranks, by unit
  double cost_done_{};
  double cost_all_{};
};

}  // namespace cosiva::experiments
