#include "cosiva/virtual/server/orders/order_manager.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void OrderManager::set_map(const WaypointGraph* map) {
  context_.map = map;
  for (VehicleIndex v = 0; v < sessions_.size(); ++v) {
    joins_.end(v);
    positions_.forget(v);
    planner_.forget(v);
    yielding_.end(v);
    // An order on the old zone is not valid on the new one.
    sessions_[v].leave_zone();
  }
  planned_.set_map(map);
}

void OrderManager::resize(std::size_t vehicles) {
  while (sessions_.size() < vehicles) sessions_.emplace_back(context_, static_cast<VehicleIndex>(sessions_.size()));
  positions_.resize(vehicles);
  records_.resize(vehicles);
  joins_.resize(vehicles);
  analysis_.resize(vehicles);
  planner_.resize(vehicles);
  yielding_.resize(vehicles);
  planned_.resize(vehicles);
  COSIVA_EXPECT(sessions_.size() == positions_.size());
}

void OrderManager::forget(VehicleIndex vehicle) {
  sessions_[vehicle] = OrderSession{context_, vehicle};
  positions_.forget(vehicle);
  records_.forget(vehicle);
  joins_.forget(vehicle);
  analysis_.forget(vehicle);
  planner_.forget(vehicle);
  yielding_.forget(vehicle);
  planned_.forget(vehicle);
}

void OrderManager::on_state(VehicleIndex vehicle, const wire::State* before) {
  if (context_.map == nullptr) return;
  const wire::State& state = *context_.registry[vehicle].state();
  const OrderSession::Next next = sessions_[vehicle].on_state(state, before);
  if (next == OrderSession::Next::drop || next == OrderSession::Next::drop_then_adopt) drop(vehicle);
  if (next == OrderSession::Next::adopt || next == OrderSession::Next::drop_then_adopt) adopt(vehicle, state);
}

void OrderManager::adopt(VehicleIndex vehicle, const wire::State& state) {
  OrderSession& session = sessions_[vehicle];
  planned_.forget(vehicle);  // the order leads where the plan does not know
  if (session.can_take_over(state))
    session.take_over(state, planner_.adopt_course(vehicle, state));
  else
    drop(vehicle);
}

void OrderManager::drop(VehicleIndex vehicle) {
  yielding_.end_moving_up(vehicle);
  joins_.end(vehicle);
  sessions_[vehicle].drop();
}

void OrderManager::tick(bool drive, bool send_off, SimDuration lost_after) {
  if (context_.map == nullptr) return;
  context_.lost_after = lost_after;
  context_.traffic.update();
  joins_.find_neighbours();
  if (drive && planned_.in_force()) planned_.update();
  for (VehicleIndex v = 0; v < sessions_.size(); ++v) {
    context_.traffic.update();
    step(v, drive, send_off);
  }
}

void OrderManager::step(VehicleIndex vehicle, bool drive, bool send_off) {
  OrderSession& session = sessions_[vehicle];
  const SimTime now = context_.publisher.now();
  if (session.awaits_acknowledgement()) {
    if (session.repeat_when_due()) ++counters_.repeated;
    return;
  }
  session.cancel_again_when_due();
  if (session.is_running() && analysis_.is_stopped_without_reason(vehicle)) {
    context_.publisher.log('w', context_.registry[vehicle].name() +
                                    ": is stopped with base ahead and reports no reason; cancelled, a new order "
                                    "follows");
    session.cancel();
  }

  records_.begin(vehicle);
  if (stays(vehicle, drive, send_off)) {
    context_.traffic.withdraw(vehicle);  // a vehicle that cannot use its turn must not block others
    records_.end(vehicle);
    return;
  }
  if (session.is_running() && now - session.sent_at() < context_.rules.update_period) return;
  if (joins_.continue_joining(vehicle)) return;
  const std::optional<BaseExtension> extension =
      planned_.in_force() ? planned_.extend(vehicle) : follower_.extend(vehicle);
  if (extension) ++(session.send(*extension) ? counters_.orders : counters_.updates);
  if (session.stage() == OrderSession::Stage::none) follower_.keep_off_path(vehicle);
  records_.record(vehicle, !extension || extension->base.empty(), now);
  if (session.stage() == OrderSession::Stage::none && !planned_.in_force()) joins_.try_other_positions(vehicle);
}

bool OrderManager::stays(VehicleIndex vehicle, bool drive, bool send_off) {
  using Stage = OrderSession::Stage;
  const OrderSession& session = sessions_[vehicle];
  const AivProxy& proxy = context_.registry[vehicle];
  const bool idle = session.stage() == Stage::none;
  const bool busy_elsewhere = idle && proxy.state() && !proxy.state()->node_states.empty();
  // By plan, a vehicle at its goal makes room for others.
  const bool stays_there = idle && (!send_off || (!planned_.in_force() && planner_.stays_at_goal(vehicle)));
  // The vehicle's yielding continues in each tick, whatever else keeps the vehicle from driving.
  const bool keeps_still = yielding_.continue_yielding(vehicle);
  return !drive || session.stage() == Stage::cancelling || busy_elsewhere || stays_there || keeps_still ||
         !follower_.may_extend(vehicle) || context_.publisher.now() < session.wait_until();
}

void OrderManager::fold(Digest& digest) const {
  for (VehicleIndex v = 0; v < sessions_.size(); ++v) {
    sessions_[v].fold(digest);
    digest.add(static_cast<std::uint64_t>(yielding_.yields(v)));
  }
  digest.add(counters_.orders);
  digest.add(counters_.updates);
  digest.add(counters_.repeated);
}

void OrderManager::archive(Archive& archive) {
  const std::size_t vehicles = archive.count(sessions_.size());
  if (archive.reads()) resize(vehicles);
  for (OrderSession& session : sessions_) archive(session);
  archive(context_.lost_after, positions_, records_, joins_, analysis_, planner_, yielding_, counters_, planned_);
}

}  // namespace cosiva::virtual_side
