#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// An order's way through the circuit.
struct OrderRoute {
  struct Leg {
    zone::TrackPosition position;      ///< of the node that it leads to
    double length_m{};                 ///< from the node before
    std::vector<zone::SectionId> via;  ///< entered on it, the node's own section last; empty within one section
  };
  zone::TrackPosition first;  ///< of the first node
  std::vector<Leg> legs;      ///< one for each node after it
  [[nodiscard]] double length_m() const;
  [[nodiscard]] std::vector<zone::SectionId> sections() const;  ///< after that of the first node
};

/// Finds an order's nodes on the circuit, and the shortest way from node to node over all branches. Where several
/// places go by one id (nodes where ways part or meet), those are taken that make the whole way shortest.
class OrderRouter {
 public:
  /// @param zone  must outlive the router
  explicit OrderRouter(const zone::TrafficZone& zone);

  /// The places that a node may mean. Fails with noRouteError: on another map, unknown, or off the circuit.
  [[nodiscard]] Result<std::vector<zone::TrackPosition>> positions_of(const wire::OrderNode& node) const;
  /// The first node's places alone, of which the order's first edge may say which it leaves from.
  [[nodiscard]] Result<std::vector<zone::TrackPosition>> first_positions(const wire::Order& order) const;
  /// The whole order from one of its first node's places. Fails with noRouteError.
  [[nodiscard]] Result<OrderRoute> route(const wire::Order& order, zone::TrackPosition first) const;
  /// The shortest way; its sections are left out on a circuit where there is nothing to choose.
  [[nodiscard]] std::optional<zone::Circuit::Route> shortest_route(zone::TrackPosition from, zone::TrackPosition to,
                                                                   double limit_m) const;
  [[nodiscard]] std::optional<zone::Circuit::Route> shortest_route(zone::TrackPosition from,
                                                                   zone::TrackPosition to) const {
    return shortest_route(from, to, longest_m_);
  }
  /// Nothing to choose anywhere: the sections of routes are left out.
  [[nodiscard]] bool one_way() const { return one_way_; }
  /// No way without a loop in it is longer.
  [[nodiscard]] double longest_m() const { return longest_m_; }

 private:
  [[nodiscard]] Result<std::vector<zone::TrackPosition>> by_position(const wire::OrderNode& node) const;
  /// Only those that the edge after the node leaves from, where its id tells.
  void keep_for_edge(std::vector<zone::TrackPosition>& positions, const wire::OrderEdge* edge) const;

  const zone::TrafficZone& zone_;
  double longest_m_;
  bool one_way_;
};

}  // namespace cosiva::aiv
