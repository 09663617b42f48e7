#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/base/random.h"
#include "cosiva/planning/floor/distances.h"
#include "cosiva/planning/floor/grid.h"

/// Files of other planners' benchmarks, and instances drawn from a seed.
namespace cosiva::fixture {

using planning::GoalId;
using planning::Grid;

/// A load that appears at some step, is to be picked up in one square and delivered to another one.
struct Delivery {
  std::uint32_t id{};
  GoalId pick_up{};
  GoalId delivery{};
  std::uint32_t appears{};
};

struct DeliveryInstance {
  std::vector<GoalId> starts;  ///< squares, by vehicle
  std::vector<Delivery> deliveries;
  std::vector<GoalId> pick_ups;  ///< squares in which loads may appear; empty: not known
};

/// Numbers of a file of the League of Robot Runners: the first one is how many follow, '#' begins a comment line.
inline Result<std::vector<std::uint32_t>> read_numbers(const std::string& path) {
  const auto text = adapters::read_file(path);
  if (!text) return tl::unexpected{text.error()};
  std::vector<std::uint32_t> numbers;
  std::string_view rest = *text;
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    std::uint32_t number{};
    if (line.empty() || line[0] == '#') continue;
    if (std::from_chars(line.data(), line.data() + line.size(), number).ec != std::errc{})
      return fail("numbers.line", "a line is no number", path);
    numbers.push_back(number);
  }
  if (numbers.empty() || numbers.size() <= numbers[0]) return fail("numbers.count", "numbers are missing", path);
  numbers.erase(numbers.begin());
  return numbers;
}

inline Result<Grid> read_map(const std::string& path) {
  const auto text = adapters::read_file(path);
  if (!text) return tl::unexpected{text.error()};
  return planning::read_grid(*text);
}

/// Starts and tasks of a result file of pibt2 (`starts=(x,y),…` and lines `id:from->to,appear=,finished=` after
/// `task=`).
inline Result<DeliveryInstance> read_pibt2(const std::string& path, const Grid& grid) {
  const auto text = adapters::read_file(path);
  if (!text) return tl::unexpected{text.error()};
  DeliveryInstance instance;
  const auto starts = text->find("starts=");
  const auto tasks = text->find("task=\n");
  if (starts == std::string::npos || tasks == std::string::npos) return fail("pibt2.file", "no starts or tasks", path);
  const char* at = text->c_str() + starts + 7;
  unsigned x{}, y{}, id{}, from{}, to{}, appears{};
  int length{};
  while (std::sscanf(at, "(%u,%u),%n", &x, &y, &length) == 2) {
    if (!grid.is_free(x, y)) return fail("pibt2.start", "a start is no free square of the map", path);
    instance.starts.push_back(y * grid.width + x);
    at += length;
  }
  at = text->c_str() + tasks + 6;
  while (std::sscanf(at, "%u:%u->%u,appear=%u,finished=%*d\n%n", &id, &from, &to, &appears, &length) == 4) {
    if (from >= grid.free.size() || to >= grid.free.size())
      return fail("pibt2.task", "a task is outside of the map", path);
    instance.deliveries.push_back({id, from, to, appears});
    at += length;
  }
  std::ranges::sort(instance.deliveries, {}, &Delivery::id);
  return instance;
}

/// The squares of a `.map.pd` file in which loads may appear ('s', 'p' and 'a').
inline Result<std::vector<GoalId>> read_pick_ups(const std::string& path, const Grid& grid) {
  const auto text = adapters::read_file(path);
  if (!text) return tl::unexpected{text.error()};
  std::vector<GoalId> squares;
  GoalId square = 0;
  for (const char character : *text) {
    if (character == '\n' || character == '\r') continue;
    if (square < grid.free.size() && grid.free[square] != 0 && std::string_view{"spa"}.find(character) < 3)
      squares.push_back(square);
    ++square;
  }
  return squares;
}

/// Free squares from which each of them can be reached: the component of the first square that has half of all free
/// ones.
inline std::vector<GoalId> connected_squares(const Grid& grid) {
  const planning::Floor floor = planning::grid_floor(grid, planning::GridMotion::any_direction);
  planning::Distances distances{floor};
  const auto count = static_cast<std::size_t>(std::ranges::count(grid.free, 1));
  for (GoalId square = 0; square < grid.free.size(); ++square) {
    if (grid.free[square] == 0) continue;
    const auto* const to = distances.to(square);
    std::vector<GoalId> squares;
    for (GoalId other = 0; other < grid.free.size(); ++other)
      if (to[other] != planning::Distances::unreachable && grid.free[other] != 0) squares.push_back(other);
    if (2 * squares.size() >= count) return squares;
  }
  return {};
}

/// Different squares in random sequence.
inline std::vector<GoalId> draw_starts(std::vector<GoalId> squares, std::size_t count, Random& random) {
  for (std::size_t i = squares.size(); i > 1; --i) std::swap(squares[i - 1], squares[random.below(i)]);
  squares.resize(std::min(count, squares.size()));
  return squares;
}

/// @param per_step  new loads in each step; 0: all at once
inline DeliveryInstance draw_deliveries(const Grid& grid, std::size_t vehicles, std::uint32_t loads,
                                        std::uint32_t per_step, std::uint64_t seed) {
  Random random{seed, "deliveries"};
  const auto squares = connected_squares(grid);
  DeliveryInstance instance{draw_starts(squares, vehicles, random), {}, squares};
  for (std::uint32_t id = 0; id < loads; ++id) {
    const GoalId from = squares[random.below(squares.size())];
    GoalId to = from;
    while (to == from) to = squares[random.below(squares.size())];
    instance.deliveries.push_back({id, from, to, per_step == 0 ? 0 : id / per_step});
  }
  return instance;
}

/// A warehouse: blocks of shelves, two squares deep and eight long, with corridors of one square between them.
inline Grid draw_warehouse(std::uint32_t width, std::uint32_t height) {
  Grid grid{width, height, std::vector<std::uint8_t>(std::size_t{width} * height, 1)};
  for (std::uint32_t y = 1; y + 1 < height; ++y)
    for (std::uint32_t x = 1; x + 1 < width; ++x)
      if (y % 3 != 0 && x % 9 != 0) grid.free[y * width + x] = 0;
  return grid;
}

}  // namespace cosiva::fixture
