#include "cosiva/planning/floor/grid.h"

#include <array>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

constexpr std::uint32_t headings = 4;
constexpr std::array<std::int32_t, headings> step_x{1, 0, -1, 0};
constexpr std::array<std::int32_t, headings> step_y{0, 1, 0, -1};

/// The free square next to (x, y) in one of four directions, or none.
bool neighbour(const Grid& grid, std::uint32_t square, std::uint32_t direction, std::uint32_t& next) {
  const std::uint32_t x = square % grid.width + static_cast<std::uint32_t>(step_x[direction]);
  const std::uint32_t y = square / grid.width + static_cast<std::uint32_t>(step_y[direction]);
  if (!grid.is_free(x, y)) return false;
  next = y * grid.width + x;
  return true;
}

void add_square_any(const Grid& grid, std::uint32_t square, FloorDescription& floor) {
  floor.states.push_back({{square}, {}});
  floor.goals.push_back({square});
  if (grid.free[square] == 0) return;
  std::uint32_t next{};
  for (std::uint32_t direction = 0; direction < headings; ++direction)
    if (neighbour(grid, square, direction, next)) floor.states.back().moves.push_back({next, {}});
}

void add_square_turn(const Grid& grid, std::uint32_t square, FloorDescription& floor) {
  const StateId first = square * headings;
  std::uint32_t next{};
  for (std::uint32_t heading = 0; heading < headings; ++heading) {
    auto& state = floor.states.emplace_back();
    state.footprint = {square};
    if (grid.free[square] == 0) continue;
    if (neighbour(grid, square, heading, next)) state.moves.push_back({next * headings + heading, {}});
    state.moves.push_back({first + (heading + 1) % headings, {}});
    state.moves.push_back({first + (heading + 3) % headings, {}});
  }
  floor.goals.push_back({first, first + 1, first + 2, first + 3});
}

}  // namespace

Floor grid_floor(const Grid& grid, GridMotion motion) {
  FloorDescription description;
  const std::uint32_t squares = grid.width * grid.height;
  description.cells = squares;
  for (std::uint32_t square = 0; square < squares; ++square) {
    if (motion == GridMotion::any_direction)
      add_square_any(grid, square, description);
    else
      add_square_turn(grid, square, description);
  }
  auto floor = Floor::make(description);
  COSIVA_EXPECT(floor.has_value());
  return *std::move(floor);
}

}  // namespace cosiva::planning
