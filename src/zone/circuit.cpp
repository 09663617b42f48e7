#include "zone/circuit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/expect.h"

namespace cosiva::zone {
namespace {

std::string metres(double value) {
  std::string text = std::to_string(value);
  return text + " m";
}

std::string place_text(const Pose2& pose) {
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
                 "'" + before.name + "' ends at " + place_text(end) + " but '" + after.name + "' starts at " +
                     place_text(start) + ", " + metres(apart_m) + " away; expected at most " + metres(gap_m),
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

Circuit::Located Circuit::locate(Point2 p, std::optional<double> heading_rad) const {
  COSIVA_EXPECT(!parts_.empty());
  constexpr double far = std::numeric_limits<double>::infinity();
  Located any{{}, 0.0, far};
  Located aligned = any;
  for (SectionId id = 0; id < parts_.size(); ++id) {
    const Section& section = parts_[id].section;
    if (zone::distance(section.box(), p) >= (heading_rad ? aligned : any).distance_m) continue;
    const Section::Nearest near = section.nearest(p);
    const Located here{{id, near.s_m}, near.left_m, near.distance_m};
    if (here.distance_m < any.distance_m) any = here;
    if (!heading_rad || here.distance_m >= aligned.distance_m) continue;
    const double turned_rad = wrap_angle(section.pose_at(near.s_m).heading_rad - *heading_rad);
    if (std::fabs(turned_rad) <= pi / 3.0) aligned = here;
  }
  return aligned.distance_m < far ? aligned : any;
}

double Circuit::turn_at(SectionId from, SectionId to) const {
  const double turned_rad = wrap_angle(section(to).start().heading_rad - section(from).end().heading_rad);
  return std::fabs(turned_rad) <= smooth_rad ? 0.0 : turned_rad;
}

Place Circuit::advance(Place from, double distance_m, std::span<const SectionId> coming,
                       std::span<const SectionId> gone) const {
  COSIVA_EXPECT(from.section < parts_.size() && std::isfinite(distance_m));
  double s = std::clamp(from.s_m, 0.0, section(from.section).length_m()) + distance_m;
  SectionId id = from.section;
  for (std::size_t i = 0; s > section(id).length_m(); ++i) {
    const SectionId after = i < coming.size() ? coming[i] : next(id).empty() ? no_section : next(id).front();
    if (after == no_section) break;
    s -= section(id).length_m();
    id = after;
  }
  for (std::size_t i = gone.size(); s<0.0; i -= i> 0 ? 1 : 0) {
    const SectionId before = i > 0 ? gone[i - 1] : previous(id).empty() ? no_section : previous(id).front();
    if (before == no_section) break;
    id = before;
    s += section(id).length_m();
  }
  return {id, std::clamp(s, 0.0, section(id).length_m())};
}

std::optional<double> Circuit::distance_ahead(Place from, Place to, double limit_m,
                                              std::span<const SectionId> coming) const {
  COSIVA_EXPECT(from.section < parts_.size() && to.section < parts_.size());
  const auto within = [limit_m](double d_m) { return d_m <= limit_m ? std::optional{d_m} : std::nullopt; };
  if (from.section == to.section && to.s_m >= from.s_m) return within(to.s_m - from.s_m);

  double travelled_m = section(from.section).length_m() - from.s_m;  // up to the start of `id`
  SectionId id = from.section;
  // A default way that comes back to a section it has been on never gets anywhere new.
  for (std::size_t steps = 0; steps < coming.size() + parts_.size() && travelled_m <= limit_m; ++steps) {
    if (steps < coming.size())
      id = coming[steps];
    else if (next(id).empty())
      return std::nullopt;
    else
      id = next(id).front();
    if (id == to.section) return within(travelled_m + to.s_m);
    travelled_m += section(id).length_m();
  }
  return std::nullopt;
}

std::optional<Circuit::Way> Circuit::shortest_way(Place from, Place to, double limit_m) const {
  COSIVA_EXPECT(from.section < parts_.size() && to.section < parts_.size());
  if (from.section == to.section && to.s_m >= from.s_m) {
    if (to.s_m - from.s_m > limit_m) return std::nullopt;
    return Way{to.s_m - from.s_m, {from.section}};
  }
  // Dijkstra over the few sections within the limit; an index of those seen, so that nothing of the circuit's size is
  // made.
  struct Reached {
    SectionId section;
    double start_m;  // travelled when it begins
    std::size_t via;
    bool done;
  };
  std::vector<Reached> reached;
  const auto reach = [&](SectionId id, double start_m, std::size_t via) {
    if (start_m > limit_m) return;
    const auto known = std::find_if(reached.begin(), reached.end(), [id](const Reached& r) { return r.section == id; });
    if (known == reached.end())
      reached.push_back({id, start_m, via, false});
    else if (!known->done && start_m < known->start_m)
      *known = {id, start_m, via, false};
  };
  constexpr auto beginning = std::numeric_limits<std::size_t>::max();
  for (const SectionId after : next(from.section)) reach(after, section(from.section).length_m() - from.s_m, beginning);
  for (;;) {
    std::size_t best = beginning;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      if (!reached[i].done && (best == beginning || reached[i].start_m < reached[best].start_m)) best = i;
    }
    if (best == beginning) return std::nullopt;
    reached[best].done = true;
    const SectionId id = reached[best].section;
    if (id == to.section) {
      if (reached[best].start_m + to.s_m > limit_m) return std::nullopt;
      Way way{reached[best].start_m + to.s_m, {}};
      for (std::size_t at = best; at != beginning; at = reached[at].via) way.sections.push_back(reached[at].section);
      way.sections.push_back(from.section);
      std::reverse(way.sections.begin(), way.sections.end());
      return way;
    }
    const double end_m = reached[best].start_m + section(id).length_m();
    for (const SectionId after : next(id)) reach(after, end_m, best);
  }
}

}  // namespace cosiva::zone
