#include "cosiva/aiv/order/order_book.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/aiv/order/order_check.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// Distance before the last node within which a vehicle counts as located at it after a jump.
constexpr double first_node_m = 0.10;
/// Accuracy at standstill at the end of the base.
constexpr double arrival_m = 0.015;
/// Tolerance between the vehicle's progress along the order and its position on the circuit.
constexpr double same_position_m = 0.10;

std::string with_sequence(std::string_view node_id, std::uint32_t sequence_id) {
  return "'" + std::string(node_id) + "' (" + std::to_string(sequence_id) + ")";
}

}  // namespace

OrderBook::OrderBook(const zone::TrafficZone& zone, ActionCatalogue catalogue)
    : zone_{zone}, catalogue_{std::move(catalogue)}, locator_{zone} {}

Result<OrderBook::Verdict> OrderBook::offer(const wire::Order& order, const StartState& reference) {
  // A repeated message is ignored even when its base has long been driven; this check therefore precedes all others.
  const bool same_order = !ids_.order_id.empty() && order.order_id == ids_.order_id;
  if (same_order && order.order_update_id == ids_.order_update_id) return Verdict::ignored_same;
  if (auto checked = check_shape(order); !checked) return tl::unexpected(std::move(checked.error()));
  if (same_order && order.order_update_id < ids_.order_update_id) {
    return fail("orderUpdateError", "update " + std::to_string(order.order_update_id) + " is older than " +
                                        std::to_string(ids_.order_update_id) + ", which is being followed");
  }
  if (auto checked = check_abilities(order, catalogue_); !checked) return tl::unexpected(std::move(checked.error()));
  if (auto checked = check_orientation(order, zone_.circuit.indirect()); !checked)
    return tl::unexpected(std::move(checked.error()));
  if (!reference.position_known) return fail("noRouteError", "the vehicle's position is not known");
  return same_order ? offer_update(order, reference) : offer_new(order, reference);
}

Result<OrderBook::Verdict> OrderBook::offer_new(const wire::Order& order, const StartState& reference) {
  if (active()) {
    return fail("orderUpdateError", "order '" + ids_.order_id + "' is not finished: it has " +
                                        std::string(base_left() ? "base" : "horizon") + " left");
  }
  if (reference.actions_left)
    return fail("orderUpdateError", "order '" + ids_.order_id + "' is not finished: it has actions left");
  const auto firsts = locator_.router().first_positions(order);
  if (!firsts) return tl::unexpected(firsts.error());
  auto found = locator_.locate(order, *firsts, reference.position, reference.also);
  if (!found) return tl::unexpected(std::move(found.error()));

  targets_.clear();
  edges_.clear();
  travelled_m_ = found->vehicle_m;
  base_end_path_m_ = found->vehicle_m;  // a first node alone is not driven to
  const wire::OrderNode& first = order.nodes.front();
  last_node_ = {first.node_id, first.sequence_id, found->route.first, 0.0};
  accepted_at_ = found->from;
  append(order, std::move(found->route), 0.0);
  return Verdict::accepted_new;
}

Result<OrderBook::Verdict> OrderBook::offer_update(const wire::Order& order, const StartState& reference) {
  if (cancelled_) return fail("orderUpdateError", "order '" + ids_.order_id + "' was cancelled");

  // The stitch: the last node of the base, not of the horizon (trap 4); without a remaining base, the last node passed.
  const std::size_t kept = released_count();
  const bool on_base = kept > 0;
  const std::string& node_id = on_base ? targets_[kept - 1].node.node_id : last_node_.node_id;
  const std::uint32_t sequence_id = on_base ? targets_[kept - 1].node.sequence_id : last_node_.sequence_id;
  const wire::OrderNode& first = order.nodes.front();
  if (first.node_id != node_id || first.sequence_id != sequence_id) {
    return fail("orderUpdateError", "the update starts at " + with_sequence(first.node_id, first.sequence_id) +
                                        ", the base ends at " + with_sequence(node_id, sequence_id));
  }
  if (on_base) {
    Target& stitch = targets_[kept - 1];
    const zone::TrackPosition before = kept > 1 ? targets_[kept - 2].position : last_node_.position;
    const double before_path_m = kept > 1 ? targets_[kept - 2].path_m : last_node_.path_m;
    auto found = locator_.continuation(order, {stitch.position, before, stitch.path_m - before_path_m});
    if (!found) return tl::unexpected(std::move(found.error()));
    if (const auto& edge = found->other_edge) {
      stitch.position = found->route.first;
      stitch.via.assign(edge->sections.begin() + 1, edge->sections.end());
    }
    targets_.resize(kept);
    edges_.resize(kept);
    append(order, std::move(found->route), targets_.back().path_m);
  } else {
    // The vehicle may have been moved by hand since its arrival.
    auto found =
        locator_.locate(order, locator_.positions_like(last_node_.position, order), reference.position, reference.also);
    if (!found) return tl::unexpected(std::move(found.error()));
    targets_.clear();
    edges_.clear();
    travelled_m_ = last_node_.path_m + found->vehicle_m;
    last_node_.position = found->route.first;
    accepted_at_ = found->from;
    append(order, std::move(found->route), last_node_.path_m);
  }
  return Verdict::accepted_update;
}

void OrderBook::append(const wire::Order& order, OrderRoute&& route, double first_path_m) {
  double path_m = first_path_m;
  for (std::size_t i = 0; i < route.legs.size(); ++i) {
    OrderRoute::Leg& leg = route.legs[i];
    path_m += leg.length_m;
    const wire::OrderEdge& edge = order.edges[i];
    if (!targets_.empty() && edge.released && block_driving(edge.actions)) targets_.back().stops = true;
    targets_.push_back({order.nodes[i + 1], leg.position, path_m, edge.max_speed_mps, std::move(leg.via),
                        block_driving(order.nodes[i + 1].actions)});
    edges_.push_back(order.edges[i]);
  }
  COSIVA_EXPECT(targets_.size() == edges_.size());
  ids_ = {order.order_id, order.order_update_id, order.zone_set_id};
  cancelled_ = false;
  if (const std::size_t released = released_count(); released > 0) base_end_path_m_ = targets_[released - 1].path_m;
}

void OrderBook::cancel() {
  targets_.clear();
  edges_.clear();
  base_end_path_m_ = travelled_m_;
  cancelled_ = true;
}

bool OrderBook::relocate(zone::TrackPosition position) {
  if (!active()) return true;
  const double left_m = targets_.back().path_m - last_node_.path_m;
  std::vector<zone::SectionId> remaining;
  for (const Target& target : targets_) remaining.insert(remaining.end(), target.via.begin(), target.via.end());
  if (const auto beyond_m = zone_.circuit.distance_ahead(last_node_.position, position, left_m, remaining)) {
    travelled_m_ = last_node_.path_m + *beyond_m;
    return true;
  }
  if (const auto before = locator_.router().shortest_route(position, last_node_.position, first_node_m)) {
    travelled_m_ = last_node_.path_m - before->length_m;
    return true;
  }
  return false;
}

zone::Course OrderBook::course_from(zone::TrackPosition here) const {
  if (locator_.router().one_way()) return {};
  if (last_node_.position.section == zone::no_section) return zone::Course{{here.section}};  // no order so far
  std::vector<zone::SectionId> sections{last_node_.position.section};
  for (const Target& target : targets_) sections.insert(sections.end(), target.via.begin(), target.via.end());

  // A route may use a section more than once: the use that fits the distance travelled is taken.
  const double since_m = travelled_m_ - last_node_.path_m;
  double start_m = -last_node_.position.s_m;
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
  const auto found_route =
      locator_.router().shortest_route(here, last_node_.position, std::fabs(since_m) + same_position_m);
  if (!found_route) return zone::Course{{here.section}};
  std::vector<zone::SectionId> all = found_route->sections;
  all.insert(all.end(), sections.begin() + 1, sections.end());
  return zone::Course{std::move(all)};
}

void OrderBook::set_last_node(std::string node_id) {
  if (active()) return;
  last_node_.node_id = std::move(node_id);
  last_node_.sequence_id = 0;
  cancelled_ = true;  // the vehicle is not where its last order ended
}

void OrderBook::take_over_ids(const OrderBook& before) {
  ids_ = before.ids_;
  cancelled_ = true;
}

std::size_t OrderBook::released_count() const {
  const auto end = std::ranges::find_if(targets_, [](const Target& target) { return !target.node.released; });
  return static_cast<std::size_t>(end - targets_.begin());
}

std::vector<wire::OrderNode> OrderBook::travelled(double distance_m) {
  COSIVA_EXPECT(targets_.size() == edges_.size());
  travelled_m_ += distance_m;
  std::size_t passed = 0;
  for (; passed < targets_.size(); ++passed) {
    const Target& target = targets_[passed];
    // Even a vehicle pushed past the end of its base does not traverse a node that was never released.
    if (!target.node.released) break;
    const bool base_ends_here = passed + 1 == targets_.size() || !targets_[passed + 1].node.released;
    if (travelled_m_ < target.path_m - (base_ends_here || target.stops ? arrival_m : 0.0)) break;
  }
  std::vector<wire::OrderNode> traversed;
  if (passed == 0) return traversed;
  last_node_.path_m = targets_[passed - 1].path_m;
  last_node_.position = targets_[passed - 1].position;
  traversed.reserve(passed);
  for (std::size_t i = 0; i < passed; ++i) traversed.push_back(std::move(targets_[i].node));
  last_node_.node_id = traversed.back().node_id;
  last_node_.sequence_id = traversed.back().sequence_id;
  const auto count = static_cast<std::ptrdiff_t>(passed);
  targets_.erase(targets_.begin(), targets_.begin() + count);
  edges_.erase(edges_.begin(), edges_.begin() + count);
  return traversed;
}

bool OrderBook::base_left() const { return !targets_.empty() && targets_.front().node.released; }

double OrderBook::since_last_node_m() const { return std::max(0.0, travelled_m_ - last_node_.path_m); }

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

void OrderBook::archive(Archive& archive) {
  archive(cancelled_, ids_, last_node_, targets_, edges_, travelled_m_, base_end_path_m_, accepted_at_);
}

}  // namespace cosiva::aiv
