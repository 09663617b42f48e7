#include "aiv/order_book.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "aiv/order_check.h"

namespace cosiva::aiv {
namespace {

/// A node that we do not know by name is ours when it lies this near to the circuit.
constexpr double node_off_circuit_m_max = 0.25;
/// Ways that pass a node equally near (crossings, joints) are told apart by the way to go, not by their last
/// millimetre.
constexpr double node_tie_m = 0.05;
/// How far from the first node a vehicle still counts as standing on it when the order states no deviation.
constexpr double first_node_m = 0.10;
/// Standing accuracy at the end of the base.
constexpr double arrival_m = 0.015;
/// Room for rounding in a lap's length.
constexpr double lap_rounding_m = 1e-6;

std::string named(const wire::OrderNode& node) { return "node '" + node.node_id + "'"; }

std::string with_sequence(std::string_view node_id, std::uint32_t sequence_id) {
  return "'" + std::string(node_id) + "' (" + std::to_string(sequence_id) + ")";
}

}  // namespace

OrderBook::OrderBook(const zone::TrafficZone& zone, std::vector<std::string> supported_actions)
    : zone_{zone},
      supported_actions_{std::move(supported_actions)},
      ring_m_{zone.circuit.total_length_m() + lap_rounding_m} {}

Result<OrderBook::Verdict> OrderBook::offer(const wire::Order& order, const Standing& standing) {
  // A repeated message is silence even when its base has long been driven, so it comes before everything else.
  const bool same_order = !order_id_.empty() && order.order_id == order_id_;
  if (same_order && order.order_update_id == order_update_id_) return Verdict::ignored_same;
  if (auto checked = check_shape(order); !checked) return tl::unexpected(std::move(checked.error()));
  if (same_order && order.order_update_id < order_update_id_) {
    return fail("orderUpdateError", "update " + std::to_string(order.order_update_id) + " is older than " +
                                        std::to_string(order_update_id_) + ", which is being followed");
  }
  if (auto checked = check_abilities(order, supported_actions_); !checked)
    return tl::unexpected(std::move(checked.error()));
  if (!standing.position_known) return fail("noRouteError", "the vehicle does not know where it is");
  return same_order ? offer_update(order, standing) : offer_new(order, standing);
}

Result<OrderBook::Verdict> OrderBook::offer_new(const wire::Order& order, const Standing& standing) {
  if (active()) {
    return fail("orderUpdateError", "order '" + order_id_ + "' is not finished: it has " +
                                        std::string(base_left() ? "base" : "horizon") + " left");
  }
  const Result<zone::Place> first = find(order.nodes.front(), standing.place, true);
  if (!first) return tl::unexpected(first.error());
  Result<Route> found = route(order, *first, 0.0);
  if (!found) return tl::unexpected(std::move(found.error()));
  const double edge_m = found->targets.empty() ? 0.0 : found->targets.front().path_m;
  const Result<double> way_m = way_from_first_node(order.nodes.front(), *first, edge_m, standing.place);
  if (!way_m) return tl::unexpected(way_m.error());

  targets_ = std::move(found->targets);
  edges_ = std::move(found->edges);
  travelled_m_ = *way_m;
  base_end_path_m_ = *way_m;  // a first node alone is a place to be at, not to drive to
  last_node_id_ = order.nodes.front().node_id;
  last_node_sequence_id_ = order.nodes.front().sequence_id;
  last_node_path_m_ = 0.0;
  last_node_place_ = *first;
  take_over(order);
  return Verdict::accepted_new;
}

Result<OrderBook::Verdict> OrderBook::offer_update(const wire::Order& order, const Standing& standing) {
  if (cancelled_) return fail("orderUpdateError", "order '" + order_id_ + "' was cancelled");

  // The stitch: the last node of the base, not of the horizon (trap 4); where no base is left, the last node passed.
  const std::size_t kept = released_count();
  const bool on_base = kept > 0;
  const std::string& node_id = on_base ? targets_[kept - 1].node.node_id : last_node_id_;
  const std::uint32_t sequence_id = on_base ? targets_[kept - 1].node.sequence_id : last_node_sequence_id_;
  const wire::OrderNode& first = order.nodes.front();
  if (first.node_id != node_id || first.sequence_id != sequence_id) {
    return fail("orderUpdateError", "the update starts at " + with_sequence(first.node_id, first.sequence_id) +
                                        ", the base ends at " + with_sequence(node_id, sequence_id));
  }
  const zone::Place first_place = on_base ? targets_[kept - 1].place : last_node_place_;
  const double first_path_m = on_base ? targets_[kept - 1].path_m : last_node_path_m_;
  Result<Route> found = route(order, first_place, first_path_m);
  if (!found) return tl::unexpected(std::move(found.error()));
  if (!on_base) {
    // It may have been moved by hand since it arrived.
    const double edge_m = found->targets.empty() ? 0.0 : found->targets.front().path_m - first_path_m;
    const Result<double> way_m = way_from_first_node(first, first_place, edge_m, standing.place);
    if (!way_m) return tl::unexpected(way_m.error());
    travelled_m_ = first_path_m + *way_m;
  }

  targets_.resize(kept);
  edges_.resize(kept);
  std::ranges::move(found->targets, std::back_inserter(targets_));
  std::ranges::move(found->edges, std::back_inserter(edges_));
  take_over(order);
  return Verdict::accepted_update;
}

void OrderBook::take_over(const wire::Order& order) {
  order_id_ = order.order_id;
  order_update_id_ = order.order_update_id;
  zone_set_id_ = order.zone_set_id;
  cancelled_ = false;
  if (const std::size_t released = released_count(); released > 0) base_end_path_m_ = targets_[released - 1].path_m;
}

Result<OrderBook::Route> OrderBook::route(const wire::Order& order, zone::Place first, double first_path_m) const {
  Route route{{}, order.edges};
  route.targets.reserve(order.edges.size());
  zone::Place from = first;
  double path_m = first_path_m;
  for (std::size_t i = 1; i < order.nodes.size(); ++i) {
    const Result<zone::Place> place = find(order.nodes[i], from, false);
    if (!place) return tl::unexpected(place.error());
    const std::optional<double> way_m = zone_.circuit.distance_ahead(from, *place, ring_m_);
    if (!way_m) {
      return fail("noRouteError",
                  "no way along the circuit from " + named(order.nodes[i - 1]) + " to " + named(order.nodes[i]));
    }
    path_m += *way_m;
    route.targets.push_back({order.nodes[i], *place, path_m, order.edges[i - 1].max_speed_mps});
    from = *place;
  }
  return route;
}

Result<zone::Place> OrderBook::find(const wire::OrderNode& node, zone::Place from, bool is_first) const {
  const auto& at = node.position;
  if (at && !at->map_id.empty() && at->map_id != zone_.name) {
    return fail("noRouteError", named(node) + " is on map '" + at->map_id + "', the vehicle on '" + zone_.name + "'");
  }
  const zone::Circuit& circuit = zone_.circuit;
  if (const zone::Waypoint* waypoint = zone_.find_waypoint(node.node_id)) {
    if (at && distance(position(circuit.pose_at(waypoint->place)), {at->x_m, at->y_m}) > node_off_circuit_m_max)
      return fail("noRouteError", named(node) + " does not lie where its nodePosition says");
    return waypoint->place;
  }
  if (!at) return fail("noRouteError", named(node) + " is unknown here and has no nodePosition");

  struct Candidate {
    zone::Place place;
    double distance_m;
  };
  std::vector<Candidate> candidates;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    const auto near = circuit.section(id).nearest({at->x_m, at->y_m});
    if (near.distance_m > node_off_circuit_m_max) continue;
    const zone::Place place{id, near.s_m};
    if (at->theta_rad && std::fabs(wrap_angle(circuit.pose_at(place).heading_rad - *at->theta_rad)) > pi / 2.0)
      continue;
    candidates.push_back({place, near.distance_m});
    nearest_m = std::min(nearest_m, near.distance_m);
  }
  if (candidates.empty()) return fail("noRouteError", named(node) + " does not lie on the circuit");

  double shortest_m = std::numeric_limits<double>::infinity();
  zone::Place best = candidates.front().place;
  for (const Candidate& candidate : candidates) {
    if (candidate.distance_m > nearest_m + node_tie_m) continue;
    double way_m = circuit.distance_ahead(from, candidate.place, ring_m_).value_or(2.0 * ring_m_);
    if (is_first) way_m = std::min(way_m, circuit.distance_ahead(candidate.place, from, ring_m_).value_or(way_m));
    if (way_m < shortest_m) {
      shortest_m = way_m;
      best = candidate.place;
    }
  }
  return best;
}

Result<double> OrderBook::way_from_first_node(const wire::OrderNode& node, zone::Place first, double first_edge_m,
                                              zone::Place now) const {
  const double deviation_m =
      std::max(first_node_m, node.position ? node.position->allowed_deviation_xy_m.value_or(0.0) : 0.0);
  // Behind the vehicle the whole first edge counts: a vehicle that stands on it has passed the node.
  const auto beyond_m =
      zone_.circuit.distance_ahead(first, now, std::min(ring_m_, std::max(deviation_m, first_edge_m)));
  const auto before_m = zone_.circuit.distance_ahead(now, first, std::min(ring_m_, deviation_m));
  if (before_m && (!beyond_m || *before_m < *beyond_m)) return -*before_m;
  if (beyond_m) return *beyond_m;
  return fail("noRouteError", named(node) + " is not where the vehicle is: neither on it within " +
                                  std::to_string(deviation_m) + " m nor on the edge behind it");
}

void OrderBook::cancel() {
  targets_.clear();
  edges_.clear();
  base_end_path_m_ = travelled_m_;
  cancelled_ = true;
}

bool OrderBook::relocate(zone::Place place) {
  if (!active()) return true;
  const double left_m = targets_.back().path_m - last_node_path_m_;
  if (const auto beyond_m = zone_.circuit.distance_ahead(last_node_place_, place, left_m)) {
    travelled_m_ = last_node_path_m_ + *beyond_m;
    return true;
  }
  if (const auto before_m = zone_.circuit.distance_ahead(place, last_node_place_, first_node_m)) {
    travelled_m_ = last_node_path_m_ - *before_m;
    return true;
  }
  return false;
}

void OrderBook::set_last_node(std::string node_id) {
  if (active()) return;
  last_node_id_ = std::move(node_id);
  last_node_sequence_id_ = 0;
  cancelled_ = true;  // whatever it followed, it does not stand where that ended
}

std::size_t OrderBook::released_count() const {
  const auto end = std::ranges::find_if(targets_, [](const Target& target) { return !target.node.released; });
  return static_cast<std::size_t>(end - targets_.begin());
}

std::vector<wire::OrderNode> OrderBook::travelled(double distance_m) {
  travelled_m_ += distance_m;
  std::size_t passed = 0;
  for (; passed < targets_.size(); ++passed) {
    const Target& target = targets_[passed];
    // Not even a vehicle pushed past the end of its base traverses what was never released.
    if (!target.node.released) break;
    const bool base_ends_here = passed + 1 == targets_.size() || !targets_[passed + 1].node.released;
    if (travelled_m_ < target.path_m - (base_ends_here ? arrival_m : 0.0)) break;
  }
  std::vector<wire::OrderNode> traversed;
  if (passed == 0) return traversed;
  last_node_path_m_ = targets_[passed - 1].path_m;
  last_node_place_ = targets_[passed - 1].place;
  traversed.reserve(passed);
  for (std::size_t i = 0; i < passed; ++i) traversed.push_back(std::move(targets_[i].node));
  last_node_id_ = traversed.back().node_id;
  last_node_sequence_id_ = traversed.back().sequence_id;
  const auto count = static_cast<std::ptrdiff_t>(passed);
  targets_.erase(targets_.begin(), targets_.begin() + count);
  edges_.erase(edges_.begin(), edges_.begin() + count);
  return traversed;
}

bool OrderBook::active() const { return !targets_.empty(); }

bool OrderBook::base_left() const { return !targets_.empty() && targets_.front().node.released; }

bool OrderBook::horizon_left() const { return !targets_.empty() && !targets_.back().node.released; }

double OrderBook::distance_to_base_end_m() const { return std::max(0.0, base_end_path_m_ - travelled_m_); }

std::optional<double> OrderBook::speed_limit_mps() const {
  return targets_.empty() ? std::nullopt : targets_.front().max_speed_mps;
}

double OrderBook::since_last_node_m() const { return std::max(0.0, travelled_m_ - last_node_path_m_); }

std::vector<wire::NodeState> OrderBook::node_states() const {
  std::vector<wire::NodeState> states;
  states.reserve(targets_.size());
  for (const Target& target : targets_) {
    const wire::OrderNode& node = target.node;
    states.push_back({node.node_id, node.sequence_id, node.released, node.position});
  }
  return states;
}

std::vector<wire::EdgeState> OrderBook::edge_states() const {
  std::vector<wire::EdgeState> states;
  states.reserve(edges_.size());
  for (const wire::OrderEdge& edge : edges_) states.push_back({edge.edge_id, edge.sequence_id, edge.released});
  return states;
}

}  // namespace cosiva::aiv
