#pragma once

#include <string>

#include "cosiva/experiments/transport/site/site_metrics.h"

namespace cosiva::experiments {

/// One page, with nothing to be fetched. @param command  that gives the same again
[[nodiscard]] std::string to_html(const SiteMetrics& metrics, const std::string& command);

}  // namespace cosiva::experiments
