#include "cosiva/virtual/server/orders/order_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::array<std::string_view, 4> refusals{"orderError", "orderUpdateError", "noRouteError", "validationError"};

std::optional<std::string_view> reference(const wire::VehicleError& error, std::string_view key) {
  const auto it = std::ranges::find(error.references, key, &wire::Reference::key);
  if (it == error.references.end()) return std::nullopt;
  return it->value;
}

/// The end of the base that the vehicle reports: the last remaining released node, otherwise the last passed node.
std::pair<std::string_view, std::uint32_t> base_end_of(const wire::State& state) {
  for (auto node = state.node_states.rbegin(); node != state.node_states.rend(); ++node)
    if (node->released) return {node->node_id, node->sequence_id};
  return {state.last_node_id, state.last_node_sequence_id};
}

}  // namespace

// --- states of the vehicle ------------------------------------------------------------------------------------------

OrderSession::Next OrderSession::on_state(const wire::State& state, const wire::State* before) {
  std::string why;
  if (awaits_acknowledgement() && refused(state, before, why)) return give_up(state, why);
  switch (stage_) {
    case Stage::cancelling: return state.node_states.empty() ? Next::drop : Next::nothing;
    case Stage::running: return follow(state);
    case Stage::none: break;
  }
  return state.node_states.empty() ? Next::nothing : Next::adopt;
}

OrderSession::Next OrderSession::follow(const wire::State& state) {
  if (state.order_id != order_id_) {
    // The vehicle has not received this order yet; but if it had received it, or follows another order, this order is
    // void.
    if (!ever_acknowledged_ && state.node_states.empty()) return Next::nothing;
    return state.node_states.empty() ? Next::drop : Next::drop_then_adopt;
  }
  ever_acknowledged_ = true;
  if (state.order_update_id < update_id_) {
    acknowledged_ = false;
    return Next::nothing;
  }
  const auto [end_id, end_sequence] = base_end_of(state);
  const bool same_end = state.order_update_id == update_id_ && end_sequence == base_end_sequence_;
  if (state.node_states.empty()) {
    // The order was cancelled by another sender, lost in a restart, or driven to a dead end.
    const bool route_continues = !context_->map->stretches(base_end_).empty();
    return route_continues || same_end ? Next::drop : Next::nothing;
  }
  if (same_end) {
    acknowledged_ = true;
    context_->traffic.set_base_passed(vehicle_, !state.node_states.front().released);
    return Next::nothing;
  }
  // Another sender may extend the order with every state: logged once per order.
  if (std::exchange(logged_.foreign, order_id_) == order_id_) return Next::adopt;
  context_->publisher.log('w', context_->registry[vehicle_].name() + ": follows update " +
                                   std::to_string(state.order_update_id) + " up to " + std::string(end_id) +
                                   ", which this server did not send; taking it over");
  return Next::adopt;
}

bool OrderSession::refused(const wire::State& state, const wire::State* before, std::string& why) const {
  for (const wire::VehicleError& error : state.errors) {
    if (std::ranges::find(refusals, error.type) == refusals.end()) continue;
    const auto order = reference(error, "orderId");
    const auto update = reference(error, "orderUpdateId");
    if (order) {
      if (*order != order_id_ || (update && *update != std::to_string(update_id_))) continue;
    } else if (before != nullptr && std::ranges::find(before->errors, error) != before->errors.end()) {
      continue;  // an old warning (it remains until a new order is accepted)
    } else if (state.order_id == order_id_ && state.order_update_id >= update_id_) {
      continue;
    }
    why = error.type + ": " + error.description;
    return true;
  }
  return false;
}

OrderSession::Next OrderSession::give_up(const wire::State& state, const std::string& why) {
  context_->publisher.log('w', context_->registry[vehicle_].name() + ": refused order '" + order_id_ + "' update " +
                                   std::to_string(update_id_) + " (" + why + "); a new one follows");
  if (!state.node_states.empty()) {
    cancel_and_pause();
    return Next::nothing;
  }
  wait_until_ = context_->publisher.now() + context_->rules.after_refusal;
  return Next::drop;
}

bool OrderSession::can_take_over(const wire::State& state) {
  const WaypointGraph& map = *context_->map;
  const bool is_cosiva = !map.find(base_end_of(state).first).empty() &&
                         std::ranges::all_of(state.node_states, [&](const wire::NodeState& node) {
                           return !map.find(node.node_id).empty();
                         });
  if (is_cosiva && !state.order_id.empty()) return true;
  if (logged_.strange != state.order_id) {
    logged_.strange = state.order_id;
    context_->publisher.log('i', context_->registry[vehicle_].name() + ": follows order '" + state.order_id +
                                     "' over nodes that are not this zone's; left alone until it is done");
  }
  return false;
}

void OrderSession::take_over(const wire::State& state, std::optional<WaypointIndex> base_end) {
  const auto [end_id, end_sequence] = base_end_of(state);
  stage_ = Stage::running;
  order_id_ = state.order_id;
  update_id_ = state.order_update_id;
  acknowledged_ = true;
  ever_acknowledged_ = true;
  base_end_sequence_ = end_sequence;
  sent_.reset();
  set_base_end(base_end.value_or(context_->map->find(end_id).front()));
  context_->traffic.set_base_passed(vehicle_, !state.node_states.front().released);
  if (std::exchange(logged_.foreign, order_id_) == order_id_) return;
  context_->publisher.log('i', context_->registry[vehicle_].name() + ": took over order '" + order_id_ + "', update " +
                                   std::to_string(update_id_) + ", base up to " + std::string(end_id));
}

// --- orders to the vehicle ------------------------------------------------------------------------------------------

bool OrderSession::send(const BaseExtension& extension) {
  const bool is_new = stage_ == Stage::none;
  AivProxy& proxy = context_->registry[vehicle_];
  if (is_new) {
    COSIVA_EXPECT(order_id_.empty() && !sent_ && cancellation_.handle == 0);
    order_id_ = unique_id(proxy.id().serial_number, context_->publisher.now());
    update_id_ = 0;
    base_end_sequence_ = 0;
    ever_acknowledged_ = false;
  } else {
    ++update_id_;
  }
  wire::Order order = make_order(extension);
  const WaypointGraph& map = *context_->map;
  const WaypointIndex last = extension.horizon.empty() ? base_end_ : extension.horizon.back()->to;
  const std::string summary = order_id_ + " update " + std::to_string(update_id_) + ": base " +
                              map.waypoint(extension.from).id + " to " + map.waypoint(base_end_).id + ", horizon to " +
                              map.waypoint(last).id;
  sent_ = context_->publisher.send(proxy, std::move(order), summary);
  stage_ = Stage::running;
  acknowledged_ = false;
  sent_at_ = context_->publisher.now();
  context_->traffic.set_base_end(vehicle_, base_end_);
  return is_new;
}

wire::Order OrderSession::make_order(const BaseExtension& extension) {
  const WaypointGraph& map = *context_->map;
  const OrderRules& rules = context_->rules;
  wire::Order order;
  order.order_id = order_id_;
  order.order_update_id = update_id_;
  order.nodes.reserve(1 + extension.base.size() + rules.horizon);
  order.edges.reserve(extension.base.size() + rules.horizon);
  std::uint32_t sequence = base_end_sequence_;
  const auto add_node = [&](WaypointIndex index, bool released, double deviation_m) {
    const Point2 point = map.point(index);
    order.nodes.push_back({map.waypoint(index).id,
                           sequence,
                           released,
                           wire::NodePosition{point.x_m, point.y_m, {}, deviation_m, {}, map.zone().name},
                           {}});
  };
  add_node(extension.from, true, rules.deviation_m + extension.to_first_m);

  WaypointIndex at = extension.from;
  const auto add_stretch = [&](const WaypointGraph::Stretch& stretch, bool released) {
    order.edges.push_back({stretch.edge_id,
                           sequence + 1,
                           released,
                           map.waypoint(at).id,
                           map.waypoint(stretch.to).id,
                           stretch.speed_mps_max.value_or(map.zone().profiles.fast.speed_mps),
                           stretch.length_m,
                           {},
                           map.zone().circuit.indirect() ? std::optional{true} : std::nullopt,
                           {}});
    sequence += 2;
    add_node(stretch.to, released, rules.deviation_m);
    at = stretch.to;
  };
  for (const WaypointGraph::Stretch* stretch : extension.base) add_stretch(*stretch, true);
  base_end_ = at;
  base_end_sequence_ = sequence;
  for (const WaypointGraph::Stretch* stretch : extension.horizon) add_stretch(*stretch, false);
  has_horizon_ = !order.nodes.back().released;
  return order;
}

bool OrderSession::repeat_when_due() {
  AivProxy& proxy = context_->registry[vehicle_];
  const SimTime now = context_->publisher.now();
  if (now - sent_at_ < context_->rules.resend_after || !proxy.online() || !sent_) return false;
  sent_at_ = now;
  context_->publisher.send_again(proxy, sent_);
  return true;
}

void OrderSession::set_base_end(WaypointIndex end) {
  base_end_ = end;
  context_->traffic.set_base_end(vehicle_, end);
}

// --- the end of the order -------------------------------------------------------------------------------------------

void OrderSession::cancel() {
  COSIVA_EXPECT(stage_ != Stage::none);
  stage_ = Stage::cancelling;
  cancellation_.at = context_->publisher.now();
  if (cancellation_.handle != 0) context_->action_sender.drop(cancellation_.handle);
  cancellation_.handle = context_->action_sender.send(context_->registry[vehicle_], vehicle_,
                                                      {{"cancelOrder", {}, {}, wire::BlockingType::hard, {}}},
                                                      std::chrono::seconds{3}, false);
}

void OrderSession::cancel_and_pause() {
  cancel();
  wait_until_ = context_->publisher.now() + context_->rules.after_refusal;
}

void OrderSession::cancel_again_when_due() {
  if (stage_ == Stage::cancelling && context_->publisher.now() - cancellation_.at >= context_->rules.cancel_again &&
      context_->registry[vehicle_].online())
    cancel();
}

void OrderSession::stop_extending() {
  if (stage_ != Stage::running) return;
  stage_ = Stage::cancelling;
  cancellation_.at = context_->publisher.now();
}

void OrderSession::drop() {
  stage_ = Stage::none;
  order_id_.clear();
  sent_.reset();
  acknowledged_ = false;
  ever_acknowledged_ = false;
  // A repeated cancelOrder would cancel the next order.
  if (cancellation_.handle != 0) context_->action_sender.drop(std::exchange(cancellation_.handle, 0));
  set_base_end(no_waypoint);
}

void OrderSession::leave_zone() {
  base_end_ = no_waypoint;
  if (stage_ == Stage::running) cancel();
}

void OrderSession::fold(Digest& digest) const {
  digest.add(static_cast<std::uint64_t>(stage_));
  digest.add(std::string_view{order_id_});
  digest.add(std::uint64_t{update_id_});
  digest.add(std::uint64_t{base_end_});
}

void OrderSession::archive(Archive& archive) {
  archive(stage_, order_id_, update_id_, acknowledged_, ever_acknowledged_, base_end_, base_end_sequence_, has_horizon_,
          sent_, sent_at_, wait_until_, cancellation_, logged_);
}

}  // namespace cosiva::virtual_side
