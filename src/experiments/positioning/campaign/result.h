#pragma once

#include <vector>

#include "cosiva/experiments/positioning/campaign/summary.h"

/// The result of a campaign for other programs, without time, machine or number of processes: the same plan gives the
/// same files.
namespace cosiva::experiments {

struct CampaignResult {
  const CampaignWork& work;
  const std::vector<UnitRecord>& records;
  const CampaignSummary& summary;
};

}  // namespace cosiva::experiments
