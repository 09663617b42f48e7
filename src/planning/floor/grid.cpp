#include "cosiva/planning/floor/grid.h"

#include <array>
#include <charconv>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

/// Lines of a text, without their ends; counts them for errors.
/// Invariant: `rest_` begins with a line of which `number_` lines are before.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_{text} {}

  [[nodiscard]] bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    ++number_;
    const auto end = rest_.find('\n');
    line = rest_.substr(0, end);
    COSIVA_EXPECT(line.size() <= rest_.size());
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return true;
  }
  [[nodiscard]] std::string location() const { return "line " + std::to_string(number_); }

 private:
  std::string_view rest_;
  std::size_t number_{0};
};

// A map larger than this is an error in its header rather than a floor.
constexpr std::uint32_t side_max = 1U << 14U;

bool read_side(std::string_view line, std::string_view key, std::uint32_t& side) {
  if (!line.starts_with(key) || line.size() <= key.size() || line[key.size()] != ' ') return false;
  line.remove_prefix(key.size() + 1);
  const auto [end, status] = std::from_chars(line.data(), line.data() + line.size(), side);
  return status == std::errc{} && end == line.data() + line.size() && side > 0 && side <= side_max;
}

Result<void> read_header(Lines& lines, Grid& grid) {
  std::string_view line;
  while (lines.next(line)) {
    if (line == "map") {
      if (grid.width > 0 && grid.height > 0) return {};
      return fail("grid.header", "the map begins before its height and width are stated", lines.location());
    }
    if (line.starts_with("type ") || read_side(line, "height", grid.height) || read_side(line, "width", grid.width))
      continue;
    return fail("grid.header", "'type', 'height N', 'width N' (N from 1 to 16384) or 'map' was expected",
                lines.location());
  }
  return fail("grid.header", "the file ends before its map", lines.location());
}

Result<void> read_row(std::string_view row, Grid& grid, const Lines& lines) {
  if (row.size() != grid.width)
    return fail("grid.row", "the row has " + std::to_string(row.size()) + " squares, not " + std::to_string(grid.width),
                lines.location());
  for (const char square : row) {
    const bool is_free = std::string_view{".GSE"}.find(square) != std::string_view::npos;
    if (!is_free && std::string_view{"@OTW"}.find(square) == std::string_view::npos) {
      std::string text{"no square of a map: "};
      text.push_back(square);
      return fail("grid.character", std::move(text), lines.location());
    }
    grid.free.push_back(is_free ? 1 : 0);
  }
  return {};
}

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

Result<Grid> read_grid(std::string_view text) {
  Lines lines{text};
  Grid grid;
  if (auto good = read_header(lines, grid); !good) return tl::unexpected{good.error()};
  std::string_view row;
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    if (!lines.next(row))
      return fail("grid.row",
                  "the map ends after " + std::to_string(y) + " of " + std::to_string(grid.height) + " rows",
                  lines.location());
    if (auto good = read_row(row, grid, lines); !good) return tl::unexpected{good.error()};
  }
  while (lines.next(row))
    if (!row.empty()) return fail("grid.row", "the map has more rows than its height states", lines.location());
  return grid;
}

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
