#include "cosiva/planning/track/track_floor.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/planning/track/swept_area.h"

namespace cosiva::planning {
namespace {

constexpr double same_point_m = 0.01;  // states nearer than this are at one point
constexpr double at_joint_m = 1e-6;
// Sections without waypoint that a move may pass; only a malicious file has more.
constexpr std::size_t sections_max = 256;

/// Calls found(i, j), i < j, for each pair of areas that touch.
template <typename Found>
void each_touching(const std::vector<const SweptArea*>& areas, Found&& found) {
  std::vector<std::uint32_t> order(areas.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return areas[i]->x_min_m(); });
  for (std::size_t a = 0; a < order.size(); ++a)
    for (std::size_t b = a + 1; b < order.size() && areas[order[b]]->x_min_m() <= areas[order[a]]->x_max_m(); ++b)
      if (areas[order[a]]->touches(*areas[order[b]])) found(std::min(order[a], order[b]), std::max(order[a], order[b]));
}

/// Cells that a move needs, in ascending order.
std::vector<CellId> cells_of(const Floor& floor, StateId from, StateId to) {
  std::vector<CellId> cells;
  for (const auto& some : {floor.footprint(from), floor.footprint(to), floor.sweep_between(from, to)})
    cells.insert(cells.end(), some.begin(), some.end());
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

}  // namespace

/// Makes the description of a zone's floor. Invariant: `states_` are sorted by section and s, `moves_` by their first
/// state.
class TrackFloor::Builder {
 public:
  explicit Builder(const zone::TrafficZone& zone) : zone_{zone} {}

  [[nodiscard]] TrackFloor build();

 private:
  void lay_states();
  void lay_moves();
  void follow(StateId from, zone::SectionId section, std::vector<zone::SectionId>& sections);
  [[nodiscard]] std::optional<StateId> first_on(zone::SectionId section) const;
  [[nodiscard]] std::optional<StateId> first_beyond_start(zone::SectionId section) const;
  void find_cells();
  [[nodiscard]] std::vector<StateId> find_points() const;
  void drive(Move& move) const;
  void find_clear(const Floor& floor);
  void add_sweeps(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& touching);
  [[nodiscard]] bool have_common_cell(StateId a, StateId b) const;
  [[nodiscard]] std::vector<StateId> states_at(Point2 point) const;
  /// Of each of two bodies: together they are the zone's clearance, with which its stop lines were laid.
  [[nodiscard]] double margin_m() const { return 0.5 * zone_.clearance_m; }
  [[nodiscard]] double end_m(zone::SectionId section) const { return zone_.circuit.section(section).length_m(); }
  [[nodiscard]] SweptArea empty_area() const { return SweptArea{zone_.vehicle, margin_m()}; }

  const zone::TrafficZone& zone_;
  std::vector<zone::TrackPosition> states_;
  std::vector<SweptArea> areas_;
  std::vector<Move> moves_;
  FloorDescription description_;
};

// --- states and moves -----------------------------------------------------------------------------------------------

void TrackFloor::Builder::lay_states() {
  const zone::Circuit& circuit = zone_.circuit;
  std::vector<bool> joint(circuit.size(), false);
  for (const zone::Waypoint& waypoint : zone_.waypoints) {
    const zone::TrackPosition at = waypoint.position;
    if (at.s_m > at_joint_m) {
      if (at.s_m < end_m(at.section) - at_joint_m)
        states_.push_back(at);
      else
        joint[at.section] = true;
      continue;
    }
    for (const zone::SectionId before : circuit.previous(at.section)) joint[before] = true;
    states_.push_back({at.section, 0.0});
  }
  for (zone::SectionId section = 0; section < circuit.size(); ++section)
    if (joint[section]) states_.push_back({section, end_m(section)});
  std::ranges::sort(states_, {}, [](const zone::TrackPosition& at) { return std::pair{at.section, at.s_m}; });
}

std::optional<StateId> TrackFloor::Builder::first_on(zone::SectionId section) const {
  const auto first = std::ranges::lower_bound(states_, std::pair{section, 0.0}, {}, [](const zone::TrackPosition& at) {
    return std::pair{at.section, at.s_m};
  });
  if (first == states_.end() || first->section != section) return std::nullopt;
  return static_cast<StateId>(first - states_.begin());
}

std::optional<StateId> TrackFloor::Builder::first_beyond_start(zone::SectionId section) const {
  const auto first = first_on(section);
  if (!first || states_[*first].s_m > 0.0) return first;
  const StateId second = *first + 1;
  return second < states_.size() && states_[second].section == section ? std::optional{second} : std::nullopt;
}

void TrackFloor::Builder::lay_moves() {
  std::vector<zone::SectionId> sections;
  for (StateId from = 0; from < states_.size(); ++from) {
    if (from + 1 < states_.size() && states_[from + 1].section == states_[from].section) {
      moves_.push_back({from, from + 1, {}, 0.0, 0.0, empty_area(), {}, {}});
      continue;
    }
    for (const zone::SectionId next : zone_.circuit.next(states_[from].section)) follow(from, next, sections);
  }
}

void TrackFloor::Builder::follow(StateId from, zone::SectionId section, std::vector<zone::SectionId>& sections) {
  if (sections.size() >= sections_max || std::ranges::find(sections, section) != sections.end()) return;
  sections.push_back(section);
  if (const auto to = first_beyond_start(section)) {
    // Of several moves to the same state the one found first is the usual one: default successors come first.
    bool known = false;
    for (auto move = moves_.rbegin(); move != moves_.rend() && move->from == from && !known; ++move)
      known = move->to == *to;
    if (!known && *to != from) moves_.push_back({from, *to, sections, 0.0, 0.0, empty_area(), {}, {}});
  } else {
    for (const zone::SectionId next : zone_.circuit.next(section)) follow(from, next, sections);
  }
  sections.pop_back();
}

// --- cells ----------------------------------------------------------------------------------------------------------

/// Determines the move's area and length.
void TrackFloor::Builder::drive(Move& move) const {
  const zone::Circuit& circuit = zone_.circuit;
  const auto add_drive = [&](zone::SectionId section, double from_m, double to_m) {
    const std::size_t before = move.area.poses();
    move.area.add_drive(circuit, section, from_m, to_m);
    const auto steps = static_cast<double>(move.area.poses() - before - 1);
    for (std::size_t i = before; i < move.area.poses(); ++i)
      move.driven_m.push_back(move.length_m + (to_m - from_m) * static_cast<double>(i - before) / steps);
    move.length_m += to_m - from_m;
    move.sections_m.push_back(to_m - from_m);
  };
  zone::TrackPosition at = states_[move.from];
  for (const zone::SectionId section : move.sections) {
    add_drive(at.section, at.s_m, end_m(at.section));
    move.area.add_turn(circuit.pose_at({at.section, end_m(at.section)}), circuit.turn_at(at.section, section));
    move.driven_m.resize(move.area.poses(), move.length_m);
    at = {section, 0.0};
  }
  add_drive(at.section, at.s_m, states_[move.to].s_m);
}

void TrackFloor::Builder::find_clear(const Floor& floor) {
  std::vector<std::vector<StateId>> states(floor.cells());
  std::vector<std::vector<std::uint32_t>> moves(floor.cells());
  for (StateId state = 0; state < floor.states(); ++state)
    for (const CellId cell : floor.footprint(state)) states[cell].push_back(state);
  for (std::uint32_t i = 0; i < moves_.size(); ++i)
    for (const CellId cell : cells_of(floor, moves_[i].from, moves_[i].to)) moves[cell].push_back(i);
  for (Move& move : moves_) {
    auto rest = cells_of(floor, move.to, move.to);
    const auto sweep = floor.sweep_between(move.from, move.to);
    rest.insert(rest.end(), sweep.begin(), sweep.end());
    std::ranges::sort(rest);
    const auto needs_rest = [&](std::span<const CellId> cells) {
      return std::ranges::any_of(cells, [&](CellId cell) { return std::ranges::binary_search(rest, cell); });
    };
    // Of what needs a cell that is left, and none of the rest: the last pose of the move at which bodies could touch.
    std::size_t clear = 0;
    const auto consider = [&](std::span<const CellId> cells, const SweptArea& area) {
      if (needs_rest(cells)) return;
      if (const auto last = move.area.last_touching(area)) clear = std::max(clear, *last + 1);
    };
    for (const CellId cell : floor.footprint(move.from)) {
      if (std::ranges::binary_search(rest, cell)) continue;
      for (const StateId state : states[cell]) consider(floor.footprint(state), areas_[state]);
      for (const std::uint32_t i : moves[cell]) consider(cells_of(floor, moves_[i].from, moves_[i].to), moves_[i].area);
    }
    move.clear_m = clear < move.driven_m.size() ? move.driven_m[clear] : move.length_m;
  }
}

/// For each state the first one at the same point, whose number is the point's cell.
std::vector<StateId> TrackFloor::Builder::find_points() const {
  std::vector<StateId> first_at_point;
  for (const zone::TrackPosition& at : states_)
    first_at_point.push_back(states_at(cosiva::position(zone_.circuit.pose_at(at))).front());
  return first_at_point;
}

void TrackFloor::Builder::find_cells() {
  for (const zone::TrackPosition& at : states_) {
    areas_.push_back(empty_area());
    areas_.back().add_pose(zone_.circuit.pose_at(at));
  }
  for (Move& move : moves_) drive(move);
  std::vector<const SweptArea*> areas;
  for (const SweptArea& area : areas_) areas.push_back(&area);
  for (const Move& move : moves_) areas.push_back(&move.area);
  const auto point_of = find_points();
  for (const StateId point : point_of) description_.states.push_back({{point}, {}});
  description_.cells = static_cast<CellId>(states_.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touching;
  each_touching(areas, [&](std::uint32_t a, std::uint32_t b) { touching.emplace_back(a, b); });
  std::ranges::sort(touching);
  for (const auto& [a, b] : touching) {
    if (b >= states_.size() || point_of[a] == point_of[b]) continue;
    for (const StateId state : {a, b}) description_.states[state].footprint.push_back(description_.cells);
    ++description_.cells;
  }
  for (auto& state : description_.states) std::ranges::sort(state.footprint);
  for (const Move& move : moves_) description_.states[move.from].moves.push_back({move.to, {}});
  add_sweeps(touching);
}

bool TrackFloor::Builder::have_common_cell(StateId a, StateId b) const {
  const auto& other = description_.states[b].footprint;
  return std::ranges::any_of(description_.states[a].footprint,
                             [&](CellId cell) { return std::ranges::binary_search(other, cell); });
}

void TrackFloor::Builder::add_sweeps(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& touching) {
  const auto states = static_cast<std::uint32_t>(states_.size());
  std::vector<std::size_t> index_in_state(moves_.size());
  for (std::size_t i = 1; i < moves_.size(); ++i)
    index_in_state[i] = moves_[i].from == moves_[i - 1].from ? index_in_state[i - 1] + 1 : 0;
  const auto add = [&](std::uint32_t move, CellId cell) {
    description_.states[moves_[move].from].moves[index_in_state[move]].sweep.push_back(cell);
  };
  for (const auto& [a, b] : touching) {
    if (b < states) continue;
    const Move& move = moves_[b - states];
    if (a < states) {
      // A body at `a` obstructs the move, unless it would be at one of the move's ends, too.
      if (!have_common_cell(a, move.from) && !have_common_cell(a, move.to))
        add(b - states, description_.states[a].footprint.front());
      continue;
    }
    // Two moves: where one begins or ends where the other does, footprints and the order of the vehicles suffice.
    const Move& other = moves_[a - states];
    if (have_common_cell(move.from, other.from) || have_common_cell(move.to, other.to) ||
        have_common_cell(move.to, other.from) || have_common_cell(move.from, other.to))
      continue;
    add(a - states, description_.cells);
    add(b - states, description_.cells);
    ++description_.cells;
  }
}

// --- goals ----------------------------------------------------------------------------------------------------------

std::vector<StateId> TrackFloor::Builder::states_at(Point2 point) const {
  std::vector<StateId> found;
  std::vector<zone::Circuit::Located> near;
  zone_.circuit.near(point, same_point_m, near);
  for (const auto& located : near) {
    for (StateId state = first_on(located.position.section).value_or(static_cast<StateId>(states_.size()));
         state < states_.size() && states_[state].section == located.position.section; ++state)
      if (distance(cosiva::position(zone_.circuit.pose_at(states_[state])), point) <= same_point_m)
        found.push_back(state);
  }
  std::ranges::sort(found);
  return found;
}

TrackFloor TrackFloor::Builder::build() {
  lay_states();
  lay_moves();
  find_cells();
  std::map<std::string, GoalId, std::less<>> goals;
  const auto add = [&](const std::string& name, zone::TrackPosition at) {
    if (goals.contains(name)) return;
    auto states = states_at(cosiva::position(zone_.circuit.pose_at(at)));
    if (states.empty()) return;
    goals.emplace(name, static_cast<GoalId>(description_.goals.size()));
    description_.goals.push_back(std::move(states));
  };
  for (const zone::Station& station : zone_.stations) add(station.name, station.position);
  for (const zone::Waypoint& waypoint : zone_.waypoints) add(waypoint.id, waypoint.position);
  auto floor = Floor::make(description_);
  COSIVA_EXPECT(floor.has_value());
  find_clear(*floor);
  TrackFloor made{*std::move(floor), zone_.vehicle, margin_m()};
  made.states_ = std::move(states_);
  made.areas_ = std::move(areas_);
  made.moves_.resize(made.states_.size());
  for (Move& move : moves_) made.moves_[move.from].push_back(std::move(move));
  made.goals_ = std::move(goals);
  COSIVA_EXPECT(made.states_.size() == made.floor_.states());
  return made;
}

// --- the finished floor ---------------------------------------------------------------------------------------------

TrackFloor TrackFloor::make(const zone::TrafficZone& zone) { return Builder{zone}.build(); }

const TrackFloor::Move& TrackFloor::move(StateId from, StateId to) const {
  const auto move = std::ranges::find(moves_[from], to, &Move::to);
  COSIVA_EXPECT(move != moves_[from].end());
  return *move;
}

std::span<const zone::SectionId> TrackFloor::sections(StateId from, StateId to) const {
  return move(from, to).sections;
}

double TrackFloor::length_m(StateId from, StateId to) const { return move(from, to).length_m; }

double TrackFloor::clear_m(StateId from, StateId to) const { return move(from, to).clear_m; }

std::optional<double> TrackFloor::driven_m(StateId from, StateId to, zone::TrackPosition position) const {
  const Move& driven = move(from, to);
  const zone::TrackPosition begin = states_[from];
  if (position.section == begin.section && position.s_m >= begin.s_m) return position.s_m - begin.s_m;
  double before_m = 0.0;
  for (std::size_t i = 0; i < driven.sections.size(); ++i) {
    before_m += driven.sections_m[i];
    if (driven.sections[i] == position.section) return before_m + position.s_m;
  }
  return std::nullopt;
}

std::vector<FloorMove> TrackFloor::moves_into(std::span<const zone::SectionId> sections) const {
  const auto is_one = [&](zone::SectionId section) { return std::ranges::find(sections, section) != sections.end(); };
  std::vector<FloorMove> found;
  for (const auto& from_state : moves_)
    for (const Move& move : from_state)
      if (std::ranges::any_of(move.sections, is_one)) found.push_back({move.from, move.to});
  return found;
}

Obstruction TrackFloor::obstructed(const SweptArea& area) const {
  Obstruction found;
  for (StateId state = 0; state < states_.size(); ++state) {
    // The first cell of a state is its point's: no body at another point has it.
    if (areas_[state].touches(area)) found.cells.push_back(floor_.footprint(state).front());
    for (const Move& move : moves_[state])
      if (move.area.touches(area)) found.moves.push_back({move.from, move.to});
  }
  std::ranges::sort(found.cells);
  found.cells.erase(std::unique(found.cells.begin(), found.cells.end()), found.cells.end());
  return found;
}

StateId TrackFloor::first_on(zone::SectionId section) const {
  return static_cast<StateId>(std::ranges::lower_bound(states_, section, {}, &zone::TrackPosition::section) -
                              states_.begin());
}

std::optional<StateId> TrackFloor::state_at(zone::TrackPosition position, double tolerance_m) const {
  std::optional<StateId> best;
  double best_m = tolerance_m;
  for (StateId state = first_on(position.section); is_on(state, position.section); ++state) {
    const double apart_m = std::fabs(states_[state].s_m - position.s_m);
    if (apart_m > best_m) continue;
    best = state;
    best_m = apart_m;
  }
  return best;
}

std::optional<StateId> TrackFloor::state_before(zone::TrackPosition position) const {
  std::optional<StateId> last;
  for (StateId state = first_on(position.section); is_on(state, position.section); ++state)
    if (states_[state].s_m <= position.s_m) last = state;
  return last;
}

std::optional<StateId> TrackFloor::state_after(zone::TrackPosition position,
                                               std::span<const zone::SectionId> remaining) const {
  for (std::size_t i = 0;; ++i) {
    for (StateId state = first_on(position.section); is_on(state, position.section); ++state)
      if (states_[state].s_m >= position.s_m) return state;
    if (i == remaining.size()) return std::nullopt;
    position = {remaining[i], 0.0};
  }
}

std::optional<GoalId> TrackFloor::goal(std::string_view name) const {
  const auto found = goals_.find(name);
  return found == goals_.end() ? std::nullopt : std::optional{found->second};
}

}  // namespace cosiva::planning
