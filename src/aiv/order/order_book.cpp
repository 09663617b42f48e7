#include "cosiva/aiv/order/order_book.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/aiv/order/order_check.h"

namespace cosiva::aiv {
namespace {

/// Distance from the first node within which a vehicle counts as located at it when the order states no deviation.
constexpr double first_node_m = 0.10;
/// Accuracy at standstill at the end of the base.
constexpr double arrival_m = 0.015;
/// Tolerance of the distances along a route to different positions of one node.
constexpr double same_path_m = 1e-3;
/// Tolerance between the vehicle's progress along the order and its position on the circuit.
constexpr double same_position_m = 0.10;

std::string named(const wire::OrderNode& node) { return "node '" + node.node_id + "'"; }

std::string with_sequence(std::string_view node_id, std::uint32_t sequence_id) {
  return "'" + std::string(node_id) + "' (" + std::to_string(sequence_id) + ")";
}

}  // namespace

OrderBook::OrderBook(const zone::TrafficZone& zone, std::vector<std::string> supported_actions)
    : zone_{zone}, supported_actions_{std::move(supported_actions)}, router_{zone} {}

Result<OrderBook::Verdict> OrderBook::offer(const wire::Order& order, const StartState& reference) {
  // A repeated message is ignored even when its base has long been driven; this check therefore precedes all others.
  const bool same_order = !order_id_.empty() && order.order_id == order_id_;
  if (same_order && order.order_update_id == order_update_id_) return Verdict::ignored_same;
  if (auto checked = check_shape(order); !checked) return tl::unexpected(std::move(checked.error()));
  if (same_order && order.order_update_id < order_update_id_) {
    return fail("orderUpdateError", "update " + std::to_string(order.order_update_id) + " is older than " +
                                        std::to_string(order_update_id_) + ", which is being followed");
  }
  if (auto checked = check_abilities(order, supported_actions_); !checked)
    return tl::unexpected(std::move(checked.error()));
  if (!reference.position_known) return fail("noRouteError", "the vehicle's position is not known");
  return same_order ? offer_update(order, reference) : offer_new(order, reference);
}

Result<OrderBook::Verdict> OrderBook::offer_new(const wire::Order& order, const StartState& reference) {
  if (active()) {
    return fail("orderUpdateError", "order '" + order_id_ + "' is not finished: it has " +
                                        std::string(base_left() ? "base" : "horizon") + " left");
  }
  const auto firsts = router_.first_positions(order);
  if (!firsts) return tl::unexpected(firsts.error());
  auto found = find_from_any(order, *firsts, reference);
  if (!found) return tl::unexpected(std::move(found.error()));

  targets_.clear();
  edges_.clear();
  travelled_m_ = found->vehicle_m;
  base_end_path_m_ = found->vehicle_m;  // a first node alone is not driven to
  last_node_id_ = order.nodes.front().node_id;
  last_node_sequence_id_ = order.nodes.front().sequence_id;
  last_node_path_m_ = 0.0;
  last_node_position_ = found->route.first;
  accepted_at_ = found->from;
  append(order, std::move(found->route), 0.0);
  return Verdict::accepted_new;
}

Result<OrderBook::Verdict> OrderBook::offer_update(const wire::Order& order, const StartState& reference) {
  if (cancelled_) return fail("orderUpdateError", "order '" + order_id_ + "' was cancelled");

  // The stitch: the last node of the base, not of the horizon (trap 4); without a remaining base, the last node passed.
  const std::size_t kept = released_count();
  const bool on_base = kept > 0;
  const std::string& node_id = on_base ? targets_[kept - 1].node.node_id : last_node_id_;
  const std::uint32_t sequence_id = on_base ? targets_[kept - 1].node.sequence_id : last_node_sequence_id_;
  const wire::OrderNode& first = order.nodes.front();
  if (first.node_id != node_id || first.sequence_id != sequence_id) {
    return fail("orderUpdateError", "the update starts at " + with_sequence(first.node_id, first.sequence_id) +
                                        ", the base ends at " + with_sequence(node_id, sequence_id));
  }
  if (on_base) {
    auto route = find_continuation(order, kept);
    if (!route) return tl::unexpected(std::move(route.error()));
    targets_.resize(kept);
    edges_.resize(kept);
    append(order, std::move(*route), targets_.back().path_m);
  } else {
    // The vehicle may have been moved by hand since its arrival.
    auto found = find_from_any(order, positions_like(last_node_position_, order), reference);
    if (!found) return tl::unexpected(std::move(found.error()));
    targets_.clear();
    edges_.clear();
    travelled_m_ = last_node_path_m_ + found->vehicle_m;
    last_node_position_ = found->route.first;
    accepted_at_ = found->from;
    append(order, std::move(found->route), last_node_path_m_);
  }
  return Verdict::accepted_update;
}

Result<OrderBook::Found> OrderBook::find(const wire::Order& order, const std::vector<zone::TrackPosition>& firsts,
                                         zone::TrackPosition now) const {
  std::optional<Found> best;
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
      best = Found{std::move(*route), *vehicle_m, now};
  }
  if (!best) return tl::unexpected(std::move(*why));
  return std::move(*best);
}

Result<OrderBook::Found> OrderBook::find_from_any(const wire::Order& order,
                                                  const std::vector<zone::TrackPosition>& firsts,
                                                  const StartState& reference) const {
  auto best = find(order, firsts, reference.position);
  for (const zone::TrackPosition position : reference.also) {
    auto found = find(order, firsts, position);
    if (found && (!best || found->route.length_m() + same_position_m < best->route.length_m())) best = std::move(found);
  }
  return best;
}

std::vector<zone::TrackPosition> OrderBook::positions_like(zone::TrackPosition found, const wire::Order& order) const {
  std::vector<zone::TrackPosition> positions{found};
  if (router_.one_way()) return positions;
  const auto others = router_.first_positions(order);
  if (!others) return positions;
  for (const zone::TrackPosition other : *others)
    if (!(other == found)) positions.push_back(other);
  return positions;
}

Result<OrderRoute> OrderBook::find_continuation(const wire::Order& order, std::size_t kept) {
  Target& stitch = targets_[kept - 1];
  const zone::TrackPosition before = kept > 1 ? targets_[kept - 2].position : last_node_position_;
  const double path_distance_m = stitch.path_m - (kept > 1 ? targets_[kept - 2].path_m : last_node_path_m_);
  std::optional<OrderRoute> best;
  std::optional<zone::Circuit::Route> best_route;
  std::optional<Error> why;
  for (const zone::TrackPosition position : positions_like(stitch.position, order)) {
    const bool same = position == stitch.position;
    auto found_route = same ? std::nullopt : router_.shortest_route(before, position, path_distance_m + same_path_m);
    // Another position of the node, equally far along the base: that of another branch out of it.
    if (!same && (!found_route || found_route->length_m < path_distance_m - same_path_m)) continue;
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
  if (best_route) {
    stitch.position = best->first;
    stitch.via.assign(best_route->sections.begin() + 1, best_route->sections.end());
  }
  return std::move(*best);
}

void OrderBook::append(const wire::Order& order, OrderRoute&& route, double first_path_m) {
  double path_m = first_path_m;
  for (std::size_t i = 0; i < route.legs.size(); ++i) {
    OrderRoute::Leg& leg = route.legs[i];
    path_m += leg.length_m;
    targets_.push_back({order.nodes[i + 1], leg.position, path_m, order.edges[i].max_speed_mps, std::move(leg.via)});
    edges_.push_back(order.edges[i]);
  }
  order_id_ = order.order_id;
  order_update_id_ = order.order_update_id;
  zone_set_id_ = order.zone_set_id;
  cancelled_ = false;
  if (const std::size_t released = released_count(); released > 0) base_end_path_m_ = targets_[released - 1].path_m;
}

Result<double> OrderBook::distance_from_first_node(const wire::OrderNode& node, const OrderRoute& route,
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

void OrderBook::cancel() {
  targets_.clear();
  edges_.clear();
  base_end_path_m_ = travelled_m_;
  cancelled_ = true;
}

bool OrderBook::relocate(zone::TrackPosition position) {
  if (!active()) return true;
  const double left_m = targets_.back().path_m - last_node_path_m_;
  std::vector<zone::SectionId> remaining;
  for (const Target& target : targets_) remaining.insert(remaining.end(), target.via.begin(), target.via.end());
  if (const auto beyond_m = zone_.circuit.distance_ahead(last_node_position_, position, left_m, remaining)) {
    travelled_m_ = last_node_path_m_ + *beyond_m;
    return true;
  }
  if (const auto before = router_.shortest_route(position, last_node_position_, first_node_m)) {
    travelled_m_ = last_node_path_m_ - before->length_m;
    return true;
  }
  return false;
}

zone::Course OrderBook::course_from(zone::TrackPosition here) const {
  if (router_.one_way()) return {};
  if (last_node_position_.section == zone::no_section) return zone::Course{{here.section}};  // no order so far
  std::vector<zone::SectionId> sections{last_node_position_.section};
  for (const Target& target : targets_) sections.insert(sections.end(), target.via.begin(), target.via.end());

  // A route may use a section more than once: the use that fits the distance travelled is taken.
  const double since_m = travelled_m_ - last_node_path_m_;
  double start_m = -last_node_position_.s_m;
  std::size_t at = sections.size();
  double best_m = same_position_m;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const double misfit_m = std::fabs(start_m + here.s_m - since_m);
    if (sections[i] == here.section && misfit_m <= best_m) {
      at = i;
      best_m = misfit_m;
    }
    start_m += zone_.circuit.section(sections[i]).length_m();
  }
  if (at < sections.size()) return zone::Course{std::move(sections), at};

  // The vehicle is before the first node, or nowhere near.
  const auto found_route = router_.shortest_route(here, last_node_position_, std::fabs(since_m) + same_position_m);
  if (!found_route) return zone::Course{{here.section}};
  std::vector<zone::SectionId> all = found_route->sections;
  all.insert(all.end(), sections.begin() + 1, sections.end());
  return zone::Course{std::move(all)};
}

void OrderBook::set_last_node(std::string node_id) {
  if (active()) return;
  last_node_id_ = std::move(node_id);
  last_node_sequence_id_ = 0;
  cancelled_ = true;  // the vehicle is not where its last order ended
}

void OrderBook::take_over_ids(const OrderBook& before) {
  order_id_ = before.order_id_;
  order_update_id_ = before.order_update_id_;
  zone_set_id_ = before.zone_set_id_;
  cancelled_ = true;
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
    // Even a vehicle pushed past the end of its base does not traverse a node that was never released.
    if (!target.node.released) break;
    const bool base_ends_here = passed + 1 == targets_.size() || !targets_[passed + 1].node.released;
    if (travelled_m_ < target.path_m - (base_ends_here ? arrival_m : 0.0)) break;
  }
  std::vector<wire::OrderNode> traversed;
  if (passed == 0) return traversed;
  last_node_path_m_ = targets_[passed - 1].path_m;
  last_node_position_ = targets_[passed - 1].position;
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
