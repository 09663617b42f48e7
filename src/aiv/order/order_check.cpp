#include "cosiva/aiv/order/order_check.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>

namespace cosiva::aiv {
namespace {

std::string at(std::string_view array, std::size_t index, std::string_view field) {
  return std::string(array) + "[" + std::to_string(index) + "]." + std::string(field);
}

auto invalid(std::string message, std::string position) {
  return fail("validationError", std::move(message), std::move(position));
}

Result<void> check_node(const wire::Order& order, std::size_t i) {
  const wire::OrderNode& node = order.nodes[i];
  if (node.node_id.empty()) return invalid("a node needs an id", at("nodes", i, "nodeId"));
  const std::uint64_t expected = order.nodes.front().sequence_id + 2 * std::uint64_t{i};
  if (node.sequence_id != expected) {
    return invalid("sequenceId " + std::to_string(node.sequence_id) + ", expected " + std::to_string(expected) +
                       ": numbers run without gap over nodes and edges",
                   at("nodes", i, "sequenceId"));
  }
  if (i > 0 && node.released && !order.nodes[i - 1].released)
    return invalid("released after a node that is not", at("nodes", i, "released"));
  const auto& p = node.position;
  if (p && !(std::isfinite(p->x_m) && std::isfinite(p->y_m) && std::isfinite(p->theta_rad.value_or(0.0)) &&
             std::isfinite(p->allowed_deviation_xy_m.value_or(0.0)))) {
    return invalid("a position that is no number", at("nodes", i, "nodePosition"));
  }
  if (p && p->allowed_deviation_xy_m.value_or(0.0) < 0.0)
    return invalid("a deviation is not negative", at("nodes", i, "nodePosition.allowedDeviationXY"));
  return {};
}

/// @param i  the edge from node i to node i + 1
Result<void> check_edge(const wire::Order& order, std::size_t i) {
  const wire::OrderEdge& edge = order.edges[i];
  const wire::OrderNode& from = order.nodes[i];
  const wire::OrderNode& to = order.nodes[i + 1];
  if (edge.edge_id.empty()) return invalid("an edge needs an id", at("edges", i, "edgeId"));
  if (edge.sequence_id != from.sequence_id + 1) {
    return invalid("sequenceId " + std::to_string(edge.sequence_id) + ", expected " +
                       std::to_string(from.sequence_id + 1) + ": numbers run without gap over nodes and edges",
                   at("edges", i, "sequenceId"));
  }
  if (edge.start_node_id != from.node_id)
    return invalid("starts at '" + edge.start_node_id + "', the node before it is '" + from.node_id + "'",
                   at("edges", i, "startNodeId"));
  if (edge.end_node_id != to.node_id)
    return invalid("ends at '" + edge.end_node_id + "', the node after it is '" + to.node_id + "'",
                   at("edges", i, "endNodeId"));
  if (edge.released != to.released)
    return invalid("an edge is released exactly when the node it leads to is", at("edges", i, "released"));
  if (edge.max_speed_mps && !(*edge.max_speed_mps > 0.0 && std::isfinite(*edge.max_speed_mps)))
    return invalid("a speed limit is positive", at("edges", i, "maxSpeed"));
  return {};
}

/// @param array  "nodes" or "edges", whose i-th element has these actions
Result<void> check_actions(const std::vector<wire::Action>& actions, const ActionCatalogue& catalogue,
                           std::string_view array, std::size_t i) {
  const ActionScope scope = array == "nodes" ? ActionScope::node : ActionScope::edge;
  for (const wire::Action& action : actions) {
    auto checked = check_action(catalogue, action, scope);
    if (!checked) return fail(checked.error().code, checked.error().message, at(array, i, "actions"));
  }
  return {};
}

/// §6.6.6: an actionId is unique, so that a state is of one action.
Result<void> check_action_ids(const wire::Order& order) {
  std::set<std::string_view> ids;
  const auto repeated = [&ids](const std::vector<wire::Action>& actions) {
    return std::ranges::any_of(actions,
                               [&ids](const wire::Action& each) { return !ids.insert(each.action_id).second; });
  };
  for (std::size_t i = 0; i < order.nodes.size(); ++i) {
    if (repeated(order.nodes[i].actions)) return invalid("an actionId occurs twice", at("nodes", i, "actions"));
    if (i < order.edges.size() && repeated(order.edges[i].actions))
      return invalid("an actionId occurs twice", at("edges", i, "actions"));
  }
  return {};
}

}  // namespace

Result<void> check_shape(const wire::Order& order) {
  if (order.order_id.empty()) return invalid("an order needs an id", "orderId");
  if (order.nodes.empty()) return invalid("an order needs a node", "nodes");
  if (order.edges.size() + 1 != order.nodes.size()) {
    return invalid(std::to_string(order.edges.size()) + " edges for " + std::to_string(order.nodes.size()) +
                       " nodes, expected one less than nodes",
                   "edges");
  }
  if (order.nodes.front().sequence_id % 2 != 0)
    return invalid("nodes have even numbers, this one has " + std::to_string(order.nodes.front().sequence_id),
                   "nodes[0].sequenceId");
  if (!order.nodes.front().released) return invalid("the base has at least its first node", "nodes[0].released");
  for (std::size_t i = 0; i < order.nodes.size(); ++i) {
    if (auto checked = check_node(order, i); !checked) return checked;
  }
  for (std::size_t i = 0; i < order.edges.size(); ++i) {
    if (auto checked = check_edge(order, i); !checked) return checked;
  }
  return check_action_ids(order);
}

Result<void> check_orientation(const wire::Order& order, bool backwards) {
  for (std::size_t i = 0; i < order.edges.size(); ++i) {
    if (order.edges[i].backwards.value_or(backwards) == backwards) continue;
    return fail("orderError",
                backwards ? "on this map vehicles drive backwards, with an orientation of π"
                          : "on this map vehicles drive forwards, with an orientation of 0",
                at("edges", i, "orientation"));
  }
  return {};
}

Result<void> check_abilities(const wire::Order& order, const ActionCatalogue& catalogue) {
  for (std::size_t i = 0; i < order.edges.size(); ++i) {
    const wire::OrderEdge& edge = order.edges[i];
    if (!edge.unsupported.empty())
      return fail("orderError", "'" + edge.unsupported.front() + "' is not supported",
                  at("edges", i, edge.unsupported.front()));
    if (auto checked = check_actions(edge.actions, catalogue, "edges", i); !checked) return checked;
  }
  for (std::size_t i = 0; i < order.nodes.size(); ++i) {
    if (auto checked = check_actions(order.nodes[i].actions, catalogue, "nodes", i); !checked) return checked;
  }
  return {};
}

}  // namespace cosiva::aiv
