#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/layout/contacts.h"

namespace cosiva::zone {

/// A short stretch of a section, and beyond an open end the overhang of a vehicle that is stopped there.
struct Chunk {
  SectionId section;
  double from_m;
  double to_m;
  double before_m;  ///< straight on before from_m, 0 but at an open start
  double after_m;
  Point2 centre;
  Point2 start;  ///< of its chord, overhang included
  Point2 end;
  double bulge_m;     ///< the chunk's deviation from its chord
  double sideways_m;  ///< the deviation of a body's ends from the chord because it turns

  /// All of it lies within this distance of its centre.
  [[nodiscard]] double radius_m() const { return 0.5 * (to_m - from_m) + std::max(before_m, after_m); }
};

/// The sections of a circuit cut into chunks, those of a section one after the other, and found by their position.
/// Invariant: each section has at least one chunk, and each chunk is in one cell.
class Chunks {
 public:
  Chunks(const Circuit& circuit, const ContactRules& rules);

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(all_.size()); }
  [[nodiscard]] const Chunk& operator[](std::uint32_t index) const { return all_[index]; }
  /// The first chunk of a section; one past the last of all for the section past the last.
  [[nodiscard]] std::uint32_t first_of(SectionId section) const { return first_[section]; }

  /// Calls visit(chunk's index), until it is false, for all chunks in the cells around p, in no particular order: all
  /// that may come within reach of p are among them.
  template <typename Visit>
  void visit_around(Point2 p, const Visit& visit);

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;
  using Entry = std::pair<Cell, std::uint32_t>;

  void cut(const Circuit& circuit, const ContactRules& rules);
  void sort_into_cells(const ContactRules& rules);
  [[nodiscard]] Cell cell_of(Point2 p) const;
  void survey_neighbours(Cell home);

  std::vector<Chunk> all_;
  std::vector<std::uint32_t> first_;
  double cell_m_{1.0};
  std::vector<Entry> cells_;  ///< sorted
  /// The three columns around `home_` in `cells_`: queries along a section are mostly in the same cell.
  Cell home_{};
  std::array<std::pair<std::size_t, std::size_t>, 3> around_{};
  bool looked_{false};
};

template <typename Visit>
void Chunks::visit_around(Point2 p, const Visit& visit) {
  const Cell home = cell_of(p);
  if (!looked_ || home != home_) survey_neighbours(home);
  for (const auto& [first, last] : around_) {
    for (std::size_t i = first; i < last; ++i) {
      if (!visit(cells_[i].second)) return;
    }
  }
}

}  // namespace cosiva::zone
