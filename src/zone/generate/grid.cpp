#include "cosiva/zone/generate/grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/zone/generate/floor.h"
#include "cosiva/zone/generate/generated_text.h"

namespace cosiva::zone {
namespace {

constexpr std::size_t sections_max = 200'000;
constexpr double pitch_max_m = 1000.0;
constexpr std::string_view made_by = "# Made by `cosiva zone generate`; docs/guide/zones.md explains every field.\n";

tl::unexpected<Error> out_of_range(std::string what) { return fail("generate.options", std::move(what)); }

/// "A", "B", … "Z", "AA", "AB", …
std::string column_name(std::uint32_t column) {
  std::string name;
  for (std::uint32_t left = column + 1; left > 0; left = (left - 1) / 26)
    name.insert(name.begin(), static_cast<char>('A' + (left - 1) % 26));
  return name;
}

std::string plural(std::uint32_t count, std::string_view what) {
  return std::to_string(count) + " " + std::string{what} + (count == 1 ? "" : "s");
}

/// Indices from 0 to `size`, each once, so that the first few of them are spread over all: steps of about the golden
/// ratio.
std::vector<std::size_t> spread_over(std::size_t size, std::uint64_t first) {
  std::size_t step = std::max<std::size_t>(1, static_cast<std::size_t>(0.618 * static_cast<double>(size)));
  while (std::gcd(step, size) != 1) ++step;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < size; ++i) order.push_back((first + i * step) % size);
  return order;
}

void add_starts(Floor& floor, const std::vector<Floor::Node>& nodes, std::uint32_t starts, Random& random) {
  std::uint32_t count = 0;
  for (const std::size_t i : spread_over(nodes.size(), random.below(nodes.size()))) {
    if (count == starts) return;
    if (floor.add_start(nodes[i])) ++count;
  }
}

Result<void> check_common(double pitch_m, const VehicleShape& vehicle, const std::string& name) {
  if (auto checked = check_vehicle_and_name(vehicle, name); !checked) return checked;
  const double room_m = std::ceil(100.0 * node_room_m(vehicle)) / 100.0;
  if (pitch_m >= room_m && pitch_m <= pitch_max_m) return {};
  return out_of_range("expected a pitch of " + text_of(room_m) + " m to " + text_of(pitch_max_m) +
                      " m: two vehicles of " + text_of(vehicle.length_m) + " m by " + text_of(vehicle.width_m) +
                      " m turn on the spot at neighbouring nodes");
}

/// Where a bay may be: a node of the border, and the direction outward.
struct Outward {
  Floor::Node node;
  double heading_rad;
};

/// Lays a grid. Invariant: `nodes_` has the node of column c and row r at r · columns + c.
class Grid {
 public:
  explicit Grid(const GridOptions& options)
      : options_{options}, floor_{options.vehicle}, random_{options.seed, "zone/generate/grid"} {}

  std::string text();

 private:
  [[nodiscard]] Floor::Node node(std::uint32_t column, std::uint32_t row) const {
    return nodes_[std::size_t{row} * options_.columns + column];
  }
  void lay_nodes();
  void lay_tracks();
  void lay_track(Floor::Node from, Floor::Node to, bool forward);
  [[nodiscard]] std::vector<Outward> outward() const;
  [[nodiscard]] std::vector<Floor::Node> border() const;
  [[nodiscard]] std::string comment() const;

  const GridOptions& options_;
  Floor floor_;
  Random random_;
  std::vector<Floor::Node> nodes_;
};

void Grid::lay_nodes() {
  for (std::uint32_t row = 0; row < options_.rows; ++row)
    for (std::uint32_t column = 0; column < options_.columns; ++column)
      nodes_.push_back(floor_.add_node(column_name(column) + std::to_string(row + 1),
                                       {column * options_.pitch_m, row * options_.pitch_m}));
  COSIVA_EXPECT(nodes_.size() == std::size_t{options_.columns} * options_.rows);
}

void Grid::lay_track(Floor::Node from, Floor::Node to, bool forward) {
  if (!forward) std::swap(from, to);
  floor_.add_track(from, to, options_.two_way ? Floor::Directions::both : Floor::Directions::one);
}

/// One-way rows and columns reach every node where those at the border form a circuit, here an anticlockwise one.
void Grid::lay_tracks() {
  for (std::uint32_t row = 0; row < options_.rows; ++row) {
    for (std::uint32_t column = 0; column < options_.columns; ++column) {
      const bool east = options_.two_way || (row % 2 == 0 && (row == 0 || row + 1 < options_.rows));
      const bool north = options_.two_way || column % 2 == 1 || column + 1 == options_.columns;
      if (column + 1 < options_.columns) lay_track(node(column, row), node(column + 1, row), east);
      if (row + 1 < options_.rows) lay_track(node(column, row), node(column, row + 1), north);
    }
  }
}

/// Anticlockwise from the south-west; a corner has two directions outward.
std::vector<Outward> Grid::outward() const {
  const std::uint32_t east = options_.columns - 1;
  const std::uint32_t north = options_.rows - 1;
  std::vector<Outward> all;
  for (std::uint32_t column = 0; column <= east; ++column) all.push_back({node(column, 0), -0.5 * pi});
  for (std::uint32_t row = 0; row <= north; ++row) all.push_back({node(east, row), 0.0});
  for (std::uint32_t column = east + 1; column-- > 0;) all.push_back({node(column, north), 0.5 * pi});
  for (std::uint32_t row = north + 1; row-- > 0;) all.push_back({node(0, row), pi});
  return all;
}

/// Each node of the border once, in the order of outward().
std::vector<Floor::Node> Grid::border() const {
  std::vector<Floor::Node> all;
  for (const Outward& at : outward())
    if (std::ranges::find(all, at.node) == all.end()) all.push_back(at.node);
  return all;
}

std::string Grid::comment() const {
  std::string text = "# A grid of " + plural(options_.columns, "column") + " and " + plural(options_.rows, "row") +
                     " of nodes: " + text_of(options_.pitch_m) + " m apart, joined by ";
  text += options_.two_way ? "two-way" : "one-way";
  return text + " tracks, with " + plural(options_.bays, "bay") + " at the border, seed " +
         std::to_string(options_.seed) + ".\n" + std::string{made_by};
}

std::string Grid::text() {
  lay_nodes();
  lay_tracks();
  if (options_.bays > 0) {
    const auto outsides = outward();
    const std::size_t first = random_.below(outsides.size());
    for (std::size_t i = 0; i < options_.bays; ++i) {
      const Outward& at = outsides[(first + i * outsides.size() / options_.bays) % outsides.size()];
      floor_.add_bay(at.node, "bay" + std::to_string(i + 1), at.heading_rad);
    }
  } else {
    auto nodes = border();
    // In a corridor a vehicle at a station between the ends would part the others.
    if (options_.columns == 1 || options_.rows == 1) nodes = {nodes.front(), nodes.front(), nodes.back()};
    for (std::size_t i = 0; i < nodes.size(); i += 2) floor_.add_station(nodes[i], "S" + std::to_string(i / 2 + 1));
  }
  add_starts(floor_, nodes_, options_.starts, random_);
  return floor_.text(options_.name, comment());
}

}  // namespace

Result<std::string> generate_grid(const GridOptions& options) {
  const std::size_t columns = options.columns;
  const std::size_t rows = options.rows;
  if (columns < 1 || columns > 1000 || rows < 1 || rows > 1000)
    return out_of_range("expected a grid of 1 to 1000 columns and 1 to 1000 rows");
  if (columns * rows < 2) return out_of_range("expected a grid of at least two nodes");
  if (!options.two_way && (columns < 2 || rows < 2))
    return out_of_range("a single row of one-way tracks cannot be driven back; expected two-way tracks");
  if (auto checked = check_common(options.pitch_m, options.vehicle, options.name); !checked)
    return tl::unexpected(std::move(checked).error());
  if (options.bays > 2 * (columns + rows))
    return out_of_range("this grid has room for at most " + std::to_string(2 * (columns + rows)) +
                        " bays at its border");
  const std::size_t tracks = columns * (rows - 1) + rows * (columns - 1);
  const double sections = static_cast<double>((options.two_way ? 2 : 1) * tracks) *
                              static_cast<double>(Floor{options.vehicle}.parts_of(options.pitch_m)) +
                          2.0 * options.bays;
  if (sections > static_cast<double>(sections_max))
    return out_of_range("these columns, rows and pitch make " + text_of(sections) + " sections; expected at most " +
                        std::to_string(sections_max));
  return Grid{options}.text();
}

Result<std::string> generate_loop(const LoopOptions& options) {
  if (options.nodes < 3 || options.nodes > 10'000) return out_of_range("expected a loop of 3 to 10000 nodes");
  if (auto checked = check_common(options.pitch_m, options.vehicle, options.name); !checked)
    return tl::unexpected(std::move(checked).error());
  if (options.bays > options.nodes)
    return out_of_range("this loop has room for at most " + std::to_string(options.nodes) + " bays, one at each node");
  Floor floor{options.vehicle};
  const double turn_rad = 2.0 * pi / options.nodes;
  const double radius_m = options.pitch_m / turn_rad;
  if (2.0 * radius_m * det_sin(0.5 * turn_rad) < node_room_m(options.vehicle))
    return out_of_range("in so small a loop vehicles touch at neighbouring nodes; expected a greater pitch");
  if (static_cast<double>(2 * options.nodes) * static_cast<double>(floor.parts_of(options.pitch_m)) >
      static_cast<double>(sections_max))
    return out_of_range("these nodes and this pitch make too many sections; expected at most " +
                        std::to_string(sections_max));

  Random random{options.seed, "zone/generate/loop"};
  std::vector<Floor::Node> nodes;
  for (std::uint32_t i = 0; i < options.nodes; ++i) {
    const SinCos at = sincos(turn_rad * i);
    nodes.push_back(floor.add_node("L" + std::to_string(i + 1), {radius_m * at.cos, radius_m * at.sin}));
  }
  for (std::uint32_t i = 0; i < options.nodes; ++i)
    floor.add_track(nodes[i], nodes[(i + 1) % options.nodes], Floor::Directions::both, turn_rad);
  const std::size_t first = random.below(options.nodes);
  for (std::size_t i = 0; i < options.bays; ++i) {
    const std::size_t at = (first + i * options.nodes / options.bays) % options.nodes;
    floor.add_bay(nodes[at], "bay" + std::to_string(i + 1), wrap_angle(turn_rad * static_cast<double>(at)));
  }
  if (options.bays == 0)
    for (std::size_t i = 0; i + 1 < nodes.size(); i += 2) floor.add_station(nodes[i], "S" + std::to_string(i / 2 + 1));
  if (options.bays == 0 && nodes.size() == 3) floor.add_station(nodes[2], "S2");
  add_starts(floor, nodes, options.starts, random);
  return floor.text(options.name, "# A loop of " + plural(options.nodes, "node") + ": " + text_of(options.pitch_m) +
                                      " m apart, driven both ways, with " + plural(options.bays, "bay") +
                                      " outside it, seed " + std::to_string(options.seed) + ".\n" +
                                      std::string{made_by});
}

}  // namespace cosiva::zone
