#include "cosiva/zone/geometry/section_pieces.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"

namespace cosiva::zone {
namespace {

constexpr double piece_turn_max_rad = 0.5;
// Far more than any rounding, and negligible for a vehicle.
constexpr double margin_m = 1e-7;
constexpr double margin_rad = 1e-6;

}  // namespace

Headings headings_near(double heading_rad, double half_width_rad) {
  constexpr double sector_rad = 2.0 * pi / 32.0;
  const double half = half_width_rad + margin_rad;
  if (!(half < pi - sector_rad) || !std::isfinite(heading_rad)) return every_heading;
  const double centre = wrap_angle(heading_rad) + 2.0 * pi;  // so that both ends are positive
  Headings headings = 0;
  const auto first = static_cast<std::uint32_t>((centre - half) / sector_rad);
  const auto last = static_cast<std::uint32_t>((centre + half) / sector_rad);
  for (std::uint32_t sector = first; sector <= last; ++sector) headings |= Headings{1} << (sector % 32U);
  return headings;
}

void cut_into_pieces(std::uint32_t id, const Section& section, double piece_max_m, std::vector<SectionPiece>& pieces) {
  const double length_m = section.length_m();
  const double bend_per_m = section.curvature_max_per_m();
  const double count = std::ceil(std::max({1.0, bend_per_m * length_m / piece_turn_max_rad, length_m / piece_max_m}));
  const double piece_m = length_m / count;
  // A curve by arc length strays from its chord by at most ⅛·h²·max|κ|.
  const double bulge_m = 0.125 * piece_m * piece_m * bend_per_m + margin_m;
  Point2 from = position(section.start());
  for (double i = 1.0; i <= count; i += 1.0) {
    const Point2 to = position(section.pose_at(i == count ? length_m : i * piece_m));
    const double heading_rad = section.pose_at((i - 0.5) * piece_m).heading_rad;
    pieces.push_back({from, to, bulge_m, id, headings_near(heading_rad, 0.5 * bend_per_m * piece_m)});
    from = to;
  }
}

Box box_of_centres(std::span<const SectionPiece> pieces) {
  Box box{pieces.front().centre(), pieces.front().centre()};
  for (const SectionPiece& piece : pieces) {
    const Point2 p = piece.centre();
    box.low = {std::min(box.low.x_m, p.x_m), std::min(box.low.y_m, p.y_m)};
    box.high = {std::max(box.high.x_m, p.x_m), std::max(box.high.y_m, p.y_m)};
  }
  return box;
}

}  // namespace cosiva::zone
