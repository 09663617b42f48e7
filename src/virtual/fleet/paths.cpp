#include "cosiva/virtual/fleet/paths.h"

namespace cosiva::virtual_side {

Paths::Paths(const FleetTables& tables) : ground_{tables.ground}, state_{tables.state}, routes_{tables.routes} {}

Paths::Path Paths::path_of(std::uint32_t i) const {
  const std::uint32_t route = state_.own[i].route;
  if (route == Fleet::none) return {state_.section[i], 0, {}, false};
  return {state_.section[i], state_.own[i].route_step, routes_[route].sections, (state_.mode[i] & Mode::sent) != 0};
}

zone::SectionId Paths::next(const Path& path) const {
  if (path.ends && path.step + 1 >= path.route.size()) return zone::no_section;
  return beyond(path);
}

zone::SectionId Paths::beyond(const Path& path) const {
  return path.step + 1 < path.route.size() ? path.route[path.step + 1] : ground_.default_next(path.section);
}

void Paths::advance(Path& path, zone::SectionId section) {
  path.section = section;
  ++path.step;
}

}  // namespace cosiva::virtual_side
