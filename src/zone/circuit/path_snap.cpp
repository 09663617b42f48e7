#include "cosiva/zone/circuit/path_snap.h"

#include <cmath>
#include <vector>

namespace cosiva::zone {

std::optional<Circuit::Located> snap_to_path(const Circuit& circuit, const Pose2& X_MB, double within_m) {
  std::vector<Circuit::Located> near;
  circuit.near(position(X_MB), within_m, near);
  std::optional<Circuit::Located> best;
  double best_m = 0.0;
  for (const Circuit::Located& here : near) {
    const double turned_rad = wrap_angle(circuit.pose_at(here.position).heading_rad - X_MB.heading_rad);
    const double cost_m = here.distance_m + snap_m_per_rad * std::fabs(turned_rad);
    const bool better =
        !best || cost_m < best_m || (cost_m == best_m && here.position.section < best->position.section);
    if (!better) continue;
    best = here;
    best_m = cost_m;
  }
  return best;
}

}  // namespace cosiva::zone
