#pragma once

#include <string>

#include "cosiva/experiments/positioning/campaign/result.h"

namespace cosiva::experiments {

/// A few lines for a terminal.
[[nodiscard]] std::string to_text(const CampaignResult& result);
/// "2.61", "under 0.1", "over 4": metres of pitch.
[[nodiscard]] std::string to_string(const Crossing& crossing);
/// Of a selection the factors that the plan sweeps: "missed_ratio = 0.3"; empty where it leaves all open.
[[nodiscard]] std::string to_string(const CampaignPlan& plan, const Selection& selection);

}  // namespace cosiva::experiments
