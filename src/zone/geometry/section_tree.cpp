#include "cosiva/zone/geometry/section_tree.h"

#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

/// The position of a cell of a 65536 × 65536 grid on the Hilbert curve.
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

void SectionTree::enclose(Node& node, std::uint32_t child, const SectionPiece& piece) const {
  // A millionth outwards covers the rounding to single precision, of the box and of the query.
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

SectionTree::SectionTree(std::vector<SectionPiece> pieces) : pieces_{std::move(pieces)} {
  sort();
  build();
}

/// Along a Hilbert curve.
void SectionTree::sort() {
  const auto [low, high] = box_of_centres(pieces_);
  const double cell_m = std::max({high.x_m - low.x_m, high.y_m - low.y_m, 1e-6}) / 65535.0;
  const auto cell = [cell_m](double x, double low_x) {
    return static_cast<std::uint32_t>((x - low_x) / cell_m) & 0xFFFFU;
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(pieces_.size());
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    const Point2 p = pieces_[i].centre();
    order[i] = {hilbert(cell(p.x_m, low.x_m), cell(p.y_m, low.y_m)), i};
  }
  std::sort(order.begin(), order.end());
  std::vector<SectionPiece> sorted;
  sorted.reserve(pieces_.size());
  for (const auto& [along, i] : order) sorted.push_back(pieces_[i]);
  pieces_ = std::move(sorted);
}

void SectionTree::build() {
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
