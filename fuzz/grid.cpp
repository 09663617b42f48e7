// The reader of MovingAI maps; what is accepted becomes a floor.
#include "cosiva/planning/floor/grid.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva::planning;
  const auto grid = read_grid(cosiva::fuzz::as_text(data, size));
  if (!grid) {
    COSIVA_EXPECT(grid.error().code.starts_with("grid.") && !grid.error().message.empty());
    COSIVA_EXPECT(grid.error().location.starts_with("line ") &&
                  grid.error().location.find(", column ") != std::string::npos);
    return 0;
  }
  COSIVA_EXPECT(grid->width > 0 && grid->height > 0);
  COSIVA_EXPECT(grid->free.size() == std::size_t{grid->width} * grid->height);
  for (const std::uint32_t stop : grid->stops) COSIVA_EXPECT(stop < grid->free.size() && grid->free[stop] != 0);
  if (grid->free.size() > 4096) return 0;
  const Floor floor = grid_floor(*grid, GridMotion::forward_turn);
  COSIVA_EXPECT(floor.goals() == grid->free.size() && floor.states() == 4 * grid->free.size());
  for (StateId state = 0; state < floor.states(); ++state) {
    COSIVA_EXPECT(floor.successors(state).empty() == (grid->free[state / 4] == 0));
    for (const StateId to : floor.successors(state)) COSIVA_EXPECT(grid->free[to / 4] != 0);
  }
  return 0;
}
