#include "cosiva/experiments/positioning/recording/trajectory.h"

#include <cmath>

#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva::experiments;
  const auto text = cosiva::fuzz::as_text(data, size);
  const auto trajectory = read_trajectory("fuzz.tum", text);
  if (!trajectory) {
    COSIVA_EXPECT(trajectory.error().code.starts_with("recording.") && !trajectory.error().message.empty());
    COSIVA_EXPECT(trajectory.error().location.starts_with("fuzz.tum"));
    return 0;
  }
  for (std::size_t i = 0; i < trajectory->poses.size(); ++i) {
    COSIVA_EXPECT(std::isfinite(trajectory->poses[i].pose().heading_rad));
    COSIVA_EXPECT(i == 0 || trajectory->poses[i].t_s > trajectory->poses[i - 1].t_s);
  }
  // An accepted trajectory can be written, reads back the same, and has no error against itself.
  const std::string written = write_tum(*trajectory);
  const auto again = read_trajectory(TrajectoryFormat::tum, "again", written);
  COSIVA_EXPECT(again.has_value() && write_tum(*again) == written);
  const auto pairs = associate(*trajectory, *trajectory, {});
  COSIVA_EXPECT(pairs.has_value() && ape(*pairs).max == 0.0);
  return 0;
}
