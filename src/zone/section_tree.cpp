#include "zone/section_tree.h"

#include <cmath>
#include <numeric>

#include "base/expect.h"

namespace cosiva::zone {
namespace {

constexpr double piece_turn_max_rad = 0.5;
// Far more than rounding moves anything by, and nothing beside a vehicle.
constexpr double margin_m = 1e-7;
constexpr double margin_rad = 1e-6;

/// Where a cell of a 65536 × 65536 grid comes on the Hilbert curve.
std::uint64_t hilbert(std::uint32_t x, std::uint32_t y) {
  std::uint64_t along = 0;
  for (std::uint32_t side = 1U << 15U; side > 0; side >>= 1U) {
    const bool right = (x & side) != 0;
    const bool up = (y & side) != 0;
    along += std::uint64_t{side} * side * (right ? (up ? 2U : 3U) : (up ? 1U : 0U));
    // Each quarter holds the curve turned so that its ends meet those of its neighbours.
    if (up) continue;
    if (right) {
      x = (side - 1U) - (x & (side - 1U));
      y = (side - 1U) - (y & (side - 1U));
    }
    std::swap(x, y);
  }
  return along;
}

}  // namespace

SectionTree::Headings SectionTree::headings_near(double heading_rad, double half_width_rad) {
  constexpr double sector_rad = 2.0 * pi / 32.0;
  const double half = half_width_rad + margin_rad;
  if (!(half < pi - sector_rad) || !std::isfinite(heading_rad)) return every_heading;
  const double middle = wrap_angle(heading_rad) + 2.0 * pi;  // so that both ends are positive
  Headings headings = 0;
  const auto first = static_cast<std::uint32_t>((middle - half) / sector_rad);
  const auto last = static_cast<std::uint32_t>((middle + half) / sector_rad);
  for (std::uint32_t sector = first; sector <= last; ++sector) headings |= Headings{1} << (sector % 32U);
  return headings;
}

void SectionTree::cut(std::uint32_t id, const Section& section, double piece_max_m) {
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
    pieces_.push_back({from, to, bulge_m, id, headings_near(heading_rad, 0.5 * bend_per_m * piece_m)});
    from = to;
  }
}

void SectionTree::enclose(Node& node, std::uint32_t child, const Piece& piece) const {
  // A millionth outwards covers what single precision loses, of the box and of whoever asks.
  const auto down = [](double x) { return static_cast<float>(x - 1e-6 * (1.0 + std::fabs(x))); };
  const auto up = [](double x) { return static_cast<float>(x + 1e-6 * (1.0 + std::fabs(x))); };
  node.low_x[child] = down(std::min(piece.from.x_m, piece.to.x_m) - piece.bulge_m);
  node.low_y[child] = down(std::min(piece.from.y_m, piece.to.y_m) - piece.bulge_m);
  node.high_x[child] = up(std::max(piece.from.x_m, piece.to.x_m) + piece.bulge_m);
  node.high_y[child] = up(std::max(piece.from.y_m, piece.to.y_m) + piece.bulge_m);
  node.headings[child] = piece.headings;
}

void SectionTree::enclose(Node& node, std::uint32_t child, const Node& below) const {
  for (std::uint32_t i = 0; i < fan_out; ++i) {
    node.low_x[child] = std::min<float>(node.low_x[child], below.low_x[i]);
    node.low_y[child] = std::min<float>(node.low_y[child], below.low_y[i]);
    node.high_x[child] = std::max<float>(node.high_x[child], below.high_x[i]);
    node.high_y[child] = std::max<float>(node.high_y[child], below.high_y[i]);
  }
  for (const Headings headings : below.headings) node.headings[child] |= headings;
}

void SectionTree::build() {
  const auto middle = [](const Piece& piece) {
    return Point2{0.5 * (piece.from.x_m + piece.to.x_m), 0.5 * (piece.from.y_m + piece.to.y_m)};
  };
  Point2 low{middle(pieces_.front())};
  Point2 high{low};
  for (const Piece& piece : pieces_) {
    const Point2 p = middle(piece);
    low = {std::min(low.x_m, p.x_m), std::min(low.y_m, p.y_m)};
    high = {std::max(high.x_m, p.x_m), std::max(high.y_m, p.y_m)};
  }
  const double cell_m = std::max({high.x_m - low.x_m, high.y_m - low.y_m, 1e-6}) / 65535.0;
  const auto cell = [cell_m](double x, double low_x) {
    return static_cast<std::uint32_t>((x - low_x) / cell_m) & 0xFFFFU;
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(pieces_.size());
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    const Point2 p = middle(pieces_[i]);
    order[i] = {hilbert(cell(p.x_m, low.x_m), cell(p.y_m, low.y_m)), i};
  }
  std::sort(order.begin(), order.end());
  std::vector<Piece> sorted;
  sorted.reserve(pieces_.size());
  for (const auto& [along, i] : order) sorted.push_back(pieces_[i]);
  pieces_ = std::move(sorted);

  static constexpr float nowhere = 1e18F;  // its square is still a number
  const auto none = [] {
    Node node{};
    node.low_x += nowhere;
    node.low_y += nowhere;
    node.high_x -= nowhere;
    node.high_y -= nowhere;
    return node;
  };
  std::uint32_t below_first = 0;
  auto below_count = static_cast<std::uint32_t>(pieces_.size());
  nodes_.reserve(below_count / (fan_out - 1) + depth_max);
  for (std::uint32_t level = 0; level == 0 || below_count > 1; ++level) {
    COSIVA_EXPECT(level + 1 < depth_max);
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    for (std::uint32_t i = 0; i < below_count; i += fan_out) {
      Node node = none();
      node.first = below_first + i;
      node.lowest = level == 0;
      for (std::uint32_t child = 0; child < std::min(fan_out, below_count - i); ++child) {
        if (node.lowest)
          enclose(node, child, pieces_[node.first + child]);
        else
          enclose(node, child, nodes_[node.first + child]);
      }
      nodes_.push_back(node);
    }
    below_first = first;
    below_count = static_cast<std::uint32_t>(nodes_.size()) - first;
  }
}

}  // namespace cosiva::zone
