#include "cosiva/zone/circuit/circuit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::zone {
namespace {

std::string metres(double value) {
  std::string text = std::to_string(value);
  return text + " m";
}

std::string position_text(const Pose2& pose) {
  return "(" + std::to_string(pose.x_m) + ", " + std::to_string(pose.y_m) + ")";
}

/// Nothing when `after` starts where `before` ends.
std::optional<Error> check_joint(const Circuit::Part& before, const Circuit::Part& after, double gap_m,
                                 double kink_rad) {
  const Pose2& end = before.section.end();
  const Pose2& start = after.section.start();
  const double apart_m = distance(end, start);
  if (!(apart_m <= gap_m)) {
    return Error{"circuit.gap",
                 "'" + before.name + "' ends at " + position_text(end) + " but '" + after.name + "' starts at " +
                     position_text(start) + ", " + metres(apart_m) + " away; expected at most " + metres(gap_m),
                 before.name};
  }
  const double turned_rad = std::fabs(wrap_angle(start.heading_rad - end.heading_rad));
  if (!before.pivots && !(turned_rad <= kink_rad)) {
    constexpr double degrees = 180.0 / pi;
    return Error{"circuit.kink",
                 "'" + before.name + "' ends with heading " + std::to_string(end.heading_rad * degrees) + "° but '" +
                     after.name + "' starts with " + std::to_string(start.heading_rad * degrees) +
                     "°; expected at most " + std::to_string(kink_rad * degrees) + "° between them",
                 before.name};
  }
  return std::nullopt;
}

}  // namespace

Result<Circuit> Circuit::make(std::string name, std::vector<Part> parts, double gap_m, double kink_rad) {
  if (parts.empty()) return fail("circuit.empty", "a circuit needs at least one section");

  Circuit circuit;
  circuit.name_ = std::move(name);
  circuit.parts_ = std::move(parts);
  const auto& all = circuit.parts_;
  const auto size = static_cast<SectionId>(all.size());

  circuit.by_name_.resize(size);
  for (SectionId id = 0; id < size; ++id) circuit.by_name_[id] = id;
  std::sort(circuit.by_name_.begin(), circuit.by_name_.end(),
            [&](SectionId a, SectionId b) { return all[a].name != all[b].name ? all[a].name < all[b].name : a < b; });
  for (std::size_t i = 1; i < circuit.by_name_.size(); ++i) {
    const std::string& twin = all[circuit.by_name_[i]].name;
    if (all[circuit.by_name_[i - 1]].name == twin)
      return fail("circuit.duplicate", "two sections have the name '" + twin + "'", twin);
  }

  circuit.previous_.resize(size);
  for (SectionId id = 0; id < size; ++id) {
    for (const SectionId after : all[id].next) {
      if (after >= size) {
        return fail("circuit.next",
                    "'" + all[id].name + "' is followed by section number " + std::to_string(after) +
                        ", but there are only " + std::to_string(size),
                    all[id].name);
      }
      if (auto error = check_joint(all[id], all[after], gap_m, kink_rad)) return tl::unexpected(std::move(*error));
      circuit.previous_[after].push_back(id);
    }
  }
  auto pieces = pieces_of(all.size(), [&](std::size_t id) -> const Section& { return all[id].section; });
  circuit.grid_ = SectionGrid{pieces};
  circuit.tree_ = SectionTree{std::move(pieces)};
  return circuit;
}

std::optional<SectionId> Circuit::find(std::string_view section_name) const {
  const auto at = std::lower_bound(by_name_.begin(), by_name_.end(), section_name,
                                   [this](SectionId id, std::string_view name) { return parts_[id].name < name; });
  if (at == by_name_.end() || parts_[*at].name != section_name) return std::nullopt;
  return *at;
}

double Circuit::total_length_m() const {
  double total_m = 0.0;
  for (const Part& part : parts_) total_m += part.section.length_m();
  return total_m;
}

/// Calls look(id) for all sections that head into `headings` and may come within `limit_m`, which `look` may lower; for
/// some sections several times.
template <typename NeighbourVisitor>
void Circuit::survey_neighbours(Point2 p, Headings headings, const double& limit_m,
                                const NeighbourVisitor& visitor) const {
  if (!grid_.visit(p, headings, limit_m, visitor)) tree_.visit(p, headings, limit_m, visitor);
}

Circuit::Located Circuit::locate(Point2 p, std::optional<double> heading_rad) const {
  COSIVA_EXPECT(!parts_.empty());
  constexpr double aligned_rad = pi / 3.0;
  Located best{{}, 0.0, std::numeric_limits<double>::infinity()};
  SectionId last = no_section;  // the pieces of a section come one after the other, mostly
  const auto visitor = [&](SectionId id) {
    if (id == last) return;
    last = id;
    const Section::Nearest near = section(id).nearest(p);
    if (near.distance_m > best.distance_m || (near.distance_m == best.distance_m && id >= best.position.section))
      return;
    if (heading_rad && !(std::fabs(wrap_angle(section(id).heading_at(near.s_m) - *heading_rad)) <= aligned_rad)) return;
    best = {{id, near.s_m}, near.left_m, near.distance_m};
  };
  if (heading_rad) {
    survey_neighbours(p, headings_near(*heading_rad, aligned_rad), best.distance_m, visitor);
    if (best.position.section != no_section) return best;
    heading_rad.reset();
    last = no_section;
  }
  survey_neighbours(p, every_heading, best.distance_m, visitor);
  return best;
}

void Circuit::near(Point2 p, double within_m, std::vector<Located>& out) const {
  out.clear();
  survey_neighbours(p, every_heading, within_m, [&](SectionId id) { out.push_back({{id, 0.0}, 0.0, 0.0}); });
  std::sort(out.begin(), out.end(),
            [](const Located& a, const Located& b) { return a.position.section < b.position.section; });
  const auto same = [](const Located& a, const Located& b) { return a.position.section == b.position.section; };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  for (Located& located : out) {
    const Section::Nearest near = section(located.position.section).nearest(p);
    located = {{located.position.section, near.s_m}, near.left_m, near.distance_m};
  }
  std::erase_if(out, [&](const Located& located) { return !(located.distance_m <= within_m); });
  std::sort(out.begin(), out.end(), [](const Located& a, const Located& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.position.section < b.position.section;
  });
}

double Circuit::turn_at(SectionId from, SectionId to) const {
  const double turned_rad = wrap_angle(section(to).start().heading_rad - section(from).end().heading_rad);
  return std::fabs(turned_rad) <= smooth_rad ? 0.0 : turned_rad;
}

TrackPosition Circuit::advance(TrackPosition from, double distance_m, std::span<const SectionId> remaining,
                               std::span<const SectionId> traversed) const {
  COSIVA_EXPECT(from.section < parts_.size() && std::isfinite(distance_m));
  double s = std::clamp(from.s_m, 0.0, section(from.section).length_m()) + distance_m;
  SectionLookAhead ahead{*this, from.section, remaining};
  for (double length_m = section(from.section).length_m(); s > length_m && ahead.step();) {
    s -= length_m;
    length_m = section(ahead.section()).length_m();
  }
  SectionId id = ahead.section();
  for (std::size_t left = traversed.size(); s < 0.0;) {
    const SectionId before = left > 0 ? traversed[--left] : previous(id).empty() ? no_section : previous(id).front();
    if (before == no_section) break;
    id = before;
    s += section(id).length_m();
  }
  return {id, std::clamp(s, 0.0, section(id).length_m())};
}

std::optional<double> Circuit::distance_ahead(TrackPosition from, TrackPosition to, double limit_m,
                                              std::span<const SectionId> remaining) const {
  COSIVA_EXPECT(from.section < parts_.size() && to.section < parts_.size());
  const auto within = [limit_m](double d_m) { return d_m <= limit_m ? std::optional{d_m} : std::nullopt; };
  if (from.section == to.section && to.s_m >= from.s_m) return within(to.s_m - from.s_m);

  double travelled_m = section(from.section).length_m() - from.s_m;  // up to the start of the next one
  SectionLookAhead ahead{*this, from.section, remaining};
  // A default successor that returns to a visited section never leads anywhere new.
  for (std::size_t steps = 0; steps < remaining.size() + parts_.size() && travelled_m <= limit_m; ++steps) {
    if (!ahead.step()) return std::nullopt;
    if (ahead.section() == to.section) return within(travelled_m + to.s_m);
    travelled_m += section(ahead.section()).length_m();
  }
  return std::nullopt;
}

std::optional<Circuit::Route> Circuit::shortest_route(TrackPosition from, TrackPosition to, double limit_m) const {
  COSIVA_EXPECT(from.section < parts_.size() && to.section < parts_.size());
  if (from.section == to.section && to.s_m >= from.s_m) {
    if (to.s_m - from.s_m > limit_m) return std::nullopt;
    return Route{to.s_m - from.s_m, {from.section}};
  }
  // Most searches have a short limit, and end on the section that they begin on.
  if (!(section(from.section).length_m() - from.s_m <= limit_m)) return std::nullopt;
  // Dijkstra over the few sections within the limit, in a map: nothing of the circuit's size is allocated.
  struct Reached {
    double start_m;  // distance travelled when it begins
    SectionId via;   // from.section's own beginning is not reached, its end is left
    bool done;
  };
  std::map<SectionId, Reached> reached;
  using Entry = std::pair<double, SectionId>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto leave = [&](SectionId id, double end_m, SectionId via) {
    if (!(end_m <= limit_m)) return;
    for (const SectionId after : next(id)) {
      const auto [known, is_new] = reached.try_emplace(after, Reached{end_m, via, false});
      if (!is_new && (known->second.done || end_m >= known->second.start_m)) continue;
      known->second = {end_m, via, false};
      queue.emplace(end_m, after);
    }
  };
  leave(from.section, section(from.section).length_m() - from.s_m, no_section);
  while (!queue.empty()) {
    const auto [start_m, id] = queue.top();
    queue.pop();
    Reached& here = reached.at(id);
    if (here.done) continue;
    here.done = true;
    if (id != to.section) {
      leave(id, start_m + section(id).length_m(), id);
      continue;
    }
    if (start_m + to.s_m > limit_m) return std::nullopt;
    Route route{start_m + to.s_m, {}};
    for (SectionId at = id; at != no_section; at = reached.at(at).via) route.sections.push_back(at);
    route.sections.push_back(from.section);
    std::reverse(route.sections.begin(), route.sections.end());
    return route;
  }
  return std::nullopt;
}

Circuit reversed(const Circuit& circuit, std::string name) {
  std::vector<Circuit::Part> parts;
  parts.reserve(circuit.size());
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const Circuit::Part& part = circuit.part(id);
    const auto before = circuit.previous(id);
    std::vector<SectionId> next{before.begin(), before.end()};
    std::stable_partition(next.begin(), next.end(), [&](SectionId one) { return circuit.next(one).front() == id; });
    const bool pivots = std::any_of(next.begin(), next.end(), [&](SectionId one) { return circuit.part(one).pivots; });
    parts.push_back({part.name, reversed(part.section), part.speed_mps_max, std::move(next), pivots});
  }
  // The joints are those of the circuit, which has been joined within the tolerances of its format.
  constexpr double any = std::numeric_limits<double>::infinity();
  auto made = Circuit::make(std::move(name), std::move(parts), any, any);
  COSIVA_EXPECT(made.has_value());
  made->indirect_ = !circuit.indirect_;
  return std::move(*made);
}

bool is_reversed(const Circuit& a, const Circuit& b) {
  constexpr double same_m = 1e-6;
  if (a.size() != b.size()) return false;
  for (SectionId id = 0; id < a.size(); ++id) {
    const Section& of_a = a.section(id);
    const Section& of_b = b.section(id);
    if (a.part(id).name != b.part(id).name || distance(of_a.start(), of_b.end()) > same_m ||
        distance(of_a.end(), of_b.start()) > same_m || std::fabs(of_a.length_m() - of_b.length_m()) > same_m)
      return false;
  }
  return true;
}

TrackPosition reversed(const Circuit& circuit, TrackPosition position) {
  return {position.section, std::max(0.0, circuit.section(position.section).length_m() - position.s_m)};
}

}  // namespace cosiva::zone
