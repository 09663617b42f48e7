#include "cosiva/aiv/order/order_actions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

using wire::ActionStatus;
using wire::BlockingType;

/// A vehicle that has gone further than this has left its charger. Nearer, it may still drive the last millimetres to
/// its node.
constexpr double charger_m = 0.05;

bool ended(ActionStatus status) { return status == ActionStatus::finished || status == ActionStatus::failed; }
/// Triggered and begun, and not ended.
bool performed(ActionStatus status) { return status != ActionStatus::waiting && !ended(status); }
bool on_edge(std::uint32_t sequence_id) { return sequence_id % 2 != 0; }
bool blocks(const wire::Action& action) { return action.blocking_type != BlockingType::none; }

const ActionType& type_of(const ActionCatalogue& catalogue, const wire::Action& action) {
  const ActionType* type = find_action(catalogue, action.action_type);
  COSIVA_EXPECT(type != nullptr);  // OrderBook refuses an order with any other type
  return *type;
}

}  // namespace

OrderActions::OrderActions(ActionCatalogue catalogue)
    : catalogue_{std::move(catalogue)}, loads_{catalogue_.load_positions} {}

void OrderActions::append(const wire::Order& order, std::size_t first_node) {
  const auto add = [this](const std::vector<wire::Action>& actions, const std::string& id, std::uint32_t sequence_id,
                          bool released) {
    for (const wire::Action& action : actions) {
      entries_.push_back({action, id, sequence_id, released});
      changed_ = true;
    }
  };
  for (std::size_t i = 0; i < order.nodes.size(); ++i) {
    const wire::OrderNode& node = order.nodes[i];
    if (i >= first_node) add(node.actions, node.node_id, node.sequence_id, node.released);
    if (i == order.edges.size()) break;
    const wire::OrderEdge& edge = order.edges[i];
    add(edge.actions, edge.edge_id, edge.sequence_id, edge.released);
  }
  COSIVA_EXPECT(std::ranges::is_sorted(entries_, {}, &Entry::sequence_id));
  std::size_t beyond = entries_.size() - std::min(entries_.size(), shown_max);
  std::erase_if(entries_, [&beyond](const Entry& entry) { return ended(entry.status) && beyond > 0 && beyond-- > 0; });
}

void OrderActions::on_new_order(const wire::Order& order) {
  COSIVA_EXPECT(!left());
  changed_ = changed_ || !entries_.empty();
  entries_.clear();
  // The order's first node counts as traversed: the vehicle is there.
  reached_ = order.nodes.front().sequence_id;
  append(order, 0);
}

void OrderActions::on_update(const wire::Order& order) {
  const std::uint32_t stitch = order.nodes.front().sequence_id;
  std::erase_if(entries_, [stitch](const Entry& entry) { return entry.sequence_id > stitch; });
  append(order, 1);
}

void OrderActions::on_traversed(std::uint32_t sequence_id) {
  reached_ = sequence_id;
  for (Entry& entry : entries_) {
    if (!on_edge(entry.sequence_id) || entry.sequence_id > sequence_id || ended(entry.status)) continue;
    if (entry.status == ActionStatus::waiting)
      fail(entry, "the edge was left before the action began");
    else if (type_of(catalogue_, entry.action).effect != ActionEffect::none)
      fail(entry, "the edge was left before the action was done");
    else
      set(entry, ActionStatus::finished);  // §6.10.2: the actions that were active on the edge are finished
  }
}

void OrderActions::cancel(std::string_view why) {
  for (Entry& entry : entries_)
    if (!ended(entry.status)) set(entry, ActionStatus::failed, std::string(why));
}

bool OrderActions::triggered(const Entry& entry) const {
  if (!reached_ || !entry.released) return false;
  return entry.sequence_id <= *reached_ + (on_edge(entry.sequence_id) ? 1 : 0);
}

void OrderActions::update(const Conditions& conditions) {
  const SimDuration step =
      updated_at_ ? std::max(SimDuration::zero(), conditions.now - *updated_at_) : SimDuration::zero();
  updated_at_ = conditions.now;
  for (Entry& entry : entries_)
    if (performed(entry.status)) pass_time(entry, step, conditions.paused);
  if (!conditions.paused) begin_next(conditions);
  if (charging_ && !charged_at_m_) charged_at_m_ = conditions.travelled_m;
  if (charging_ && std::fabs(conditions.travelled_m - *charged_at_m_) > charger_m) set_charging(false);
  const auto performs = [](const Entry& entry) { return performed(entry.status); };
  const auto performs_hard = [](const Entry& entry) {
    return performed(entry.status) && entry.action.blocking_type == BlockingType::hard;
  };
  COSIVA_EXPECT(std::ranges::none_of(entries_, performs_hard) || std::ranges::count_if(entries_, performs) == 1);
}

void OrderActions::pass_time(Entry& entry, SimDuration step, bool paused) {
  const ActionType& type = type_of(catalogue_, entry.action);
  if (paused && type.pausable) {
    if (entry.status != ActionStatus::paused) set(entry, ActionStatus::paused);
    return;
  }
  if (entry.status == ActionStatus::paused)
    set(entry, entry.preparing ? ActionStatus::initializing : ActionStatus::running);
  if (!entry.preparing && !type.duration) return;
  entry.left -= step;
  if (entry.left > SimDuration::zero()) return;
  if (!entry.preparing) return complete(entry);
  const SimDuration beyond = entry.left;
  begin_running(entry);
  entry.left += beyond;
}

void OrderActions::begin_next(const Conditions& conditions) {
  bool performs = false;
  std::optional<std::uint32_t> kept_at;  // node or edge of a SOFT or HARD action that is performed
  for (Entry& entry : entries_) {
    if (ended(entry.status)) continue;
    // The vehicle enters an edge when it may drive on from the node (§6.10.2).
    if (!triggered(entry) || (kept_at && *kept_at < entry.sequence_id)) return;
    const bool hard = entry.action.blocking_type == BlockingType::hard;
    if (entry.status == ActionStatus::waiting) {
      if (blocks(entry.action) && !conditions.stopped) return;
      if (hard && performs) return;
      const ActionType& type = type_of(catalogue_, entry.action);
      entry.preparing = type.preparation > SimDuration::zero();
      entry.left = type.preparation;
      if (entry.preparing)
        set(entry, ActionStatus::initializing);
      else
        begin_running(entry);
      if (ended(entry.status)) continue;
    }
    if (hard) return;
    performs = true;
    if (blocks(entry.action)) kept_at = entry.sequence_id;
  }
}

void OrderActions::begin_running(Entry& entry) {
  const ActionType& type = type_of(catalogue_, entry.action);
  entry.preparing = false;
  entry.left = type.duration.value_or(SimDuration::zero());
  if (type.effect == ActionEffect::pick) {
    if (const auto room = loads_.room_for(entry.action); !room) return fail(entry, room.error().message);
  } else if (type.effect == ActionEffect::drop) {
    if (const auto load = loads_.load_for(entry.action); !load) return fail(entry, load.error().message);
  }
  set(entry, ActionStatus::running);
}

void OrderActions::complete(Entry& entry) {
  std::string result;
  switch (type_of(catalogue_, entry.action).effect) {
    case ActionEffect::pick:
    case ActionEffect::drop: {
      const bool picks = type_of(catalogue_, entry.action).effect == ActionEffect::pick;
      const auto load = picks ? loads_.pick(entry.action) : loads_.drop(entry.action);
      if (!load) return fail(entry, load.error().message);
      result = load->load_id;
      break;
    }
    case ActionEffect::start_charging: set_charging(true); break;
    case ActionEffect::stop_charging: set_charging(false); break;
    case ActionEffect::detect: result = entry.action.text("objectType").value_or(""); break;
    case ActionEffect::await_trigger:
    case ActionEffect::none: break;
  }
  set(entry, ActionStatus::finished, std::move(result));
}

void OrderActions::fail(Entry& entry, std::string why) {
  failures_.push_back({entry.action, entry.node_or_edge_id, on_edge(entry.sequence_id), why});
  set(entry, ActionStatus::failed, std::move(why));
}

void OrderActions::set(Entry& entry, ActionStatus status, std::string result) {
  entry.status = status;
  entry.result = std::move(result);
  changed_ = true;
}

bool OrderActions::trigger(std::string_view type) {
  bool any = false;
  for (Entry& entry : entries_) {
    if (entry.status != ActionStatus::running ||
        type_of(catalogue_, entry.action).effect != ActionEffect::await_trigger)
      continue;
    if (!type.empty() && entry.action.text("triggerType") != std::string(type)) continue;
    complete(entry);
    any = true;
  }
  return any;
}

void OrderActions::set_charging(bool charging) {
  changed_ = changed_ || charging != charging_;
  charging_ = charging;
  charged_at_m_.reset();
}

bool OrderActions::left() const {
  return std::ranges::any_of(entries_, [](const Entry& entry) { return !ended(entry.status); });
}

bool OrderActions::holds_vehicle() const {
  return std::ranges::any_of(entries_,
                             [](const Entry& entry) { return performed(entry.status) && blocks(entry.action); });
}

bool OrderActions::keep_here() const {
  return std::ranges::any_of(entries_, [this](const Entry& entry) {
    return !ended(entry.status) && blocks(entry.action) && triggered(entry);
  });
}

std::vector<wire::ActionState> OrderActions::states() const {
  std::vector<wire::ActionState> states;
  states.reserve(entries_.size());
  for (const Entry& entry : entries_)
    states.push_back({entry.action.action_id, entry.action.action_type, entry.status, entry.result});
  return states;
}

bool OrderActions::take_changed() { return std::exchange(changed_, false); }

std::vector<OrderActions::Failure> OrderActions::take_failures() { return std::exchange(failures_, {}); }

void OrderActions::archive(Archive& archive) {
  archive(loads_, entries_, reached_, updated_at_, charging_, charged_at_m_, changed_, failures_);
}

}  // namespace cosiva::aiv
