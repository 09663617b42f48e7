#include "cosiva/app/battery/battery_text.h"

#include <algorithm>

#include "cosiva/app/cli/console.h"
#include "cosiva/experiments/battery/analysis.h"

namespace cosiva::app {

std::string progress_text(const experiments::Procedure& procedure, SimTime now) {
  const auto progress = procedure.progress(now);
  std::string text = "run " + std::to_string(std::min(procedure.present_run() + 1, procedure.options().runs)) + " of " +
                     std::to_string(procedure.options().runs) + ": " + decimals(100.0 * progress.ratio, 0) + " %";
  if (progress.expected_end)
    text += ", its end in " + experiments::duration_text(to_seconds(*progress.expected_end - now));
  return text;
}

std::string stop_text(const std::optional<std::size_t>& stopped_after, double half_width_percent) {
  const std::string width = decimals(half_width_percent, 2) + " %";
  return stopped_after ? "the mean was known to " + width + " after " + std::to_string(*stopped_after) +
                             " batteries: no more are needed"
                       : "the mean is not known to " + width + " yet; it takes five batteries at least";
}

}  // namespace cosiva::app
