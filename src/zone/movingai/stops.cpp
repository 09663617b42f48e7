#include "cosiva/zone/movingai/stops.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

/// Chooses one square after the other. Invariant: open squares are free ones of the part that are no stops.
class StopSelection {
 public:
  StopSelection(const Grid& grid, const std::vector<std::uint32_t>& part)
      : grid_{grid}, uses_(grid.free.size(), Use::none) {
    for (const std::uint32_t square : part) uses_[square] = Use::open;
  }

  /// False, and unchanged: a stop there would part other squares, or leave a stop without a square next to it.
  [[nodiscard]] bool choose(std::uint32_t square);

 private:
  enum class Use : std::uint8_t { none, open, stop };
  using Offset = std::pair<std::int32_t, std::int32_t>;
  /// Around a square; those with an even index have an edge in common with it.
  static constexpr std::array<Offset, 8> around{{{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

  /// Of the square at this offset from another one; none outside the grid.
  [[nodiscard]] Use use(std::uint32_t square, const Offset& offset) const;
  [[nodiscard]] bool is_open(std::uint32_t square, const Offset& offset) const {
    return use(square, offset) == Use::open;
  }
  [[nodiscard]] bool obstructs_a_stop(std::uint32_t square) const;
  [[nodiscard]] bool has_open_neighbour(std::uint32_t square) const;
  [[nodiscard]] bool parts_neighbours(std::uint32_t square) const;

  const Grid& grid_;
  std::vector<Use> uses_;
};

StopSelection::Use StopSelection::use(std::uint32_t square, const Offset& offset) const {
  const std::uint32_t x = square % grid_.width + static_cast<std::uint32_t>(offset.first);
  const std::uint32_t y = square / grid_.width + static_cast<std::uint32_t>(offset.second);
  return grid_.is_free(x, y) ? uses_[y * grid_.width + x] : Use::none;
}

bool StopSelection::has_open_neighbour(std::uint32_t square) const {
  for (std::size_t i = 0; i < around.size(); i += 2)
    if (is_open(square, around[i])) return true;
  return false;
}

/// Squares around it that follow each other have an edge in common: neighbours in one run of open ones
/// remain connected.
bool StopSelection::parts_neighbours(std::uint32_t square) const {
  std::array<bool, around.size()> open{};
  for (std::size_t i = 0; i < around.size(); ++i) open[i] = is_open(square, around[i]);
  // A run begins where the square before is not open; one that consists of a corner alone has no neighbour in it.
  std::size_t runs = 0;
  for (std::size_t i = 0; i < around.size(); ++i) {
    if (!open[i] || open[(i + around.size() - 1) % around.size()]) continue;
    const bool has_neighbour = i % 2 == 0 || open[(i + 1) % around.size()];
    runs += has_neighbour ? 1U : 0U;
  }
  return runs > 1;
}

/// Whether a stop has no other open square next to it.
bool StopSelection::obstructs_a_stop(std::uint32_t square) const {
  for (std::size_t i = 0; i < around.size(); i += 2) {
    if (use(square, around[i]) != Use::stop) continue;
    const auto stop = static_cast<std::uint32_t>(static_cast<std::int32_t>(square) + around[i].first +
                                                 around[i].second * static_cast<std::int32_t>(grid_.width));
    std::size_t open = 0;
    for (std::size_t j = 0; j < around.size(); j += 2) open += is_open(stop, around[j]) ? 1U : 0U;
    if (open < 2) return true;
  }
  return false;
}

bool StopSelection::choose(std::uint32_t square) {
  COSIVA_EXPECT(uses_[square] == Use::open);
  if (!has_open_neighbour(square) || parts_neighbours(square) || obstructs_a_stop(square)) return false;
  uses_[square] = Use::stop;
  return true;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> connected_squares(const Grid& grid) {
  std::vector<std::vector<std::uint32_t>> parts;
  std::vector<std::uint8_t> visited(grid.free.size(), 0);
  for (std::uint32_t first = 0; first < visited.size(); ++first) {
    if (grid.free[first] == 0 || visited[first] != 0) continue;
    std::vector<std::uint32_t> part{first};
    visited[first] = 1;
    const auto visit = [&](std::uint32_t x, std::uint32_t y) {
      const std::uint32_t square = y * grid.width + x;
      if (!grid.is_free(x, y) || visited[square] != 0) return;
      visited[square] = 1;
      part.push_back(square);
    };
    for (std::size_t i = 0; i < part.size(); ++i) {
      const std::uint32_t x = part[i] % grid.width;
      const std::uint32_t y = part[i] / grid.width;
      visit(x + 1, y);
      visit(x - 1, y);
      visit(x, y + 1);
      visit(x, y - 1);
    }
    std::sort(part.begin(), part.end());
    parts.push_back(std::move(part));
  }
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return parts;
}

std::vector<std::uint32_t> distributed_stops(const Grid& grid, std::size_t count) {
  const auto parts = connected_squares(grid);
  std::vector<std::uint32_t> stops;
  if (parts.empty()) return stops;
  const auto& part = parts.front();
  // In steps of about the golden ratio, so that the first few are distributed over all.
  std::size_t step = std::max<std::size_t>(1, static_cast<std::size_t>(0.618 * static_cast<double>(part.size())));
  while (std::gcd(step, part.size()) != 1) ++step;
  StopSelection selection{grid, part};
  for (std::size_t i = 0; i < part.size() && stops.size() < count; ++i) {
    const std::uint32_t square = part[i * step % part.size()];
    if (selection.choose(square)) stops.push_back(square);
  }
  std::sort(stops.begin(), stops.end());
  return stops;
}

}  // namespace cosiva::zone
