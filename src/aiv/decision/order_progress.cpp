#include "cosiva/aiv/decision/order_progress.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

Result<OrderBook::Verdict> OrderProgress::offer(const wire::Order& order, const OrderBook::StartState& reference) {
  if (cancelling_) return fail("orderUpdateError", "the previous order is being cancelled");
  return book_.offer(order, reference);
}

void OrderProgress::begin_move(double distance_m) {
  COSIVA_EXPECT(distance_m > 0.0 && distance_m < unlimited_m);
  move_left_m_ = distance_m;
}

void OrderProgress::advance(double distance_m) {
  move_left_m_ -= distance_m;
  auto traversed = book_.travelled(distance_m);
  std::ranges::move(traversed, std::back_inserter(traversed_));
}

bool OrderProgress::relocate(const zone::TrackPosition* position) {
  if (!book_.active()) return false;
  if (position != nullptr && book_.relocate(*position)) return true;
  book_.cancel();
  lost_ = true;
  return false;
}

bool OrderProgress::begin_cancel() {
  if (cancelling_) return true;
  cancelling_ = book_.active();
  return cancelling_;
}

void OrderProgress::end_cancel() {
  COSIVA_EXPECT(cancelling_);
  book_.cancel();
  cancelling_ = false;
}

std::vector<wire::OrderNode> OrderProgress::take_traversed() {
  std::vector<wire::OrderNode> traversed;
  traversed.swap(traversed_);
  return traversed;
}

bool OrderProgress::take_lost() { return std::exchange(lost_, false); }

void OrderProgress::archive(Archive& archive) { archive(book_, cancelling_, lost_, traversed_); }

}  // namespace cosiva::aiv
