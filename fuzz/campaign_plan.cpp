// The plan of a campaign, as its user writes it. An accepted plan must be a grid within the limits.
#include <algorithm>
#include <cmath>

#include "cosiva/experiments/positioning/campaign/plan.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto plan = experiments::read_campaign_plan(fuzz::as_text(data, size), "fuzz.toml");
  if (!plan) {
    COSIVA_EXPECT(!plan.error().code.empty() && !plan.error().message.empty());
    COSIVA_EXPECT(plan.error().location.starts_with("fuzz.toml"));
    return 0;
  }
  COSIVA_EXPECT(plan->runs >= 1 && !plan->algorithms.empty());
  COSIVA_EXPECT(plan->votes() <= experiments::campaign_votes_max);
  for (const auto& values : plan->values) {
    COSIVA_EXPECT(!values.empty() && std::ranges::is_sorted(values, std::ranges::less_equal{}));
    for (const double value : values) COSIVA_EXPECT(std::isfinite(value));
  }
  COSIVA_EXPECT(plan->environment(plan->environments() - 1).back() == plan->of(experiments::Swept::pitch).back());
  return 0;
}
