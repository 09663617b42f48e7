#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/geometry/section_pieces.h"

namespace cosiva::zone {

/// Finds the sections near a point where that is easy, and reports where it is not: a grid of square cells, each piece
/// in the cell that holds its centre. A query reads the pieces of four cells, which lie in two contiguous blocks of
/// memory, where a tree follows one pointer after the other. There are hardly more cells than pieces. Where very many
/// pieces are close together, or the result is far away, the grid reports that a tree must be queried.
class SectionGrid {
 public:
  SectionGrid() = default;
  explicit SectionGrid(std::span<const SectionPiece> pieces);

  /// Calls visit(id) for each section with a piece that heads into `headings`, lies around p and may come within
  /// `limit_m` of it, nearest first, more or less; where more cells must be read, again for those visited before.
  /// `limit_m` is read again after each call: a search for the nearest lowers it. True: no other such section comes
  /// within the `limit_m` of that moment. False: others may.
  template <typename Visit>
  [[nodiscard]] bool visit(Point2 p, Headings headings, const double& limit_m, const Visit& visit) const;

 private:
  static constexpr std::size_t crowd = 64;  ///< candidates at once
  /// A piece in single precision, from `origin_`; `bulge_m` covers the rounding.
  struct Record {
    float from_x, from_y, along_x, along_y;
    float per_square;  ///< 1 over the chord's length squared, 0 for a point
    float bulge_m;
    std::uint32_t section;
    Headings headings;

    [[nodiscard]] float least_m(float x, float y) const;
  };
  /// The pieces around a point, to be taken nearest first.
  struct Candidates {
    std::array<float, crowd> least_m;
    std::array<std::uint32_t, crowd> section;
    std::size_t count{0};

    void add(float m, std::uint32_t id);
    template <typename Visit>
    void take(const double& limit_m, const Visit& visit);
  };

  /// Columns from left to before right, rows from low to before high.
  struct Block {
    std::size_t left, right, low, high;
  };
  static constexpr std::size_t scanned_max = 256;  ///< records of a block
  static constexpr double half_max = 5.0;          ///< cells searched on each side of p

  [[nodiscard]] std::size_t size_of(const Block& block) const;
  [[nodiscard]] double steady_m(const Block& block, double column_at, double row_at) const;
  template <typename Visit>
  [[nodiscard]] bool survey_block(const Block& block, Point2 p, Headings headings, const double& limit_m,
                                  const Visit& visit) const;
  void fill(std::span<const SectionPiece> pieces);
  [[nodiscard]] Record record_of(const SectionPiece& piece, double loss_m) const;
  [[nodiscard]] std::size_t cell_of(Point2 p) const;

  Point2 origin_;  ///< the lowest corner
  double cell_m_{1.0};
  double reach_m_{0.0};  ///< no piece reaches further from its centre
  std::size_t columns_{0};
  std::size_t rows_{0};
  std::vector<Record> records_;       ///< row by row, cell by cell
  std::vector<std::uint32_t> first_;  ///< record of each cell, and one past the last
};

/// Never more than its distance from the section.
inline float SectionGrid::Record::least_m(float x, float y) const {
  const float p_x = x - from_x;
  const float p_y = y - from_y;
  const float t = std::clamp((p_x * along_x + p_y * along_y) * per_square, 0.0F, 1.0F);
  const float out_x = p_x - t * along_x;
  const float out_y = p_y - t * along_y;
  return std::sqrt(out_x * out_x + out_y * out_y) - bulge_m;
}

inline void SectionGrid::Candidates::add(float m, std::uint32_t id) {
  least_m[count] = m;
  section[count++] = id;
}

template <typename Visit>
void SectionGrid::Candidates::take(const double& limit_m, const Visit& visit) {
  while (count > 0) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < count; ++i) nearest = least_m[i] < least_m[nearest] ? i : nearest;
    if (!(static_cast<double>(least_m[nearest]) <= limit_m)) return;
    const std::uint32_t id = section[nearest];
    visit(id);
    std::size_t left = 0;  // without this section's pieces
    for (std::size_t i = 0; i < count; ++i) {
      least_m[left] = least_m[i];
      section[left] = section[i];
      left += section[i] != id ? 1U : 0U;
    }
    count = left;
  }
}

inline std::size_t SectionGrid::size_of(const Block& block) const {
  std::size_t size = 0;
  for (std::size_t row = block.low; row < block.high; ++row)
    size += first_[row * columns_ + block.right] - first_[row * columns_ + block.left];
  return size;
}

/// All pieces nearer to p than this are in the block; beyond the grid's own edge there is nothing.
inline double SectionGrid::steady_m(const Block& block, double column_at, double row_at) const {
  constexpr double far = std::numeric_limits<double>::infinity();
  const double left = block.left > 0 ? column_at - static_cast<double>(block.left) : far;
  const double right = block.right < columns_ ? static_cast<double>(block.right) - column_at : far;
  const double below = block.low > 0 ? row_at - static_cast<double>(block.low) : far;
  const double above = block.high < rows_ ? static_cast<double>(block.high) - row_at : far;
  return std::min({left, right, below, above}) * cell_m_ - reach_m_;
}

template <typename Visit>
bool SectionGrid::survey_block(const Block& block, Point2 p, Headings headings, const double& limit_m,
                               const Visit& visit) const {
  Candidates candidates;
  const auto x = static_cast<float>(p.x_m - origin_.x_m);
  const auto y = static_cast<float>(p.y_m - origin_.y_m);
  for (std::size_t row = block.low; row < block.high; ++row) {
    const std::uint32_t end = first_[row * columns_ + block.right];
    for (std::uint32_t i = first_[row * columns_ + block.left]; i < end; ++i) {
      const Record& record = records_[i];
      if ((record.headings & headings) == 0) continue;
      const float least_m = record.least_m(x, y);
      if (!(static_cast<double>(least_m) <= limit_m)) continue;
      if (candidates.count == crowd) return false;
      candidates.add(least_m, record.section);
    }
  }
  candidates.take(limit_m, visit);
  return true;
}

template <typename Visit>
bool SectionGrid::visit(Point2 p, Headings headings, const double& limit_m, const Visit& visit) const {
  const double column_at = (p.x_m - origin_.x_m) / cell_m_;
  const double row_at = (p.y_m - origin_.y_m) / cell_m_;
  if (!(column_at >= 0.0 && column_at < static_cast<double>(columns_) && row_at >= 0.0 &&
        row_at < static_cast<double>(rows_)))
    return false;
  // The four cells around p first, more while they are empty, then as many as may hold a nearer piece.
  double half = 0.5;
  while (half <= half_max) {
    const auto cells = [half](double at, std::size_t count) {
      return std::pair{static_cast<std::size_t>(std::max(at - half, 0.0)),
                       std::min(static_cast<std::size_t>(at + half) + 1, count)};
    };
    const auto [left, right] = cells(column_at, columns_);
    const auto [low, high] = cells(row_at, rows_);
    const Block block{left, right, low, high};
    if (size_of(block) > scanned_max || !survey_block(block, p, headings, limit_m, visit)) return false;
    if (limit_m <= steady_m(block, column_at, row_at)) return true;
    const double wanted = (std::max(limit_m, 0.0) + reach_m_) / cell_m_;
    half = std::max(wanted < std::numeric_limits<double>::infinity() ? wanted : 3.0 * half, 1.01 * half);
  }
  return false;
}

}  // namespace cosiva::zone
