#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/order/order_route.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/circuit/course.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The vehicle's side of an order (VDA 5050 2.1 §6.6): what was accepted, what is released, what was traversed.
/// Every rule of acceptance stands here, once; the on-board program and the virtual AIV both use it.
class OrderBook {
 public:
  /// Where the vehicle is, for "the first node must be trivially reachable" (§6.6.4, trap 9).
  struct StartState {
    zone::TrackPosition position;
    bool position_known;
    std::vector<zone::TrackPosition> also{};  ///< the same place on other sections, at a joint or on the very same line
  };
  enum class Verdict {
    accepted_new,
    accepted_update,
    ignored_same,  ///< same orderId and orderUpdateId again: the legal repair of a lost message, silence (trap 7)
  };

  /// @param supported_actions  types of node and edge actions that this vehicle performs; an order with another one is
  ///                           refused whole
  explicit OrderBook(const zone::TrafficZone& zone, std::vector<std::string> supported_actions = {});

  /// Accepts, or refuses with one of the standard's error types as code: validationError, orderError, orderUpdateError,
  /// noRouteError. A refusal changes nothing.
  [[nodiscard]] Result<Verdict> offer(const wire::Order& order, const StartState& reference);

  /// Forgets what is left, as cancelOrder wants; ids stay (trap 6). A late update of the cancelled order is refused: it
  /// would drive the vehicle on after somebody stopped it.
  void cancel();

  /// Of the places where the vehicle stood when its order was accepted, the one that the order leads from.
  [[nodiscard]] zone::TrackPosition accepted_at() const { return accepted_at_; }

  /// The vehicle finds itself elsewhere than it thought (`initPosition`, or a tag that contradicts the belief). True
  /// when the place lies on what is left of the order, which then goes on from there; false changes nothing.
  [[nodiscard]] bool relocate(zone::TrackPosition position);
  /// As initPosition tells: the node the vehicle stands on or passed last.
  void set_last_node(std::string node_id);
  /// On another map: the ids of the order before stay until there is a new one (2.1 §6.10, orderId); it is over, and
  /// its last node is none of this map's.
  void take_over_ids(const OrderBook& before);

  /// A node of the order, found on the circuit.
  struct Target {
    wire::OrderNode node;
    zone::TrackPosition position;
    double path_m;                        ///< along the order from its first node
    std::optional<double> max_speed_mps;  ///< of the edge that leads here
    std::vector<zone::SectionId> via;     ///< sections entered on the way from the node before (OrderRoute::Leg)
  };

  /// The way that the order takes over all nodes that are left, horizon too; on the section of `here`, where the
  /// vehicle is. Empty where the circuit leaves nothing to choose.
  [[nodiscard]] zone::Course course_from(zone::TrackPosition here) const;

  /// Tells how far the vehicle has come since the last call (negative: a correction backwards); returns the nodes it
  /// traversed just now, in order. A node is traversed when the vehicle's middle passes it; where the base ends already
  /// 15 mm before, because a vehicle that aims to stand on a node stands as often just before it as just behind.
  std::vector<wire::OrderNode> travelled(double distance_m);

  [[nodiscard]] bool active() const;  ///< nodes are left, released or not
  [[nodiscard]] bool base_left() const;
  /// Path distance to the last released node: what the vehicle may drive without asking. 0 without a base; after the
  /// end of the base counts as traversed, still the last millimetres to it.
  [[nodiscard]] double distance_to_base_end_m() const;
  [[nodiscard]] bool horizon_left() const;
  [[nodiscard]] std::optional<double> speed_limit_mps() const;  ///< of the edge it is on

  [[nodiscard]] const std::string& order_id() const { return order_id_; }
  [[nodiscard]] std::uint32_t order_update_id() const { return order_update_id_; }
  [[nodiscard]] const std::string& zone_set_id() const { return zone_set_id_; }
  [[nodiscard]] const std::string& last_node_id() const { return last_node_id_; }
  [[nodiscard]] std::uint32_t last_node_sequence_id() const { return last_node_sequence_id_; }
  [[nodiscard]] double since_last_node_m() const;
  [[nodiscard]] std::vector<wire::NodeState> node_states() const;
  [[nodiscard]] std::vector<wire::EdgeState> edge_states() const;
  /// The nodes that are left, in order.
  [[nodiscard]] const std::vector<Target>& targets() const { return targets_; }
  /// Along the order from its first node, as Target::path_m counts.
  [[nodiscard]] double travelled_m() const { return travelled_m_; }

 private:
  /// An order on this circuit, and where the vehicle is on it.
  struct Found {
    OrderRoute route;
    double vehicle_m;          ///< beyond the first node; negative: before it
    zone::TrackPosition from;  ///< where the vehicle is
  };
  [[nodiscard]] Result<Verdict> offer_new(const wire::Order& order, const StartState& reference);
  [[nodiscard]] Result<Verdict> offer_update(const wire::Order& order, const StartState& reference);
  /// From whichever of these places of its first node is where the vehicle is.
  [[nodiscard]] Result<Found> find(const wire::Order& order, const std::vector<zone::TrackPosition>& firsts,
                                   zone::TrackPosition now) const;
  /// Likewise, and from wherever else it stands when that is the shorter way, or the only one.
  [[nodiscard]] Result<Found> find_from_any(const wire::Order& order, const std::vector<zone::TrackPosition>& firsts,
                                            const StartState& reference) const;
  /// From whichever place of its first node, where the base ends, continues the base.
  [[nodiscard]] Result<OrderRoute> find_continuation(const wire::Order& order, std::size_t kept);
  /// The place that was found for an update's first node, and the others that go by its name.
  [[nodiscard]] std::vector<zone::TrackPosition> positions_like(zone::TrackPosition found,
                                                                const wire::Order& order) const;
  /// How far the vehicle is beyond the first node; negative: before it. noRouteError where that is too far.
  [[nodiscard]] Result<double> distance_from_first_node(const wire::OrderNode& node, const OrderRoute& route,
                                                        zone::TrackPosition now) const;
  void append(const wire::Order& order, OrderRoute&& route, double first_path_m);
  [[nodiscard]] std::size_t released_count() const;

  const zone::TrafficZone& zone_;
  std::vector<std::string> supported_actions_;
  OrderRouter router_;
  bool cancelled_{false};  ///< the order of these ids was cancelled
  std::string order_id_;
  std::uint32_t order_update_id_{0};
  std::string zone_set_id_;
  std::string last_node_id_;
  std::uint32_t last_node_sequence_id_{0};
  std::vector<Target> targets_;         ///< nodes not yet traversed
  std::vector<wire::OrderEdge> edges_;  ///< edges not yet left
  double travelled_m_{0.0};             ///< along the order, from its first node
  double last_node_path_m_{0.0};
  double base_end_path_m_{0.0};
  zone::TrackPosition last_node_position_;
  zone::TrackPosition accepted_at_;
};

}  // namespace cosiva::aiv
