#include "cosiva/aiv/order/order_route.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "cosiva/aiv/motion/outlook.h"

namespace cosiva::aiv {
namespace {

/// Largest distance from the circuit at which a node with an unknown id is located on the circuit.
constexpr double node_off_circuit_m_max = 0.25;
/// Sections that pass a node equally near (crossings, joints) are distinguished by the route, not by their last
/// millimetre.
constexpr double node_tie_m = 0.05;
/// Largest number of positions that match one node's nodePosition.
constexpr std::size_t positions_max = 16;
/// Tolerance for rounding in a lap's length.
constexpr double lap_rounding_m = 1e-6;

std::string named(const wire::OrderNode& node) { return "node '" + node.node_id + "'"; }

/// A position that a node may refer to, and the best route to it from the first node.
struct Reached {
  zone::TrackPosition position;
  double path_m;
  std::size_t before;  ///< index of the position of the node before
  zone::Circuit::Route route;
};

/// Best of the routes to one position from the positions of the node before. Among equally long routes: the one that
/// passed the node before earlier, because a route over itself (a lap) passes that node twice.
std::optional<Reached> best_route_to(zone::TrackPosition track_position, const std::vector<Reached>& before,
                                     const OrderRouter& router) {
  std::optional<Reached> best;
  for (std::size_t i = 0; i < before.size(); ++i) {
    auto found = router.shortest_route(before[i].position, track_position);
    if (!found) continue;
    const double path_m = before[i].path_m + found->length_m;
    const double ahead_m = best ? best->path_m - path_m : 1.0;
    const bool earlier = best && before[i].path_m < before[best->before].path_m;
    if (ahead_m > lap_rounding_m || (ahead_m > -lap_rounding_m && earlier))
      best = Reached{track_position, path_m, i, std::move(*found)};
  }
  return best;
}

}  // namespace

double OrderRoute::length_m() const {
  double total_m = 0.0;
  for (const Leg& leg : legs) total_m += leg.length_m;
  return total_m;
}

std::vector<zone::SectionId> OrderRoute::sections() const {
  std::vector<zone::SectionId> all;
  for (const Leg& leg : legs) all.insert(all.end(), leg.via.begin(), leg.via.end());
  return all;
}

OrderRouter::OrderRouter(const zone::TrafficZone& zone)
    : zone_{zone}, longest_m_{zone.circuit.total_length_m() + lap_rounding_m}, one_way_{one_way_only(zone.circuit)} {}

Result<std::vector<zone::TrackPosition>> OrderRouter::positions_of(const wire::OrderNode& node) const {
  const auto& at = node.position;
  if (at && !at->map_id.empty() && at->map_id != zone_.name) {
    return fail("noRouteError", named(node) + " is on map '" + at->map_id + "', the vehicle on '" + zone_.name + "'");
  }
  const auto known = zone_.find_waypoints(node.node_id);
  if (known.empty()) return by_position(node);
  std::vector<zone::TrackPosition> positions;
  for (const std::size_t index : known) {
    const zone::TrackPosition track_position = zone_.waypoints[index].position;
    if (!at || distance(position(zone_.circuit.pose_at(track_position)), {at->x_m, at->y_m}) <= node_off_circuit_m_max)
      positions.push_back(track_position);
  }
  if (positions.empty()) return fail("noRouteError", named(node) + " does not lie at its nodePosition");
  return positions;
}

Result<std::vector<zone::TrackPosition>> OrderRouter::by_position(const wire::OrderNode& node) const {
  const auto& at = node.position;
  if (!at) return fail("noRouteError", named(node) + " is unknown here and has no nodePosition");
  const zone::Circuit& circuit = zone_.circuit;
  std::vector<zone::Circuit::Located> near;
  circuit.near({at->x_m, at->y_m}, node_off_circuit_m_max, near);
  if (at->theta_rad) {
    std::erase_if(near, [&](const zone::Circuit::Located& located) {
      const double heading_rad = body_pose(zone_, circuit.pose_at(located.position)).heading_rad;
      return std::fabs(wrap_angle(heading_rad - *at->theta_rad)) > pi / 2.0;
    });
  }
  if (near.empty()) return fail("noRouteError", named(node) + " does not lie on the circuit");
  std::vector<zone::TrackPosition> positions;
  for (const auto& located : near) {
    if (located.distance_m > near.front().distance_m + node_tie_m || positions.size() == positions_max) break;
    positions.push_back(located.position);
  }
  std::ranges::sort(positions, {}, &zone::TrackPosition::section);
  return positions;
}

void OrderRouter::keep_for_edge(std::vector<zone::TrackPosition>& positions, const wire::OrderEdge* edge) const {
  if (edge == nullptr || !zone_.edges_are_sections || positions.size() < 2) return;
  const auto section = zone_.circuit.find(edge->edge_id);
  if (!section) return;
  const auto on_it = [&](const zone::TrackPosition& track_position) { return track_position.section == *section; };
  if (std::ranges::any_of(positions, on_it)) std::erase_if(positions, std::not_fn(on_it));
}

Result<std::vector<zone::TrackPosition>> OrderRouter::first_positions(const wire::Order& order) const {
  auto positions = positions_of(order.nodes.front());
  if (positions) keep_for_edge(*positions, order.edges.empty() ? nullptr : &order.edges.front());
  return positions;
}

Result<OrderRoute> OrderRouter::route(const wire::Order& order, zone::TrackPosition first) const {
  std::vector<std::vector<Reached>> reached;
  reached.reserve(order.nodes.size());
  reached.push_back({{first, 0.0, 0, {}}});
  for (std::size_t i = 1; i < order.nodes.size(); ++i) {
    auto positions = positions_of(order.nodes[i]);
    if (!positions) return tl::unexpected(std::move(positions.error()));
    keep_for_edge(*positions, i < order.edges.size() ? &order.edges[i] : nullptr);
    std::vector<Reached> here;
    for (const zone::TrackPosition track_position : *positions) {
      if (auto best = best_route_to(track_position, reached.back(), *this)) here.push_back(std::move(*best));
    }
    if (here.empty()) {
      return fail("noRouteError",
                  "no route along the circuit from " + named(order.nodes[i - 1]) + " to " + named(order.nodes[i]));
    }
    reached.push_back(std::move(here));
  }

  OrderRoute route{first, std::vector<OrderRoute::Leg>(order.nodes.size() - 1)};
  const auto& last = reached.back();
  auto at = static_cast<std::size_t>(std::ranges::min_element(last, {}, &Reached::path_m) - last.begin());
  for (std::size_t i = order.nodes.size() - 1; i > 0; --i) {
    Reached& node = reached[i][at];
    auto& via = node.route.sections;
    if (!via.empty()) via.erase(via.begin());
    route.legs[i - 1] = {node.position, node.route.length_m, std::move(via)};
    at = node.before;
  }
  return route;
}

std::optional<zone::Circuit::Route> OrderRouter::shortest_route(zone::TrackPosition from, zone::TrackPosition to,
                                                                double limit_m) const {
  if (!one_way_) return zone_.circuit.shortest_route(from, to, limit_m);
  const auto length_m = zone_.circuit.distance_ahead(from, to, limit_m);
  return length_m ? std::optional{zone::Circuit::Route{*length_m, {}}} : std::nullopt;
}

}  // namespace cosiva::aiv
