#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cosiva/aiv/order/order_route.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// An order located on the circuit, and the vehicle's position on it.
struct LocatedOrder {
  OrderRoute route;
  double vehicle_m;          ///< beyond the first node; negative: before it
  zone::TrackPosition from;  ///< the vehicle's position
};

/// The end of a base, where an update continues it.
struct BaseEnd {
  zone::TrackPosition position;
  zone::TrackPosition before;  ///< the node before
  double edge_m;               ///< along the order between both
};

/// The route of an update from the end of a base.
struct Continuation {
  OrderRoute route;
  /// To another position of the base's last node than the base had assumed: the route there from the node before.
  std::optional<zone::Circuit::Route> other_edge;
};

/// Locates an offered order on the circuit and relative to the vehicle: of all positions that its first node may refer
/// to, the one at which the vehicle is, or at which the base ends.
class OrderLocator {
 public:
  /// @param zone  must outlive the locator
  explicit OrderLocator(const zone::TrafficZone& zone) : zone_{zone}, router_{zone} {}

  [[nodiscard]] const OrderRouter& router() const { return router_; }
  /// The position that was found for an update's first node, and the other positions with the same id.
  [[nodiscard]] std::vector<zone::TrackPosition> positions_like(zone::TrackPosition found,
                                                                const wire::Order& order) const;
  /// From the one of `firsts` at which the vehicle is, and from each other position of the vehicle when that gives the
  /// shorter route, or the only one. Fails with noRouteError.
  /// @param firsts  positions of the order's first node
  /// @param now     the vehicle's position
  /// @param also    the same point on other sections
  [[nodiscard]] Result<LocatedOrder> locate(const wire::Order& order, const std::vector<zone::TrackPosition>& firsts,
                                            zone::TrackPosition now, std::span<const zone::TrackPosition> also) const;
  /// From the position of the order's first node that continues the base. Fails with noRouteError.
  [[nodiscard]] Result<Continuation> continuation(const wire::Order& order, const BaseEnd& base_end) const;

 private:
  [[nodiscard]] Result<LocatedOrder> locate_from(const wire::Order& order,
                                                 const std::vector<zone::TrackPosition>& firsts,
                                                 zone::TrackPosition now) const;
  /// Distance of the vehicle beyond the first node; negative: before it. noRouteError where the distance is too large.
  [[nodiscard]] Result<double> distance_from_first_node(const wire::OrderNode& node, const OrderRoute& route,
                                                        zone::TrackPosition now) const;

  const zone::TrafficZone& zone_;
  OrderRouter router_;
};

}  // namespace cosiva::aiv
