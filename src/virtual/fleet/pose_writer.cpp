#include "cosiva/virtual/fleet/pose_writer.h"

#include <span>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::virtual_side {

PoseWriter::PoseWriter(FleetTables& tables, const Paths& paths)
    : ground_{tables.ground},
      numbers_{tables.numbers},
      state_{tables.state},
      paths_{paths},
      table_{tables.ground.circuit()} {}

void PoseWriter::write(std::uint32_t first, std::uint32_t last) {
  COSIVA_EXPECT(first <= last && last <= state_.s_m.size());
  const std::size_t count = last - first;
  const auto part = [&](auto& values) { return std::span(values).subspan(first, count); };
  table_.poses(part(state_.section), part(state_.s_m), part(state_.x_m), part(state_.y_m), part(state_.heading_rad));
  if (!numbers_.has_turns) return;
  for (std::uint32_t i = first; i < last; ++i) {
    if ((state_.mode[i] & Mode::turning) == 0) continue;
    const double whole_rad = ground_.turn_rad(state_.section[i], paths_.next(paths_.path_of(i)));
    state_.heading_rad[i] = wrap_angle(state_.heading_rad[i] + (whole_rad - state_.turn_left_rad[i]));
  }
}

}  // namespace cosiva::virtual_side
