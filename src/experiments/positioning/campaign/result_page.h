#pragma once

#include <string>

#include "cosiva/experiments/positioning/campaign/result.h"

namespace cosiva::experiments {

/// Writes one self-contained HTML page.
/// @param plan_text  the plan's text, to be printed
[[nodiscard]] std::string to_html(const CampaignResult& result, const std::string& plan_text);

}  // namespace cosiva::experiments
