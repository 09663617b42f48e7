#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/geometry/section.h"

namespace cosiva::zone {

/// Sixteenths of a half turn, one bit each.
using Headings = std::uint32_t;
inline constexpr Headings every_heading = ~Headings{0};
/// All headings within `half_width_rad` of this one, and a little more.
[[nodiscard]] Headings headings_near(double heading_rad, double half_width_rad);

/// The stretch of a section within `bulge_m` of a chord: the element of an index of sections.
struct SectionPiece {
  Point2 from;
  Point2 to;
  double bulge_m;
  std::uint32_t section;
  Headings headings;  ///< the directions of its headings

  /// False only where all of it is further than `limit_m` from p.
  [[nodiscard]] bool may_come_within(double limit_m, Point2 p) const;
  [[nodiscard]] Point2 centre() const { return {0.5 * (from.x_m + to.x_m), 0.5 * (from.y_m + to.y_m)}; }
};

inline bool SectionPiece::may_come_within(double limit_m, Point2 p) const {
  const double along_x = to.x_m - from.x_m;
  const double along_y = to.y_m - from.y_m;
  const double x = p.x_m - from.x_m;
  const double y = p.y_m - from.y_m;
  const double square = along_x * along_x + along_y * along_y;
  const double t = square > 0.0 ? std::clamp((x * along_x + y * along_y) / square, 0.0, 1.0) : 0.0;
  const double out_x = x - t * along_x;
  const double out_y = y - t * along_y;
  const double reach_m = limit_m + bulge_m;
  return out_x * out_x + out_y * out_y <= reach_m * reach_m;
}

/// Appends the pieces of a section, none longer than `piece_max_m`, all nearly straight.
void cut_into_pieces(std::uint32_t id, const Section& section, double piece_max_m, std::vector<SectionPiece>& pieces);

/// The least box that holds the centres of these pieces, of which there is at least one.
[[nodiscard]] Box box_of_centres(std::span<const SectionPiece> pieces);

/// The pieces of sections 0, 1, …, at least one, as `section_at(index)` gives them.
template <typename SectionAt>
[[nodiscard]] std::vector<SectionPiece> pieces_of(std::size_t count, const SectionAt& section_at) {
  // Boxes of short pieces hardly overlap; half a section's mean length keeps their number in bounds.
  double length_m = 0.0;
  for (std::size_t id = 0; id < count; ++id) length_m += section_at(id).length_m();
  const double piece_max_m = 0.5 * length_m / static_cast<double>(count);
  std::vector<SectionPiece> pieces;
  for (std::size_t id = 0; id < count; ++id)
    cut_into_pieces(static_cast<std::uint32_t>(id), section_at(id), piece_max_m, pieces);
  return pieces;
}

}  // namespace cosiva::zone
