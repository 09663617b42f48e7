#include "cosiva/zone/geometry/section_grid.h"

#include <utility>

namespace cosiva::zone {
namespace {

// In a larger zone single precision would lose too much for a grid to be of use; further from the map's origin double
// precision loses more than the margins allow.
constexpr double extent_max_m = 1e7;
constexpr double coordinate_max_m = 1e8;
// Of the zone's extent: ten times the rounding of a position in it in single precision.
constexpr double loss_ratio = 1.2e-6;
// An upper bound of the rounding of a distance in double precision.
constexpr double hair_m = 1e-6;
constexpr double pieces_per_cell = 1.0;

}  // namespace

SectionGrid::SectionGrid(std::span<const SectionPiece> pieces) {
  const Box box = box_of_centres(pieces);
  const Point2 high = box.high;
  origin_ = box.low;
  for (const SectionPiece& piece : pieces)
    reach_m_ = std::max(reach_m_, 0.5 * distance(piece.from, piece.to) + piece.bulge_m + hair_m);
  const double width_m = high.x_m - origin_.x_m;
  const double height_m = high.y_m - origin_.y_m;
  const double furthest_m =
      std::max({std::fabs(origin_.x_m), std::fabs(origin_.y_m), std::fabs(high.x_m), std::fabs(high.y_m)});
  if (!(std::max({width_m, height_m, reach_m_}) < extent_max_m && furthest_m < coordinate_max_m)) return;

  // So large that there are not many more cells than pieces, and that a piece reaches at most half a cell far.
  const auto count = static_cast<double>(pieces.size());
  cell_m_ =
      std::max({std::sqrt(pieces_per_cell * width_m * height_m / count), (width_m + height_m) / count, 2.0 * reach_m_});
  columns_ = static_cast<std::size_t>(width_m / cell_m_) + 1;
  rows_ = static_cast<std::size_t>(height_m / cell_m_) + 1;
  fill(pieces);
}

void SectionGrid::fill(std::span<const SectionPiece> pieces) {
  const double extent_m = static_cast<double>(std::max(columns_, rows_)) * cell_m_ + reach_m_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order(pieces.size());
  first_.assign(columns_ * rows_ + 1, 0);
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    const std::size_t cell = cell_of(pieces[i].centre());
    order[i] = {static_cast<std::uint32_t>(cell), i};
    ++first_[cell + 1];
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  std::sort(order.begin(), order.end());
  records_.reserve(pieces.size());
  for (const auto& [cell, i] : order) records_.push_back(record_of(pieces[i], loss_ratio * extent_m));
}

SectionGrid::Record SectionGrid::record_of(const SectionPiece& piece, double loss_m) const {
  const double x = piece.to.x_m - piece.from.x_m;
  const double y = piece.to.y_m - piece.from.y_m;
  const double square = x * x + y * y;
  // Of a chord so short that its square's inverse would be huge, one end represents all of it.
  const double shortest_m = 1e-6;
  const bool is_point = square < shortest_m * shortest_m;
  Record record{};
  record.from_x = static_cast<float>(piece.from.x_m - origin_.x_m);
  record.from_y = static_cast<float>(piece.from.y_m - origin_.y_m);
  record.along_x = is_point ? 0.0F : static_cast<float>(x);
  record.along_y = is_point ? 0.0F : static_cast<float>(y);
  record.per_square = is_point ? 0.0F : static_cast<float>(1.0 / square);
  record.bulge_m = static_cast<float>(piece.bulge_m + loss_m + (is_point ? shortest_m : 0.0)) * 1.0001F;
  record.section = piece.section;
  record.headings = piece.headings;
  return record;
}

std::size_t SectionGrid::cell_of(Point2 p) const {
  const auto column = static_cast<std::size_t>((p.x_m - origin_.x_m) / cell_m_);
  const auto row = static_cast<std::size_t>((p.y_m - origin_.y_m) / cell_m_);
  return std::min(row, rows_ - 1) * columns_ + std::min(column, columns_ - 1);
}

}  // namespace cosiva::zone
