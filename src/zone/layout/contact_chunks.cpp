#include "cosiva/zone/layout/contact_chunks.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

constexpr double chunk_max_m = 0.25;  // sections are compared chunk by chunk

}  // namespace

Chunks::Chunks(const Circuit& circuit, const ContactRules& rules) {
  cut(circuit, rules);
  sort_into_cells(rules);
}

void Chunks::cut(const Circuit& circuit, const ContactRules& rules) {
  for (SectionId id = 0; id < circuit.size(); ++id) {
    first_.push_back(static_cast<std::uint32_t>(all_.size()));
    const Section& section = circuit.section(id);
    // On a large zone with large vehicles, chunks grow with the vehicle.
    const double chunk_m = std::max(chunk_max_m, rules.half_length_m);
    const double count = std::max(1.0, std::ceil(section.length_m() / chunk_m));
    const double bend_per_m = section.curvature_max_per_m();
    for (double i = 0.0; i < count; i += 1.0) {
      Chunk chunk{};
      chunk.section = id;
      chunk.from_m = section.length_m() * (i / count);
      chunk.to_m = section.length_m() * ((i + 1.0) / count);
      if (i == 0.0 && circuit.previous(id).empty()) chunk.before_m = rules.half_length_m;
      if (i + 1.0 == count && circuit.next(id).empty()) chunk.after_m = rules.half_length_m;
      chunk.centre = position(section.pose_at(0.5 * (chunk.from_m + chunk.to_m)));
      chunk.start = section.pose_at(chunk.from_m) * Point2{-chunk.before_m, 0.0};
      chunk.end = section.pose_at(chunk.to_m) * Point2{chunk.after_m, 0.0};
      // A curve deviates from its chord by at most ⅛·h²·max|κ|; the overhang is straight, but turned against it.
      const double length_m = chunk.to_m - chunk.from_m;
      const double turn_rad = std::min(bend_per_m * length_m, pi);
      chunk.bulge_m = std::min(0.125 * bend_per_m * length_m * length_m, length_m) +
                      (chunk.before_m + chunk.after_m) * turn_rad + 1e-9;
      chunk.sideways_m = rules.half_length_m * turn_rad;
      all_.push_back(chunk);
    }
  }
  first_.push_back(static_cast<std::uint32_t>(all_.size()));
}

void Chunks::sort_into_cells(const ContactRules& rules) {
  double radius_max_m = 0.0;
  for (const Chunk& chunk : all_) radius_max_m = std::max(radius_max_m, chunk.radius_m());
  // Cells so large that neighbours are in the same cell or in one of the eight around it.
  cell_m_ = 2.0 * radius_max_m + std::max(rules.reach_m, rules.disc_m + norm(rules.half_length_m, rules.half_width_m));
  cells_.reserve(all_.size());
  for (std::uint32_t i = 0; i < all_.size(); ++i) cells_.emplace_back(cell_of(all_[i].centre), i);
  std::sort(cells_.begin(), cells_.end());
  COSIVA_EXPECT(cells_.size() == all_.size() && all_.size() + 1 >= first_.size());
}

Chunks::Cell Chunks::cell_of(Point2 p) const {
  return {static_cast<std::int64_t>(std::floor(p.x_m / cell_m_)),
          static_cast<std::int64_t>(std::floor(p.y_m / cell_m_))};
}

void Chunks::survey_neighbours(Cell home) {
  for (std::size_t i = 0; i < around_.size(); ++i) {
    const std::int64_t column = home.first - 1 + static_cast<std::int64_t>(i);
    const Entry low{{column, home.second - 1}, 0};
    const Entry past{{column, home.second + 2}, 0};
    const auto first = std::lower_bound(cells_.begin(), cells_.end(), low);
    const auto last = std::lower_bound(first, cells_.end(), past);
    around_[i] = {static_cast<std::size_t>(first - cells_.begin()), static_cast<std::size_t>(last - cells_.begin())};
  }
  home_ = home;
  looked_ = true;
}

}  // namespace cosiva::zone
