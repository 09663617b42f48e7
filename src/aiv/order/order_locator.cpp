#include "cosiva/aiv/order/order_locator.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace cosiva::aiv {
namespace {

/// Distance from the first node within which a vehicle counts as located at it when the order states no deviation.
constexpr double first_node_m = 0.10;
/// Tolerance of the distances along a route to different positions of one node.
constexpr double same_path_m = 1e-3;
/// Another position of the vehicle counts only when the route from there is shorter by more than this.
constexpr double same_position_m = 0.10;

std::string named(const wire::OrderNode& node) { return "node '" + node.node_id + "'"; }

}  // namespace

Result<LocatedOrder> OrderLocator::locate(const wire::Order& order, const std::vector<zone::TrackPosition>& firsts,
                                          zone::TrackPosition now, std::span<const zone::TrackPosition> also) const {
  auto best = locate_from(order, firsts, now);
  for (const zone::TrackPosition position : also) {
    auto found = locate_from(order, firsts, position);
    if (found && (!best || found->route.length_m() + same_position_m < best->route.length_m())) best = std::move(found);
  }
  return best;
}

Result<LocatedOrder> OrderLocator::locate_from(const wire::Order& order, const std::vector<zone::TrackPosition>& firsts,
                                               zone::TrackPosition now) const {
  std::optional<LocatedOrder> best;
  std::optional<Error> why;
  for (const zone::TrackPosition first : firsts) {
    auto route = router_.route(order, first);
    const auto vehicle_m = route ? distance_from_first_node(order.nodes.front(), *route, now)
                                 : Result<double>{tl::unexpected(route.error())};
    if (!vehicle_m) {
      // The error of a route that starts elsewhere is more specific than the lack of a route.
      if (!why || route) why = vehicle_m.error();
      continue;
    }
    const double nearer_m = best ? std::fabs(best->vehicle_m) - std::fabs(*vehicle_m) : 1.0;
    const bool as_near = std::fabs(nearer_m) <= same_path_m;
    if (as_near ? route->length_m() < best->route.length_m() - same_path_m : nearer_m > 0.0)
      best = LocatedOrder{std::move(*route), *vehicle_m, now};
  }
  if (!best) return tl::unexpected(std::move(*why));
  return std::move(*best);
}

std::vector<zone::TrackPosition> OrderLocator::positions_like(zone::TrackPosition found,
                                                              const wire::Order& order) const {
  std::vector<zone::TrackPosition> positions{found};
  if (router_.one_way()) return positions;
  const auto others = router_.first_positions(order);
  if (!others) return positions;
  for (const zone::TrackPosition other : *others)
    if (!(other == found)) positions.push_back(other);
  return positions;
}

Result<Continuation> OrderLocator::continuation(const wire::Order& order, const BaseEnd& base_end) const {
  std::optional<OrderRoute> best;
  std::optional<zone::Circuit::Route> best_route;
  std::optional<Error> why;
  for (const zone::TrackPosition position : positions_like(base_end.position, order)) {
    const bool same = position == base_end.position;
    auto found_route =
        same ? std::nullopt : router_.shortest_route(base_end.before, position, base_end.edge_m + same_path_m);
    // Another position of the node, equally far along the base: that of another branch out of it.
    if (!same && (!found_route || found_route->length_m < base_end.edge_m - same_path_m)) continue;
    auto route = router_.route(order, position);
    if (!route) {
      if (!why) why = std::move(route.error());
      continue;
    }
    if (best && best->length_m() <= route->length_m() + same_path_m) continue;
    best = std::move(*route);
    best_route = std::move(found_route);
  }
  if (!best) return tl::unexpected(std::move(*why));
  return Continuation{std::move(*best), std::move(best_route)};
}

Result<double> OrderLocator::distance_from_first_node(const wire::OrderNode& node, const OrderRoute& route,
                                                      zone::TrackPosition now) const {
  const double deviation_m =
      std::max(first_node_m, node.position ? node.position->allowed_deviation_xy_m.value_or(0.0) : 0.0);
  // Behind the vehicle the whole first edge counts: a vehicle on this edge has passed the node.
  const double first_edge_m = route.legs.empty() ? 0.0 : route.legs.front().length_m;
  const double longest_m = router_.longest_m();
  const auto beyond_m = zone_.circuit.distance_ahead(
      route.first, now, std::min(longest_m, std::max(deviation_m, first_edge_m)), route.sections());
  const auto before = router_.shortest_route(now, route.first, std::min(longest_m, deviation_m));
  if (before && (!beyond_m || before->length_m < *beyond_m)) return -before->length_m;
  if (beyond_m) return *beyond_m;
  return fail("noRouteError", named(node) + " is not where the vehicle is: neither on it within " +
                                  std::to_string(deviation_m) + " m nor on the edge behind it");
}

}  // namespace cosiva::aiv
