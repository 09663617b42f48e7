#pragma once

#include <string>

#include "cosiva/experiments/positioning/campaign/result.h"

namespace cosiva::experiments {

/// One JSON document: `plan`, `cells[]`, `pitches[]`, `leaks`, `digest`.
[[nodiscard]] std::string to_json(const CampaignResult& result);

}  // namespace cosiva::experiments
