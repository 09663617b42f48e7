#include "cosiva/virtual/fleet/state.h"

namespace cosiva::virtual_side {

void State::resize(std::size_t vehicles, bool limits, bool turns) {
  for (auto* numbers : {&s_m, &v_mps, &x_m, &y_m, &heading_rad}) numbers->assign(vehicles, 0.0);
  for (auto* positions : {&offset_m, &halt_at, &line_at, &goal_at, &event_at, &cap_mps})
    positions->assign(vehicles, far_m);
  slow_at.assign(limits ? vehicles : 0, far_m);
  slow_mps.assign(limits ? vehicles : 0, 0.0);
  turn_left_rad.assign(turns ? vehicles : 0, 0.0);
  turn_radps.assign(turns ? vehicles : 0, 0.0);
  for (auto* counts : {&leader, &section, &waited_steps}) counts->assign(vehicles, 0);
  own.assign(vehicles, {});
  queue.assign(vehicles, {});
  profile.assign(vehicles, -1);
  imposed.assign(vehicles, no_profile);
  mode.assign(vehicles, 0);
  event.assign(vehicles, 0);
}

std::size_t State::bytes() const {
  std::size_t bytes = allocated_bytes(own) + allocated_bytes(queue) + allocated_bytes(profile);
  for (const auto* values : {&s_m, &v_mps, &next_mps, &offset_m, &halt_at, &line_at, &goal_at, &event_at, &cap_mps,
                             &slow_at, &slow_mps, &x_m, &y_m, &heading_rad, &turn_left_rad, &turn_radps})
    bytes += allocated_bytes(*values);
  for (const auto* values : {&leader, &section, &waited_steps}) bytes += allocated_bytes(*values);
  for (const auto* values : {&imposed, &mode, &event}) bytes += allocated_bytes(*values);
  return bytes;
}

}  // namespace cosiva::virtual_side
