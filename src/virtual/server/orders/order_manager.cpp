#include "cosiva/virtual/server/orders/order_manager.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cosiva/base/math.h"

namespace cosiva::virtual_side {
namespace {

/// With a heading error beyond this a vehicle is not aligned with its section and cannot follow it.
constexpr double heading_off_rad_max = pi / 3.0;

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

void OrderManager::set_map(const WaypointGraph* map) {
  map_ = map;
  for (VehicleIndex v = 0; v < plans_.size(); ++v) {
    plans_[v].reported = {};
    plans_[v].base_end = no_waypoint;
    plans_[v].route_of = 0;
    plans_[v].no_route.reset();
    end_join(v);
    end_yielding(v);
    // An order on the old zone is not valid on the new one.
    if (plans_[v].stage == Plan::Stage::running) cancel(v);
  }
}

void OrderManager::set_reported_pose(VehicleIndex vehicle, const ReportedPose& reported) {
  plans_[vehicle].reported = reported;
  follow_line(vehicle);
  const ReportedPose& now = plans_[vehicle].reported;
  // A CoSiVA vehicle that is to join the path keeps others away by its body until it is sent.
  const bool is_obstructing =
      now.position && (plans_[vehicle].entry_point || (now.off_m <= rules_.on_path_m && !goes_onto_line(vehicle)));
  if (now.position) traffic_.follow(vehicle, *now.position);
  traffic_.set_position(vehicle, is_obstructing ? now.position : std::nullopt);
}

void OrderManager::on_state(VehicleIndex vehicle, const wire::State* before) {
  if (map_ == nullptr) return;
  Plan& plan = plans_[vehicle];
  const wire::State& state = *registry_[vehicle].state;
  std::string why;
  if (plan.stage == Plan::Stage::running && !plan.acknowledged && refused(plan, state, before, why)) {
    give_up(vehicle, state, why);
    return;
  }
  switch (plan.stage) {
    case Plan::Stage::cancelling:
      if (state.node_states.empty()) drop(plan, vehicle);
      break;
    case Plan::Stage::running: follow(vehicle, state); break;
    case Plan::Stage::none:
      if (!state.node_states.empty()) adopt(vehicle, state);
      break;
  }
}

void OrderManager::follow(VehicleIndex vehicle, const wire::State& state) {
  Plan& plan = plans_[vehicle];
  if (state.order_id != plan.order_id) {
    // The vehicle has not received this order yet; but if it had received it, or follows another order, this order is
    // void.
    if (!plan.ever_acknowledged && state.node_states.empty()) return;
    drop(plan, vehicle);
    if (!state.node_states.empty()) adopt(vehicle, state);
    return;
  }
  plan.ever_acknowledged = true;
  if (state.order_update_id < plan.update_id) {
    plan.acknowledged = false;
    return;
  }
  const auto [end_id, end_sequence] = base_end_of(state);
  const bool same_end = state.order_update_id == plan.update_id && end_sequence == plan.base_end_sequence;
  if (state.node_states.empty()) {
    // The order was cancelled by another sender, lost in a restart, or driven to a dead end.
    const bool route_continues = !map_->stretches(plan.base_end).empty();
    if (route_continues || same_end) drop(plan, vehicle);
    return;
  }
  if (same_end) {
    plan.acknowledged = true;
    traffic_.set_base_passed(vehicle, !state.node_states.front().released);
    return;
  }
  publisher_.log('w', registry_[vehicle].name + ": follows update " + std::to_string(state.order_update_id) +
                          " up to " + std::string(end_id) + ", which this server did not send; taking it over");
  adopt(vehicle, state);
}

void OrderManager::adopt(VehicleIndex vehicle, const wire::State& state) {
  Plan& plan = plans_[vehicle];
  const auto [end_id, end_sequence] = base_end_of(state);
  const auto ends = map_->find(end_id);
  const bool is_cosiva = !ends.empty() && std::ranges::all_of(state.node_states, [&](const wire::NodeState& node) {
    return !map_->find(node.node_id).empty();
  });
  if (!is_cosiva || state.order_id.empty()) {
    if (plan.strange_order != state.order_id) {
      plan.strange_order = state.order_id;
      publisher_.log('i', registry_[vehicle].name + ": follows order '" + state.order_id +
                              "' over nodes that are not this zone's; left alone until it is done");
    }
    drop(plan, vehicle);
    return;
  }
  plan.stage = Plan::Stage::running;
  plan.order_id = state.order_id;
  plan.update_id = state.order_update_id;
  plan.acknowledged = true;
  plan.ever_acknowledged = true;
  plan.base_end = adopt_course(vehicle, state).value_or(ends.front());
  plan.base_end_sequence = end_sequence;
  plan.sent.reset();
  traffic_.set_base_end(vehicle, plan.base_end);
  traffic_.set_base_passed(vehicle, !state.node_states.front().released);
  publisher_.log('i', registry_[vehicle].name + ": took over order '" + plan.order_id + "', update " +
                          std::to_string(plan.update_id) + ", base up to " + std::string(end_id));
}

std::optional<WaypointIndex> OrderManager::adopt_course(VehicleIndex vehicle, const wire::State& state) {
  Plan& plan = plans_[vehicle];
  plan.route_of = 0;
  if (!plan.reported.position) return std::nullopt;
  std::vector<std::string_view> ids;
  std::size_t released = 0;
  for (const wire::NodeState& node : state.node_states) {
    ids.emplace_back(node.node_id);
    if (node.released) released = ids.size();
  }
  if (released == 0) return std::nullopt;
  auto through = map_->through(*plan.reported.position, ids, released);
  if (!through) return std::nullopt;
  // The mission determines the course beyond the base.
  through->sections.resize(through->to_end);
  take_course(vehicle, zone::Course(std::move(through->sections)));
  return through->end;
}

bool OrderManager::refused(const Plan& plan, const wire::State& state, const wire::State* before,
                           std::string& why) const {
  for (const wire::VehicleError& error : state.errors) {
    if (std::ranges::find(refusals, error.type) == refusals.end()) continue;
    const auto order = reference(error, "orderId");
    const auto update = reference(error, "orderUpdateId");
    if (order) {
      if (*order != plan.order_id || (update && *update != std::to_string(plan.update_id))) continue;
    } else if (before != nullptr && std::ranges::find(before->errors, error) != before->errors.end()) {
      continue;  // an old warning (it remains until a new order is accepted)
    } else if (state.order_id == plan.order_id && state.order_update_id >= plan.update_id) {
      continue;
    }
    why = error.type + ": " + error.description;
    return true;
  }
  return false;
}

void OrderManager::give_up(VehicleIndex vehicle, const wire::State& state, const std::string& why) {
  Plan& plan = plans_[vehicle];
  publisher_.log('w', registry_[vehicle].name + ": refused order '" + plan.order_id + "' update " +
                          std::to_string(plan.update_id) + " (" + why + "); a new one follows");
  if (state.node_states.empty())
    drop(plan, vehicle);
  else
    cancel(vehicle);
  plan.wait_until = publisher_.now() + rules_.after_refusal;
}

void OrderManager::drop(Plan& plan, VehicleIndex vehicle) {
  plan.stage = Plan::Stage::none;
  plan.order_id.clear();
  plan.sent.reset();
  plan.acknowledged = false;
  plan.ever_acknowledged = false;
  plan.base_end = no_waypoint;
  plan.moves_up = false;
  end_join(vehicle);
  // A repeated cancelOrder would cancel the next order.
  if (plan.cancel_handle != 0) action_sender_.drop(std::exchange(plan.cancel_handle, 0));
  traffic_.set_base_end(vehicle, no_waypoint);
}

void OrderManager::cancel(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  plan.stage = Plan::Stage::cancelling;
  plan.cancelled_at = publisher_.now();
  if (plan.cancel_handle != 0) action_sender_.drop(plan.cancel_handle);
  plan.cancel_handle =
      action_sender_.send(registry_[vehicle], vehicle, {{"cancelOrder", {}, {}, wire::BlockingType::hard, {}}},
                          std::chrono::seconds{3}, false);
}

void OrderManager::stop_rolling(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  if (plan.stage != Plan::Stage::running) return;
  plan.stage = Plan::Stage::cancelling;
  plan.cancelled_at = publisher_.now();
}

void OrderManager::tick(bool drive, bool send_off, SimDuration lost_after) {
  if (map_ == nullptr) return;
  lost_after_ = lost_after;
  traffic_.update();
  neighbour_.clear();
  for (VehicleIndex v = 0; v < plans_.size(); ++v)
    if (registry_[v].here() && (!plans_[v].reported.position || off_path(v) || traffic_.is_in_others_crossing(v)))
      neighbour_.push_back(v);
  for (VehicleIndex v = 0; v < plans_.size(); ++v) {
    traffic_.update();
    step(v, drive, send_off);
  }
}

bool OrderManager::may_roll(VehicleIndex vehicle) const {
  const AivProxy& proxy = registry_[vehicle];
  const ReportedPose& reported = plans_[vehicle].reported;
  if (!proxy.state || !proxy.state_in_session || !proxy.online() || proxy.no_orders ||
      proxy.lost(publisher_.now(), lost_after_))
    return false;
  const wire::State& state = *proxy.state;
  const bool this_map = proxy.map_id.empty() || proxy.map_id == map_->zone().name;
  const bool along = std::fabs(reported.heading_off_rad) <= heading_off_rad_max || goes_onto_line(vehicle);
  return proxy.position_known && this_map && reported.position && reported.off_m <= rules_.on_circuit_m && along &&
         state.operating_mode == wire::OperatingMode::automatic && !state.paused && state.e_stop == wire::EStop::none;
}

void OrderManager::step(VehicleIndex vehicle, bool drive, bool send_off) {
  Plan& plan = plans_[vehicle];
  AivProxy& proxy = registry_[vehicle];
  const SimTime now = publisher_.now();
  if (plan.stage == Plan::Stage::running && !plan.acknowledged) {
    if (now - plan.sent_at >= rules_.resend_after && proxy.online() && plan.sent) {
      plan.sent_at = now;
      ++resent_;
      publisher_.send_again(proxy, plan.sent);
    }
    return;
  }
  if (plan.stage == Plan::Stage::cancelling && now - plan.cancelled_at >= rules_.cancel_again && proxy.online())
    cancel(vehicle);

  if (plan.stage == Plan::Stage::running && is_stopped_without_reason(vehicle)) {
    publisher_.log('w',
                   proxy.name + ": is stopped with base ahead and reports no reason; cancelled, a new order follows");
    cancel(vehicle);
  }

  plan.waits_for_crossing.reset();
  plan.waits_for_vehicle = no_vehicle;
  const bool busy_elsewhere = plan.stage == Plan::Stage::none && proxy.state && !proxy.state->node_states.empty();
  const bool stays = plan.stage == Plan::Stage::none && (!send_off || stays_at_goal(vehicle));
  const bool keeps_still = continue_yielding(vehicle);
  if (!drive || plan.stage == Plan::Stage::cancelling || busy_elsewhere || stays || keeps_still || !may_roll(vehicle) ||
      now < plan.wait_until) {
    traffic_.withdraw(vehicle);  // a vehicle that cannot use its turn must not block others
    plan.waits_since.reset();
    return;
  }
  if (plan.stage == Plan::Stage::running && now - plan.sent_at < rules_.update_period) return;

  extension_.clear();
  if (joining(vehicle)) return;
  const auto from = start_of_extension(vehicle);
  if (from) extend(vehicle, *from);
  if (!extension_.empty() || (from && leads_too_far(vehicle))) send(vehicle, *from);
  if (plan.stage == Plan::Stage::none) keep_off_path(vehicle);
  record_waiting(plan, now);
  if (plan.stage == Plan::Stage::none) try_other_positions(vehicle);
}

bool OrderManager::leads_too_far(VehicleIndex vehicle) {
  // The vehicle no longer follows the announced horizon; a vehicle with a horizon does not count as arrived.
  const Plan& plan = plans_[vehicle];
  return plan.stage == Plan::Stage::running && plan.has_horizon && next_stretch(vehicle, plan.base_end, 0) == nullptr;
}

bool OrderManager::comes_again(VehicleIndex vehicle, const Extension& from, std::size_t passed,
                               const WaypointGraph::Stretch& stretch) const {
  // A base that passes one position twice has two ends of the same name.
  const Plan& plan = plans_[vehicle];
  // A vehicle that has passed the end of its base and is in the next section reaches that section for the first time.
  const bool on_its_base = plan.stage == Plan::Stage::running && from.reach_m > 0.0;
  const zone::TrackPosition start = on_its_base ? *plan.reported.position : map_->waypoint(from.from).position;
  Sections released;
  if (on_its_base) released = traffic_.remaining(vehicle).first(traffic_.beyond_base(vehicle, start).keep);
  const Sections added = Sections{route_}.first(passed);
  const auto on_base = [&](zone::SectionId section) {
    return std::ranges::find(released, section) != released.end() || std::ranges::find(added, section) != added.end();
  };
  // On the return to its present section the base may reach up to its present position.
  const zone::TrackPosition end = map_->waypoint(stretch.to).position;
  const bool beyond_start = end.section != start.section || end.s_m >= start.s_m;
  if (stretch.sections.empty()) return end.section == start.section && on_base(start.section) && beyond_start;
  return std::ranges::any_of(stretch.sections, [&](zone::SectionId section) {
    return section == start.section ? beyond_start : on_base(section);
  });
}

void OrderManager::extend(VehicleIndex vehicle, const Extension& from) {
  Plan& plan = plans_[vehicle];
  WaypointIndex at = from.from;
  std::size_t passed = 0;
  double reach_m = from.reach_m;
  double in_convoy_m = 0.0;   // up to here the leader holds the same crossings and has a base to leave them
  double must_reach_m = 0.0;  // a granted chain is released as a whole: no vehicle stops in a crossing for lack of base
  while (extension_.size() < rules_.base_nodes_max && (reach_m < rules_.base_ahead_m || reach_m < must_reach_m)) {
    const WaypointGraph::Stretch* stretch = next_stretch(vehicle, at, passed);
    if (stretch == nullptr) break;
    if (comes_again(vehicle, from, passed, *stretch)) break;
    const double next_m = reach_m + stretch->length_m;
    const bool enters = stretch->crosses && !traffic_.holds_all(vehicle, next_m);
    WaypointGraph::Chain chain{no_waypoint, stretch->length_m};
    if (enters) {
      const WaypointIndex goal = missions_.complete(vehicle) ? missions_.goal(vehicle) : no_waypoint;
      chain = map_->chain(at, Sections{route_}.subspan(passed), goal);
    }
    const double chain_m = reach_m + chain.length_m;
    const bool joins = enters && joins_convoy(vehicle, {reach_m, next_m, chain_m});
    if (joins) in_convoy_m = chain_m;
    const bool moves_up = plan.moves_up && !enters && extension_.empty();
    if (next_m > std::max(in_convoy_m, traffic_.reach_m(vehicle, next_m)) && !moves_up) {
      wait_for(plan, traffic_.ahead_within(vehicle, next_m + traffic_.stopped_m()).vehicle, WaitReason::ahead);
      break;
    }
    if (const VehicleIndex other = off_path_obstruction(vehicle, reach_m, chain_m); other != no_vehicle) {
      wait_for(plan, other, WaitReason::off_path);
      traffic_.withdraw(vehicle);  // the other vehicle may need the crossings that this vehicle has requested
      break;
    }
    if (enters) {
      if (!joins && !enter(vehicle, reach_m, chain_m)) break;
      if (joins) join_convoy(vehicle);
      must_reach_m = chain_m - 1e-6;
    }
    extension_.push_back(stretch);
    at = stretch->to;
    passed += stretch->sections.size();
    reach_m = next_m;
  }
  plan.moves_up = false;
}

bool OrderManager::enter(VehicleIndex vehicle, double stop_m, double exit_m) {
  Plan& plan = plans_[vehicle];
  if (stop_m > traffic_.rules().request_within_m) return false;
  const auto response = traffic_.request(vehicle, exit_m, stop_m);
  if (response.granted) return true;
  plan.waits_for_crossing = response.waits_for;
  wait_for(plan, response.blocked_by, response.why);
  return false;
}

bool OrderManager::detects_leader(VehicleIndex vehicle, VehicleIndex ahead) const {
  // A physical vehicle does not detect a virtual one by its own sensor, and the sensors of third-party vehicles are
  // unknown.
  return ahead != no_vehicle && registry_[vehicle].is_cosiva() && registry_[ahead].is_cosiva() &&
         (registry_[vehicle].augmented || !registry_[ahead].augmented);
}

bool OrderManager::joins_convoy(VehicleIndex vehicle, const ChainAhead& chain) {
  // The base does not keep the vehicle away from its leader: its obstacle sensor must.
  if (chain.next_m <= traffic_.reach_m(vehicle, chain.next_m)) return false;
  const VehicleIndex ahead = traffic_.ahead(vehicle).vehicle;
  if (!detects_leader(vehicle, ahead)) return false;
  // A vehicle that is stopped by command will not make room soon.
  if (!may_roll(ahead) || yields(ahead)) return false;
  return traffic_.may_join(vehicle, chain.exit_m, chain.stop_m);
}

void OrderManager::join_convoy(VehicleIndex vehicle) {
  const VehicleIndex ahead = traffic_.ahead(vehicle).vehicle;
  const auto [size, crossings] = traffic_.join(vehicle);
  std::string through;
  for (const CrossingIndex x : crossings) through += (through.empty() ? "" : " and ") + map_->zone().crossings[x].name;
  publisher_.explain(registry_[vehicle], "convoy",
                     "convoy of " + std::to_string(size) + " through " + through + ", behind " + registry_[ahead].name);
}

void OrderManager::send(VehicleIndex vehicle, const Extension& from) {
  Plan& plan = plans_[vehicle];
  AivProxy& proxy = registry_[vehicle];
  const bool is_new = plan.stage == Plan::Stage::none;
  if (is_new) {
    plan.order_id = unique_id(proxy.id.serial_number, publisher_.now());
    plan.update_id = 0;
    plan.base_end_sequence = 0;
    plan.ever_acknowledged = false;
  } else {
    ++plan.update_id;
  }

  wire::Order order;
  order.order_id = plan.order_id;
  order.order_update_id = plan.update_id;
  order.nodes.reserve(1 + extension_.size() + rules_.horizon);
  order.edges.reserve(extension_.size() + rules_.horizon);
  std::uint32_t sequence = plan.base_end_sequence;
  const auto add_node = [&](WaypointIndex index, bool released, double deviation_m) {
    const Point2 point = map_->point(index);
    order.nodes.push_back({map_->waypoint(index).id,
                           sequence,
                           released,
                           wire::NodePosition{point.x_m, point.y_m, {}, deviation_m, {}, map_->zone().name},
                           {}});
  };
  const double to_first_m = is_new ? std::fabs(from.reach_m) + plan.reported.off_m : 0.0;
  add_node(from.from, true, rules_.deviation_m + to_first_m);

  WaypointIndex at = from.from;
  std::size_t passed = 0;
  const auto add_stretch = [&](const WaypointGraph::Stretch& stretch, bool released) {
    order.edges.push_back({stretch.edge_id,
                           sequence + 1,
                           released,
                           map_->waypoint(at).id,
                           map_->waypoint(stretch.to).id,
                           stretch.speed_mps_max.value_or(map_->zone().profiles.fast.speed_mps),
                           stretch.length_m,
                           {},
                           {}});
    sequence += 2;
    add_node(stretch.to, released, rules_.deviation_m);
    at = stretch.to;
    passed += stretch.sections.size();
  };
  for (const WaypointGraph::Stretch* stretch : extension_) add_stretch(*stretch, true);
  plan.base_end = at;
  plan.base_end_sequence = sequence;
  for (std::size_t i = 0; i < rules_.horizon; ++i) {
    const WaypointGraph::Stretch* stretch = next_stretch(vehicle, at, passed);
    if (stretch == nullptr) break;
    add_stretch(*stretch, false);
  }
  plan.has_horizon = !order.nodes.back().released;

  const std::string summary = plan.order_id + " update " + std::to_string(plan.update_id) + ": base " +
                              map_->waypoint(from.from).id + " to " + map_->waypoint(plan.base_end).id +
                              ", horizon to " + map_->waypoint(at).id;
  plan.sent = publisher_.send(proxy, std::move(order), summary);
  plan.stage = Plan::Stage::running;
  plan.acknowledged = false;
  plan.sent_at = publisher_.now();
  traffic_.set_base_end(vehicle, plan.base_end);
  ++(is_new ? orders_sent_ : updates_sent_);
}

void OrderManager::fold(Digest& digest) const {
  for (const Plan& plan : plans_) {
    digest.add(static_cast<std::uint64_t>(plan.stage));
    digest.add(std::string_view{plan.order_id});
    digest.add(std::uint64_t{plan.update_id});
    digest.add(std::uint64_t{plan.base_end});
    digest.add(static_cast<std::uint64_t>(plan.yielding.has_value()));
  }
  digest.add(orders_sent_);
  digest.add(updates_sent_);
  digest.add(resent_);
}

}  // namespace cosiva::virtual_side
