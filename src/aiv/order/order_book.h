#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/order/action_catalogue.h"
#include "cosiva/aiv/order/order_locator.h"
#include "cosiva/aiv/order/order_route.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/circuit/course.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// What identifies an order and its last update (VDA 5050 2.1 §6.10); empty before the first order.
struct OrderIds {
  std::string order_id;
  std::uint32_t order_update_id{0};
  std::string zone_set_id;
};

/// The node that the vehicle traversed last, or at which it was stopped when it accepted its order.
struct LastNode {
  std::string node_id;
  std::uint32_t sequence_id{0};
  zone::TrackPosition position;
  double path_m{0.0};  ///< along the order from its first node
};

/// The vehicle's side of an order (VDA 5050 2.1 §6.6): which nodes are accepted, released and traversed. All rules of
/// acceptance are implemented here, once; the on-board program and the virtual AIV both use this class.
/// Invariant: each remaining node has the edge that leads to it, and a refused order changes nothing.
class OrderBook {
 public:
  /// Where the vehicle is, for "the first node must be trivially reachable" (§6.6.4, trap 9).
  struct StartState {
    zone::TrackPosition position;
    bool position_known;
    std::vector<zone::TrackPosition>
        also{};                ///< the same point on other sections, at a joint or on coincident sections
    bool actions_left{false};  ///< actions of the present order have not ended (OrderActions)
  };
  enum class Verdict {
    accepted_new,
    accepted_update,
    ignored_same,  ///< same orderId and orderUpdateId again: the legal repair of a lost message, no reaction (trap 7)
  };

  /// @param catalogue  actions that this vehicle performs; an order with any other action is refused as a whole
  explicit OrderBook(const zone::TrafficZone& zone, ActionCatalogue catalogue = {});

  /// Accepts, or refuses with one of the standard's error types as code: validationError, orderError, orderUpdateError,
  /// noRouteError. A refusal changes nothing.
  [[nodiscard]] Result<Verdict> offer(const wire::Order& order, const StartState& reference);

  /// Discards the rest of the order, as cancelOrder requires; ids stay (trap 6). A late update of the cancelled order
  /// is refused, because it would restart a vehicle that was stopped deliberately.
  void cancel();

  /// Of the positions where the vehicle was stopped when its order was accepted, the one that the order starts from.
  [[nodiscard]] zone::TrackPosition accepted_at() const { return accepted_at_; }

  /// The estimated position has jumped (`initPosition`, or a tag that contradicts the estimate). True when the position
  /// lies on the rest of the order, which then continues from there; false changes nothing.
  [[nodiscard]] bool relocate(zone::TrackPosition position);
  /// From initPosition: the node at which the vehicle is stopped, or which it passed last.
  void set_last_node(std::string node_id);
  /// After a change of map: the ids of the order before stay until there is a new one (2.1 §6.10, orderId). That order
  /// is over, and its last node is not on this map.
  void take_over_ids(const OrderBook& before);

  /// A node of the order, located on the circuit.
  struct Target {
    wire::OrderNode node;
    zone::TrackPosition position;
    double path_m;                        ///< along the order from its first node
    std::optional<double> max_speed_mps;  ///< of the edge that leads here
    std::vector<zone::SectionId> via;     ///< sections entered on the route from the node before (OrderRoute::Leg)
    bool stops{false};  ///< the vehicle stops here for actions of the node or of the released edge behind it
  };

  /// The course of the order over all remaining nodes, including the horizon; starts on the section of `here`, the
  /// vehicle's position. Empty where the circuit offers no choice.
  [[nodiscard]] zone::Course course_from(zone::TrackPosition here) const;

  /// Adds the distance that the vehicle has travelled since the last call (negative: a correction backwards) and
  /// returns the nodes traversed by this step, in order. A node is traversed when the body origin passes it; at the end
  /// of the base and where it stops for actions already 15 mm before, because a vehicle that stops at a node stops as
  /// often just before the node as just behind.
  std::vector<wire::OrderNode> travelled(double distance_m);

  [[nodiscard]] bool active() const { return !targets_.empty(); }  ///< nodes remain, released or not
  [[nodiscard]] bool base_left() const;
  /// Path distance to the last released node, which the vehicle may drive without a further release. 0 without a base;
  /// when the end of the base already counts as traversed, still the last millimetres to it.
  [[nodiscard]] double distance_to_base_end_m() const { return std::max(0.0, base_end_path_m_ - travelled_m_); }
  /// How far the vehicle has driven beyond the end of its base.
  [[nodiscard]] double past_base_end_m() const { return std::max(0.0, travelled_m_ - base_end_path_m_); }
  [[nodiscard]] bool horizon_left() const { return !targets_.empty() && !targets_.back().node.released; }

  [[nodiscard]] const OrderIds& ids() const { return ids_; }
  [[nodiscard]] const LastNode& last_node() const { return last_node_; }
  [[nodiscard]] double since_last_node_m() const;
  [[nodiscard]] std::vector<wire::NodeState> node_states() const;
  [[nodiscard]] std::vector<wire::EdgeState> edge_states() const;
  /// The remaining nodes, in order.
  [[nodiscard]] const std::vector<Target>& targets() const { return targets_; }
  /// Along the order from its first node, as Target::path_m counts.
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] Result<Verdict> offer_new(const wire::Order& order, const StartState& reference);
  [[nodiscard]] Result<Verdict> offer_update(const wire::Order& order, const StartState& reference);
  void append(const wire::Order& order, OrderRoute&& route, double first_path_m);
  [[nodiscard]] std::size_t released_count() const;

  const zone::TrafficZone& zone_;
  ActionCatalogue catalogue_;
  OrderLocator locator_;
  bool cancelled_{false};  ///< the order of these ids was cancelled
  OrderIds ids_;
  LastNode last_node_;
  std::vector<Target> targets_;         ///< nodes not yet traversed
  std::vector<wire::OrderEdge> edges_;  ///< edges not yet left
  double travelled_m_{0.0};             ///< along the order, from its first node
  double base_end_path_m_{0.0};
  zone::TrackPosition accepted_at_;
};

}  // namespace cosiva::aiv
