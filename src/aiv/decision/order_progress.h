#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/order/order_book.h"
#include "cosiva/base/archive_fwd.h"

namespace cosiva::aiv {

/// The vehicle's order while the vehicle drives: the nodes traversed, a cancelOrder that waits until the vehicle has
/// stopped, and an order lost because the position proved wrong.
/// A move is in no snapshot: it is commanded by an experiment, which repeats its run after a restart.
/// A node with SOFT or HARD actions (VDA 5050 2.1 §6.12) is a stop until end_stop().
/// Invariant: a cancelOrder is pending only after an order was active or had actions left; no order is accepted
/// meanwhile.
class OrderProgress {
 public:
  explicit OrderProgress(const zone::TrafficZone& zone, ActionCatalogue catalogue = {})
      : book_{zone, std::move(catalogue)} {}

  /// As OrderBook::offer(); fails ("orderUpdateError") while a cancelOrder is pending.
  [[nodiscard]] Result<OrderBook::Verdict> offer(const wire::Order& order, const OrderBook::StartState& reference);
  /// The vehicle has come `distance_m` further; negative: a correction backwards.
  void advance(double distance_m);
  /// The estimated position has jumped to `place`; null: there is none. True: an order is active and continues from
  /// there. An order that does not contain the position is dropped, and take_lost() reports it.
  [[nodiscard]] bool relocate(const zone::TrackPosition* position);
  /// False: there is no order to cancel.
  /// @param actions_left  actions of the order have not ended
  [[nodiscard]] bool begin_cancel(bool actions_left = false);
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
  /// To the next node on the base at which the vehicle stops for actions, or where it has stopped for them; infinite:
  /// there is none.
  [[nodiscard]] double stop_left_m() const { return std::max(0.0, stop_path_m_ - book_.travelled_m()); }
  /// The vehicle has stopped at this node for actions, or is about to.
  [[nodiscard]] bool at_stop() const { return at_stop_; }
  /// The actions have ended.
  void end_stop();
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
  /// The next stop for actions on the remaining base.
  void find_stop();

  OrderBook book_;
  double move_left_m_{unlimited_m};
  double stop_path_m_{unlimited_m};    ///< along the order from its first node
  std::uint32_t stop_sequence_id_{0};  ///< of the node there
  bool at_stop_{false};                ///< the node there is traversed
  bool cancelling_{false};
  bool lost_{false};
  std::vector<wire::OrderNode> traversed_;
};

}  // namespace cosiva::aiv
