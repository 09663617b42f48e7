#include "cosiva/zone/movingai/grid_tracks.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/zone/movingai/stops.h"

namespace cosiva::zone {
namespace {

constexpr std::size_t sections_max = 200'000;
constexpr std::size_t squares_max = 1'000'000;
constexpr std::size_t stations_max = 20'000;  // as in a native file
constexpr double coordinate_max_m = 1e5;

/// Directions of travel, anticlockwise from east. North is towards the row before.
constexpr std::uint32_t directions = 4;
constexpr std::array<std::int32_t, directions> step_x{1, 0, -1, 0};
constexpr std::array<std::int32_t, directions> step_y{0, -1, 0, 1};
constexpr std::array<double, directions> heading_rad{0.0, 0.5 * pi, pi, -0.5 * pi};

std::string node_id(std::uint32_t x, std::uint32_t y) { return "x" + std::to_string(x) + "y" + std::to_string(y); }

/// Lays the sections square by square, those of one square anticlockwise from the one that leads east.
/// Invariant: `first_[q]` is the number of sections that begin in squares before q.
class Layer {
 public:
  Layer(const Grid& grid, double pitch_m) : grid_{grid}, pitch_m_{pitch_m} {}

  Result<GridTracks> lay();

 private:
  [[nodiscard]] std::uint32_t squares() const { return grid_.width * grid_.height; }
  [[nodiscard]] std::uint32_t neighbour(std::uint32_t square, std::uint32_t direction) const {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(square) + step_x[direction] +
                                      step_y[direction] * static_cast<std::int32_t>(grid_.width));
  }
  [[nodiscard]] bool leads(std::uint32_t square, std::uint32_t direction) const;
  [[nodiscard]] SectionId section(std::uint32_t square, std::uint32_t direction) const;
  [[nodiscard]] std::string id_of(std::uint32_t square) const {
    return node_id(square % grid_.width, square / grid_.width);
  }
  void count_sections();
  Result<void> lay_section(std::uint32_t square, std::uint32_t direction);
  void add_stations();
  void record_parts();

  const Grid& grid_;
  double pitch_m_;
  std::vector<SectionId> first_;
  GridTracks tracks_;
};

bool Layer::leads(std::uint32_t square, std::uint32_t direction) const {
  const std::uint32_t x = square % grid_.width + static_cast<std::uint32_t>(step_x[direction]);
  const std::uint32_t y = square / grid_.width + static_cast<std::uint32_t>(step_y[direction]);
  return grid_.free[square] != 0 && grid_.is_free(x, y);
}

SectionId Layer::section(std::uint32_t square, std::uint32_t direction) const {
  SectionId id = first_[square];
  for (std::uint32_t before = 0; before < direction; ++before) id += leads(square, before) ? 1U : 0U;
  return id;
}

void Layer::count_sections() {
  first_.assign(1, 0);
  for (std::uint32_t square = 0; square < squares(); ++square) {
    SectionId count = 0;
    for (std::uint32_t direction = 0; direction < directions; ++direction) count += leads(square, direction) ? 1U : 0U;
    first_.push_back(first_.back() + count);
  }
  COSIVA_EXPECT(first_.size() == squares() + std::size_t{1});
}

Result<void> Layer::lay_section(std::uint32_t square, std::uint32_t direction) {
  const std::uint32_t column = square % grid_.width;
  const std::uint32_t row_from_south = grid_.height - 1 - square / grid_.width;
  const Point2 at{pitch_m_ * column, pitch_m_ * row_from_south};
  auto made = Section::make({at.x_m, at.y_m, heading_rad[direction]}, pitch_m_);
  if (!made) return tl::unexpected(made.error());
  const std::uint32_t to = neighbour(square, direction);
  Circuit::Part part{id_of(square) + "-" + id_of(to), std::move(*made), {}, {}, false};
  constexpr std::array<std::uint32_t, directions> turns{0, 1, 3, 2};  // straight on, left, right, back
  for (const std::uint32_t turn : turns) {
    const std::uint32_t after = (direction + turn) % directions;
    if (!leads(to, after)) continue;
    part.next.push_back(section(to, after));
    part.pivots = part.pivots || turn != 0;
  }
  tracks_.parts.push_back(std::move(part));
  tracks_.start_ids.push_back(id_of(square));
  return {};
}

void Layer::add_stations() {
  std::size_t isolated = 0;
  std::size_t beyond = 0;
  for (const std::uint32_t square : grid_.stops) {
    if (first_[square] == first_[square + 1])
      ++isolated;
    else if (tracks_.stations.size() == stations_max)
      ++beyond;
    else
      tracks_.stations.push_back({"S" + std::to_string(tracks_.stations.size() + 1), {first_[square], 0.0}});
  }
  if (isolated > 0)
    tracks_.diagnostics.push_back({Diagnostic::Kind::lost, "map",
                                   std::to_string(isolated) + " of the squares with E or S have no free neighbour; "
                                                              "there is no station"});
  if (beyond > 0)
    tracks_.diagnostics.push_back(
        {Diagnostic::Kind::lost, "map",
         "a zone has at most 20000 stations; the last " + std::to_string(beyond) + " squares with E or S have none"});
}

void Layer::record_parts() {
  const auto all = connected_squares(grid_);
  const auto single = std::count_if(all.begin(), all.end(), [](const auto& part) { return part.size() == 1; });
  if (single > 0)
    tracks_.diagnostics.push_back(
        {Diagnostic::Kind::lost, "map",
         std::to_string(single) + " free squares have no free neighbour; no track leads there"});
  const std::size_t parts = all.size() - static_cast<std::size_t>(single);
  if (parts > 1)
    tracks_.diagnostics.push_back({Diagnostic::Kind::notice, "map",
                                   "the free squares form " + std::to_string(parts) +
                                       " separate parts; the largest has " + std::to_string(all.front().size()) +
                                       " squares, the next " + std::to_string(all[1].size()) +
                                       "; no vehicle can drive from one to another"});
}

Result<GridTracks> Layer::lay() {
  if (std::uint64_t{grid_.width} * grid_.height > squares_max)
    return fail("zone.size",
                "expected at most 1000000 squares, found " + std::to_string(std::uint64_t{grid_.width} * grid_.height));
  if (pitch_m_ * std::max(grid_.width, grid_.height) > coordinate_max_m)
    return fail("zone.size", "the map is more than 100 km long; a smaller [import] scale may help");
  count_sections();
  if (first_.back() == 0) return fail("circuit.empty", "no two free squares are neighbours; nothing can be driven on");
  if (first_.back() > sections_max)
    return fail("zone.size", "expected at most 200000 sections, found " + std::to_string(first_.back()));
  tracks_.parts.reserve(first_.back());
  for (std::uint32_t square = 0; square < squares(); ++square)
    for (std::uint32_t direction = 0; direction < directions; ++direction)
      if (leads(square, direction))
        if (auto laid = lay_section(square, direction); !laid) return tl::unexpected(laid.error());
  add_stations();
  record_parts();
  tracks_.beacons = {pitch_m_, {}, grid_.width, grid_.height};
  return std::move(tracks_);
}

}  // namespace

Result<GridTracks> lay_grid_tracks(const Grid& grid, double pitch_m) { return Layer{grid, pitch_m}.lay(); }

}  // namespace cosiva::zone
