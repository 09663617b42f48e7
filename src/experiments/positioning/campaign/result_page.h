#pragma once

#include <string>

#include "cosiva/experiments/positioning/campaign/result.h"

namespace cosiva::experiments {

/// One HTML page that needs nothing else.
/// @param plan_text  as it was read, to be shown
[[nodiscard]] std::string to_html(const CampaignResult& result, const std::string& plan_text);

}  // namespace cosiva::experiments
