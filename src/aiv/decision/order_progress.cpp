#include "cosiva/aiv/decision/order_progress.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

Result<OrderBook::Verdict> OrderProgress::offer(const wire::Order& order, const OrderBook::StartState& reference) {
  if (cancelling_) return fail("orderUpdateError", "the previous order is being cancelled");
  const bool base_before = book_.base_left();
  auto verdict = book_.offer(order, reference);
  if (!verdict || *verdict == OrderBook::Verdict::ignored_same) return verdict;
  const bool first_traversed_now = *verdict == OrderBook::Verdict::accepted_new;
  if (first_traversed_now) at_stop_ = false;
  // The vehicle is at the first node already, or was at the end of the base: the next edge begins here.
  const bool at_first = first_traversed_now || (!base_before && !at_stop_);
  const bool edge_stops =
      !order.edges.empty() && order.edges.front().released && block_driving(order.edges.front().actions);
  if (at_first && (edge_stops || (first_traversed_now && block_driving(order.nodes.front().actions)))) {
    at_stop_ = true;
    stop_path_m_ = book_.last_node().path_m;
  } else if (!at_stop_) {
    find_stop();
  }
  return verdict;
}

void OrderProgress::find_stop() {
  at_stop_ = false;
  stop_path_m_ = unlimited_m;
  for (const OrderBook::Target& target : book_.targets()) {
    if (!target.node.released) return;
    if (!target.stops) continue;
    stop_path_m_ = target.path_m;
    stop_sequence_id_ = target.node.sequence_id;
    return;
  }
}

void OrderProgress::end_stop() {
  if (at_stop_) find_stop();
}

void OrderProgress::begin_move(double distance_m) {
  COSIVA_EXPECT(distance_m > 0.0 && distance_m < unlimited_m);
  move_left_m_ = distance_m;
}

void OrderProgress::advance(double distance_m) {
  move_left_m_ -= distance_m;
  auto traversed = book_.travelled(distance_m);
  if (!traversed.empty() && stop_path_m_ < unlimited_m && book_.last_node().sequence_id >= stop_sequence_id_)
    at_stop_ = true;
  std::ranges::move(traversed, std::back_inserter(traversed_));
}

bool OrderProgress::relocate(const zone::TrackPosition* position) {
  if (!book_.active()) return false;
  if (position != nullptr && book_.relocate(*position)) return true;
  book_.cancel();
  find_stop();
  lost_ = true;
  return false;
}

bool OrderProgress::begin_cancel(bool actions_left) {
  if (cancelling_) return true;
  cancelling_ = book_.active() || actions_left;
  return cancelling_;
}

void OrderProgress::end_cancel() {
  COSIVA_EXPECT(cancelling_);
  book_.cancel();
  find_stop();
  cancelling_ = false;
}

std::vector<wire::OrderNode> OrderProgress::take_traversed() {
  std::vector<wire::OrderNode> traversed;
  traversed.swap(traversed_);
  return traversed;
}

bool OrderProgress::take_lost() { return std::exchange(lost_, false); }

void OrderProgress::archive(Archive& archive) {
  archive(book_, stop_path_m_, stop_sequence_id_, at_stop_, cancelling_, lost_, traversed_);
}

}  // namespace cosiva::aiv
