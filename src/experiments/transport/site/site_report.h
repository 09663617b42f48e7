#pragma once

#include <string>

#include "cosiva/experiments/transport/site/site_metrics.h"

namespace cosiva::experiments {

/// Writes one self-contained page. @param command  reproduces the result
[[nodiscard]] std::string to_html(const SiteMetrics& metrics, const std::string& command);

}  // namespace cosiva::experiments
