#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// The next part of a vehicle's order, from the end of the present base, or from the first node of a new order. Valid
/// until the next extension is computed.
struct BaseExtension {
  using Stretches = std::span<const WaypointGraph::Stretch* const>;
  WaypointIndex from{no_waypoint};
  double to_first_m{};  ///< distance of the vehicle from the first node of a new order; 0 for an update
  Stretches base;       ///< released
  Stretches horizon;    ///< announced beyond the base
};

/// The VDA 5050 order of one vehicle: its messages, their acknowledgement, refusal and cancellation. One update is
/// pending at a time, and is repeated, with the same content under a new header, until the vehicle's state acknowledges
/// it.
///
/// Invariant: a session without an order has no order id, nothing to repeat and no pending cancelOrder.
class OrderSession {
 public:
  enum class Stage : std::uint8_t { none, running, cancelling };
  /// What the caller has to do after a state: drop() the order, take over the order that the vehicle reports, or both.
  enum class Next : std::uint8_t { nothing, drop, adopt, drop_then_adopt };

  OrderSession(OrderContext& context, VehicleIndex vehicle) : context_{&context}, vehicle_{vehicle} {}

  [[nodiscard]] Stage stage() const { return stage_; }
  [[nodiscard]] bool is_running() const { return stage_ == Stage::running; }
  [[nodiscard]] bool awaits_acknowledgement() const { return stage_ == Stage::running && !acknowledged_; }
  /// The end of the base sent last; no_waypoint: none.
  [[nodiscard]] WaypointIndex base_end() const { return base_end_; }
  [[nodiscard]] bool has_horizon() const { return has_horizon_; }
  [[nodiscard]] SimTime sent_at() const { return sent_at_; }
  /// No order is sent before this time.
  [[nodiscard]] SimTime wait_until() const { return wait_until_; }

  /// Compares the order with a state of the vehicle. `before` is the previous state, if any.
  [[nodiscard]] Next on_state(const wire::State& state, const wire::State* before);
  /// Whether the vehicle's order leads over nodes of this zone; another order is logged once.
  [[nodiscard]] bool can_take_over(const wire::State& state);
  /// Continues the order that the vehicle reports, which can_take_over() accepts.
  /// @param base_end  the end of its base, where the course determines it; nothing: the first waypoint of that name
  void take_over(const wire::State& state, std::optional<WaypointIndex> base_end);

  /// Sends a new order, or an update of the present one. True: a new order.
  bool send(const BaseExtension& extension);
  /// Repeats the pending message when it is due. True: repeated.
  bool repeat_when_due();
  void cancel();
  /// Cancels, and sends no order until the time that follows a refusal is over.
  void cancel_and_pause();
  void cancel_again_when_due();
  /// Another sender has cancelled: the order gets no more updates.
  void stop_extending();
  void drop();
  /// The order refers to a zone that is no longer in force.
  void leave_zone();
  /// The base ends at another waypoint of the same node.
  void set_base_end(WaypointIndex end);
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  Next follow(const wire::State& state);
  Next give_up(const wire::State& state, const std::string& why);
  /// Whether the vehicle refused the pending message; `why` is then set.
  bool refused(const wire::State& state, const wire::State* before, std::string& why) const;
  [[nodiscard]] wire::Order make_order(const BaseExtension& extension);

  OrderContext* context_;
  VehicleIndex vehicle_;
  Stage stage_{Stage::none};
  std::string order_id_;
  std::uint32_t update_id_{0};
  bool acknowledged_{false};
  bool ever_acknowledged_{false};
  WaypointIndex base_end_{no_waypoint};
  std::uint32_t base_end_sequence_{0};
  bool has_horizon_{false};           ///< the last order announces nodes beyond its base
  MessagePublisher::SentOrder sent_;  ///< the last order sent by this server
  SimTime sent_at_{};
  SimTime wait_until_{};
  struct Cancellation {
    SimTime at{};
    InstantActionSender::ActionHandle handle{0};  ///< of the pending cancelOrder; 0: none
  };
  Cancellation cancellation_;
  struct LoggedOrders {
    std::string strange;  ///< of another sender, over nodes that are not this zone's
    std::string foreign;  ///< of another sender, or extended by one
  };
  LoggedOrders logged_;  ///< orders that are logged once
};

}  // namespace cosiva::virtual_side
