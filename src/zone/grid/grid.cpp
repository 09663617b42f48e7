#include "cosiva/zone/grid/grid.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
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
  /// In the line that was read last. @param column  from 0
  [[nodiscard]] std::string location(std::size_t column) const {
    return "line " + std::to_string(std::max<std::size_t>(number_, 1)) + ", column " + std::to_string(column + 1);
  }

 private:
  std::string_view rest_;
  std::size_t number_{0};
};

// A map larger than this is an error in its header rather than a floor.
constexpr std::uint32_t side_max = 1U << 14U;

bool read_side(std::string_view number, std::uint32_t& side) {
  const auto [end, status] = std::from_chars(number.data(), number.data() + number.size(), side);
  return status == std::errc{} && end == number.data() + number.size() && side > 0 && side <= side_max;
}

Result<void> read_header(Lines& lines, Grid& grid) {
  std::string_view line;
  while (lines.next(line)) {
    if (line == "map") {
      if (grid.width > 0 && grid.height > 0) return {};
      return fail("grid.header", "the map begins before its height and width are stated", lines.location(0));
    }
    if (line.starts_with("type ")) continue;
    const std::size_t number = line.find(' ') + 1;
    const std::string_view key = line.substr(0, number);
    if (key != "height " && key != "width ")
      return fail("grid.header", "expected 'type', 'height N', 'width N' or 'map'", lines.location(0));
    if (!read_side(line.substr(number), key == "height " ? grid.height : grid.width))
      return fail("grid.header", "expected a number of squares from 1 to 16384", lines.location(number));
  }
  return fail("grid.header", "the file ends before its map", lines.location(line.size()));
}

/// A row and the squares that its map may mean as stops.
Result<void> read_row(std::string_view row, Grid& grid, bool& has_emitter, const Lines& lines) {
  if (row.size() != grid.width)
    return fail("grid.row", "the row has " + std::to_string(row.size()) + " squares, not " + std::to_string(grid.width),
                lines.location(std::min<std::size_t>(row.size(), grid.width)));
  for (std::size_t x = 0; x < row.size(); ++x) {
    const char square = row[x];
    const bool is_free = std::string_view{".GSE"}.find(square) != std::string_view::npos;
    if (!is_free && std::string_view{"@OTW"}.find(square) == std::string_view::npos) {
      std::string text{"no square of a map: "};
      text.push_back(square);
      return fail("grid.character", std::move(text), lines.location(x));
    }
    if (square == 'E' || square == 'S') grid.stops.push_back(static_cast<std::uint32_t>(grid.free.size()));
    has_emitter = has_emitter || square == 'E';
    grid.free.push_back(is_free ? 1 : 0);
  }
  return {};
}

}  // namespace

Result<Grid> read_grid(std::string_view text) {
  Lines lines{text};
  Grid grid;
  if (auto good = read_header(lines, grid); !good) return tl::unexpected{good.error()};
  std::string_view row;
  bool has_emitter = false;
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    if (!lines.next(row))
      return fail("grid.row",
                  "the map ends after " + std::to_string(y) + " of " + std::to_string(grid.height) + " rows",
                  lines.location(row.size()));
    if (auto good = read_row(row, grid, has_emitter, lines); !good) return tl::unexpected{good.error()};
  }
  while (lines.next(row))
    if (!row.empty()) return fail("grid.row", "the map has more rows than its height states", lines.location(0));
  if (!has_emitter) grid.stops.clear();
  return grid;
}

}  // namespace cosiva::zone
