#pragma once

#include <string>

#include "cosiva/experiments/positioning/campaign/result.h"

namespace cosiva::experiments {

/// A short text for a terminal.
[[nodiscard]] std::string to_text(const CampaignResult& result);
/// "2.61", "under 0.1", "over 4": metres of pitch.
[[nodiscard]] std::string to_string(const Crossing& crossing);
/// The swept factors of a selection: "missed_ratio = 0.3"; empty where all are open.
[[nodiscard]] std::string to_string(const CampaignPlan& plan, const Selection& selection);

}  // namespace cosiva::experiments
