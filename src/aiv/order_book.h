#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "wire/messages.h"
#include "zone/traffic_zone.h"

namespace cosiva::aiv {

/// The vehicle's side of an order (VDA 5050 2.1 §6.6): what was accepted, what is released, what was traversed.
/// Every rule of acceptance stands here, once; the on-board program and the virtual AIV both use it.
class OrderBook {
 public:
  /// Where the vehicle is, for "the first node must be trivially reachable" (§6.6.4, trap 9).
  struct Standing {
    zone::Place place;
    bool position_known;
  };
  enum class Verdict {
    accepted_new,
    accepted_update,
    ignored_same,  ///< same orderId and orderUpdateId again: the legal repair of a lost message, silence (trap 7)
  };

  explicit OrderBook(const zone::TrafficZone& zone);

  /// Accepts, or refuses with one of the standard's error types as code: validationError, orderError, orderUpdateError,
  /// noRouteError. A refusal changes nothing.
  [[nodiscard]] Result<Verdict> offer(const wire::Order& order, const Standing& standing);

  /// Forgets what is left, as cancelOrder wants; ids stay (trap 6).
  void cancel();

  /// A node of the order, found on the circuit.
  struct Target {
    wire::OrderNode node;
    zone::Place place;
    double path_m;                        ///< along the order from its first node
    std::optional<double> max_speed_mps;  ///< of the edge that leads here
  };

  /// Tells how far the vehicle has come; returns the nodes it traversed just now, in order.
  std::vector<wire::OrderNode> travelled(double distance_m);

  [[nodiscard]] bool active() const;  ///< nodes are left, released or not
  [[nodiscard]] bool base_left() const;
  /// Path distance to the last released node that is left; 0 when none is. What the vehicle may drive without asking.
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
  /// All actions of nodes and edges that are left, in order, with the node or edge they belong to.
  [[nodiscard]] const std::vector<Target>& targets() const { return targets_; }

 private:
  const zone::TrafficZone& zone_;
  std::string order_id_;
  std::uint32_t order_update_id_{0};
  std::string zone_set_id_;
  std::string last_node_id_;
  std::uint32_t last_node_sequence_id_{0};
  std::vector<Target> targets_;         ///< nodes not yet traversed
  std::vector<wire::OrderEdge> edges_;  ///< edges not yet left
  double travelled_m_{0.0};             ///< along the order, from its first node
  double last_node_path_m_{0.0};
};

}  // namespace cosiva::aiv
