#pragma once

#include "cosiva/experiments/positioning/campaign/result.h"
#include "cosiva/experiments/positioning/campaign/table.h"

namespace cosiva::experiments {

/// A row per run and algorithm: factors, algorithm, seed, rmse_m, … The referenced data must outlive the table.
[[nodiscard]] ResultTable runs_table(const CampaignResult& result);
/// A row per cell.
[[nodiscard]] ResultTable cells_table(const CampaignResult& result);
/// A row per algorithm and surrounding: the widest pitch that meets the tolerance.
[[nodiscard]] ResultTable pitches_table(const CampaignResult& result);
/// key, value: the plan.
[[nodiscard]] ResultTable campaign_table(const CampaignResult& result);

}  // namespace cosiva::experiments
