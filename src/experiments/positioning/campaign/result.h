#pragma once

#include <vector>

#include "cosiva/experiments/positioning/campaign/summary.h"

/// A campaign as others read it. No time, machine or number of processes is in it: the same plan gives the same files.
namespace cosiva::experiments {

struct CampaignResult {
  const CampaignWork& work;
  const std::vector<UnitRecord>& records;
  const CampaignSummary& summary;
};

}  // namespace cosiva::experiments
