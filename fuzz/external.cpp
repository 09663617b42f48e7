#include <cmath>
#include <string>

#include "cosiva/app/positioning/external_algorithm.h"
#include "target.h"

/// The response of an algorithm in an external program.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto estimate = app::read_estimate(std::string(fuzz::as_text(data, size)));
  if (!estimate) {
    COSIVA_EXPECT(estimate.error().code == "algorithm.garbage" && !estimate.error().message.empty());
    return 0;
  }
  COSIVA_EXPECT(std::isfinite(estimate->pose.x_m) && std::isfinite(estimate->pose.y_m));
  COSIVA_EXPECT(estimate->pose.heading_rad > -pi && estimate->pose.heading_rad <= pi);
  // A covariance is complete or absent.
  COSIVA_EXPECT(std::isfinite(estimate->covariance(0, 0)) == std::isfinite(estimate->covariance(2, 2)));
  return 0;
}
