#include "cosiva/adapters/stop/pending_stops.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/decode.h"
#include "cosiva/wire/vda5050/encode.h"

namespace cosiva::adapters {

wire::Publish PendingStops::message(Pending& pending, SimTime now) {
  const wire::StopTarget& target = pending.target;
  std::uint32_t& last = last_header_id_.try_emplace(target.actions_topic, first_header_id - 1).first->second;
  last = std::max(last + 1, first_header_id);  // also where the count begins again
  wire::InstantActions actions;
  actions.header = {last, now, target.version.empty() ? std::string(wire::vda5050::version) : target.version,
                    target.id.manufacturer, target.id.serial_number};
  actions.actions.push_back({"startPause", pending.id, {}, wire::BlockingType::none, {}});
  pending.sent = now;
  COSIVA_EXPECT(actions.header.header_id >= first_header_id);
  return {target.actions_topic, wire::vda5050::encode(actions), 0, false};
}

PendingStops::Messages PendingStops::begin(const std::string& id, std::span<const wire::StopTarget> targets,
                                           SimTime now) {
  COSIVA_EXPECT(!id.empty());
  forget_restarts(now);
  Messages messages;
  messages.reserve(targets.size());
  for (const wire::StopTarget& target : targets) {
    Pending& pending = pending_[target.state_topic];
    pending = Pending{id, target, now, now, false, false, restarted(target.name)};
    messages.push_back(message(pending, now));
  }
  return messages;
}

PendingStops::Messages PendingStops::due(SimTime now) {
  Messages messages;
  for (auto& [topic, pending] : pending_) {
    const bool often = pending.target.is_cosiva && now - pending.begun < times_.frequent_for;
    const auto period = often ? times_.resend : times_.resend_later;
    if (now - pending.sent >= period) messages.push_back(message(pending, now));
  }
  return messages;
}

PendingStops::Messages PendingStops::all(SimTime now) {
  Messages messages;
  for (auto& [topic, pending] : pending_) messages.push_back(message(pending, now));
  return messages;
}

bool PendingStops::on_state(std::string_view topic, std::string_view payload) {
  const auto found = pending_.find(topic);
  if (found == pending_.end()) return false;
  const auto state = wire::vda5050::decode_state(payload);
  if (!state || !state->paused) return false;
  const Pending& pending = found->second;
  if (pending.after_restart &&
      std::ranges::find(state->action_states, pending.id, &wire::ActionState::action_id) == state->action_states.end())
    return false;
  pending_.erase(found);
  return true;
}

void PendingStops::forget_restarts(SimTime now) {
  std::erase_if(restarted_at_, [&](const auto& entry) { return now - entry.second > times_.restart_arrives_within; });
}

bool PendingStops::lift(std::span<const std::string> vehicles, SimTime now) {
  forget_restarts(now);
  for (const std::string& vehicle : vehicles) restarted_at_[vehicle] = now;
  const bool all = std::ranges::find(vehicles, "*") != vehicles.end();
  return std::erase_if(pending_, [&](const auto& entry) {
           return all || std::ranges::find(vehicles, entry.second.target.name) != vehicles.end();
         }) > 0;
}

bool PendingStops::know(std::span<const wire::StopTarget> targets) {
  std::map<std::string_view, bool> latched;
  for (const wire::StopTarget& target : targets) latched.emplace(target.state_topic, target.latched);
  const std::size_t before = pending_.size();
  for (auto entry = pending_.begin(); entry != pending_.end();) {
    const auto known = latched.find(entry->first);
    const bool is_latched = known != latched.end() && known->second;
    const bool lifted = std::exchange(entry->second.was_latched, is_latched) && !is_latched;
    entry = known == latched.end() || lifted ? pending_.erase(entry) : std::next(entry);
  }
  return pending_.size() < before;
}

std::vector<PendingStops::Overdue> PendingStops::take_overdue(SimTime now) {
  std::vector<Overdue> overdue;
  for (auto& [topic, pending] : pending_) {
    if (pending.alarmed || now - pending.begun <= times_.alarm) continue;
    pending.alarmed = true;
    overdue.push_back({pending.id, pending.target.name});
  }
  return overdue;
}

std::vector<std::string> PendingStops::state_topics() const {
  std::vector<std::string> topics;
  for (const auto& [topic, pending] : pending_) topics.push_back(topic);
  return topics;
}

std::map<std::string, std::vector<std::string>> PendingStops::unconfirmed() const {
  std::map<std::string, std::vector<std::string>> vehicles;
  for (const auto& [topic, pending] : pending_) vehicles[pending.id].push_back(pending.target.name);
  for (auto& [id, names] : vehicles) std::ranges::sort(names);
  return vehicles;
}

}  // namespace cosiva::adapters
