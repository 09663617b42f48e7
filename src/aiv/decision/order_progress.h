#pragma once

#include <limits>
#include <string>
#include <vector>

#include "cosiva/aiv/order/order_book.h"
#include "cosiva/base/archive_fwd.h"

namespace cosiva::aiv {

/// The vehicle's order while the vehicle drives: the nodes traversed, a cancelOrder that waits until the vehicle has
/// stopped, and an order lost because the position proved wrong.
/// A move is in no snapshot: it is commanded by an experiment, which repeats its run after a restart.
/// Invariant: a cancelOrder is pending only after an order was active; no order is accepted meanwhile.
class OrderProgress {
 public:
  explicit OrderProgress(const zone::TrafficZone& zone) : book_{zone} {}

  /// As OrderBook::offer(); fails ("orderUpdateError") while a cancelOrder is pending.
  [[nodiscard]] Result<OrderBook::Verdict> offer(const wire::Order& order, const OrderBook::StartState& reference);
  /// The vehicle has come `distance_m` further; negative: a correction backwards.
  void advance(double distance_m);
  /// The estimated position has jumped to `place`; null: there is none. True: an order is active and continues from
  /// there. An order that does not contain the position is dropped, and take_lost() reports it.
  [[nodiscard]] bool relocate(const zone::TrackPosition* position);
  /// False: there is no order to cancel.
  [[nodiscard]] bool begin_cancel();
  [[nodiscard]] bool cancelling() const { return cancelling_; }
  /// The vehicle has stopped: drops the order whose cancellation is pending.
  void end_cancel();
  /// move: the vehicle drives this far along its order, and stops there until another move or end_move().
  void begin_move(double distance_m);
  void end_move() { move_left_m_ = unlimited_m; }
  /// To the end of the commanded move; infinite: no move is commanded, the order alone leads.
  [[nodiscard]] double move_left_m() const { return move_left_m_; }
  [[nodiscard]] bool moving() const {
    return move_left_m_ < unlimited_m;
  }  ///< a move is commanded, or has been reached
  void set_last_node(std::string node_id) { book_.set_last_node(std::move(node_id)); }
  /// As OrderBook::take_over_ids().
  void take_over_ids(const OrderProgress& before) { book_.take_over_ids(before.book_); }

  [[nodiscard]] const OrderBook& book() const { return book_; }
  /// Nodes traversed since the last call, in order.
  [[nodiscard]] std::vector<wire::OrderNode> take_traversed();
  /// True once after an order was lost.
  [[nodiscard]] bool take_lost();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  static constexpr double unlimited_m = std::numeric_limits<double>::infinity();
  OrderBook book_;
  double move_left_m_{unlimited_m};
  bool cancelling_{false};
  bool lost_{false};
  std::vector<wire::OrderNode> traversed_;
};

}  // namespace cosiva::aiv
