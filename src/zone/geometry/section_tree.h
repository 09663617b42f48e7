#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/geometry/section_pieces.h"

namespace cosiva::zone {

/// Finds the sections near a point without a linear search: a packed R-tree over short pieces of them, laid along a
/// Hilbert curve. Besides its box each node stores the headings of its pieces, so that a search for sections of one
/// direction skips all others; this, and queries without allocation, are the reasons not to use Boost.Geometry's.
class SectionTree {
 public:
  SectionTree() = default;
  /// Of at least one piece.
  explicit SectionTree(std::vector<SectionPiece> pieces);

  /// Calls visit(id) for the section of every piece that heads into `headings` and that may come within `limit_m` of p:
  /// nothing nearer is left out, some are further, an id may come several times, in no particular order. `limit_m` is
  /// read again after each call: a search for the nearest lowers it.
  template <typename Visit>
  void visit(Point2 p, Headings headings, const double& limit_m, Visit&& visit) const;

 private:
  static constexpr std::uint32_t fan_out = 4;
  static constexpr std::size_t depth_max = 20;  // 4^19 pieces are more than a file can hold

  using Four [[gnu::vector_size(fan_out * sizeof(float))]] = float;
  /// The boxes of four children side by side, for the processor to compare at once; in single precision, rounded
  /// outwards. Missing children have a box that nothing is near to.
  struct Node {
    Four low_x, low_y, high_x, high_y;
    std::array<Headings, fan_out> headings;
    std::uint32_t first;  ///< child i is node or, on the lowest level, piece first + i
    bool lowest;
  };

  void sort();
  void build();
  void enclose(Node& node, std::uint32_t child, const SectionPiece& piece) const;
  void enclose(Node& node, std::uint32_t child, const Node& below) const;

  std::vector<SectionPiece> pieces_;
  std::vector<Node> nodes_;  ///< the root is the last
};

template <typename Visit>
void SectionTree::visit(Point2 p, Headings headings, const double& limit_m, Visit&& visit) const {
  struct Entry {
    float square;  // of the distance
    std::uint32_t index;
    bool is_piece;
  };
  if (nodes_.empty()) return;
  const auto p_x = static_cast<float>(p.x_m);
  const auto p_y = static_cast<float>(p.y_m);
  // Single precision keeps seven digits: the rounding is far less than this.
  const auto limit_square = [&] { return static_cast<float>(std::min(limit_m * limit_m, 1e37)) * 1.0001F + 1e-12F; };
  // Depth first, the nearest child first: at most all children but one of each level wait.
  std::array<Entry, depth_max * fan_out> waiting;
  std::size_t count = 0;
  waiting[count++] = {0.0F, static_cast<std::uint32_t>(nodes_.size() - 1), false};
  while (count > 0) {
    const Entry entry = waiting[--count];
    if (!(entry.square <= limit_square())) continue;
    if (entry.is_piece) {
      const SectionPiece& piece = pieces_[entry.index];
      if (piece.may_come_within(limit_m, p)) visit(piece.section);
      continue;
    }
    const Node& node = nodes_[entry.index];
    const Four left = node.low_x - p_x;
    const Four right = p_x - node.high_x;
    const Four below = node.low_y - p_y;
    const Four above = p_y - node.high_y;
    Four x = left > right ? left : right;
    Four y = below > above ? below : above;
    x = x > 0.0F ? x : Four{};
    y = y > 0.0F ? y : Four{};
    const Four square = x * x + y * y;
    const float limit = limit_square();
    const std::size_t first = count;
    for (std::uint32_t i = 0; i < fan_out; ++i) {
      if (!(square[i] <= limit) || (node.headings[i] & headings) == 0) continue;
      std::size_t at = count++;
      for (; at > first && waiting[at - 1].square < square[i]; --at) waiting[at] = waiting[at - 1];  // the nearest last
      waiting[at] = {square[i], node.first + i, node.lowest};
    }
  }
}

}  // namespace cosiva::zone
