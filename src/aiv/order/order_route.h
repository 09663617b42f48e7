#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The route of an order through the circuit.
struct OrderRoute {
  struct Leg {
    zone::TrackPosition position;      ///< of the node at its end
    double length_m{};                 ///< from the node before
    std::vector<zone::SectionId> via;  ///< entered on the leg, the node's own section last; empty within one section
  };
  zone::TrackPosition first;  ///< of the first node
  std::vector<Leg> legs;      ///< one for each node after it
  [[nodiscard]] double length_m() const;
  [[nodiscard]] std::vector<zone::SectionId> sections() const;  ///< after the section of the first node
};

/// Locates an order's nodes on the circuit, and finds the shortest route from node to node over all branches. Where
/// several positions have one id (nodes at forks and merges), the positions that give the shortest total route are
/// taken.
class OrderRouter {
 public:
  /// @param zone  must outlive the router
  explicit OrderRouter(const zone::TrafficZone& zone);

  /// The positions that a node may refer to. Fails with noRouteError: on another map, unknown, or off the circuit.
  [[nodiscard]] Result<std::vector<zone::TrackPosition>> positions_of(const wire::OrderNode& node) const;
  /// The positions of the first node alone; the order's first edge may determine from which of them the order starts.
  [[nodiscard]] Result<std::vector<zone::TrackPosition>> first_positions(const wire::Order& order) const;
  /// The whole order from one of its first node's positions. Fails with noRouteError.
  [[nodiscard]] Result<OrderRoute> route(const wire::Order& order, zone::TrackPosition first) const;
  /// The shortest route; its sections are left out on a circuit without branches.
  [[nodiscard]] std::optional<zone::Circuit::Route> shortest_route(zone::TrackPosition from, zone::TrackPosition to,
                                                                   double limit_m) const;
  [[nodiscard]] std::optional<zone::Circuit::Route> shortest_route(zone::TrackPosition from,
                                                                   zone::TrackPosition to) const {
    return shortest_route(from, to, longest_m_);
  }
  /// The circuit has no branches: the sections of routes are left out.
  [[nodiscard]] bool one_way() const { return one_way_; }
  /// No route without a loop is longer.
  [[nodiscard]] double longest_m() const { return longest_m_; }

 private:
  [[nodiscard]] Result<std::vector<zone::TrackPosition>> by_position(const wire::OrderNode& node) const;
  /// Keeps only the positions from which the edge after the node starts, where the edge's id determines them.
  void keep_for_edge(std::vector<zone::TrackPosition>& positions, const wire::OrderEdge* edge) const;

  const zone::TrafficZone& zone_;
  double longest_m_;
  bool one_way_;
};

}  // namespace cosiva::aiv
