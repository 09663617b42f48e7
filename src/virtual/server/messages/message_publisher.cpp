#include "cosiva/virtual/server/messages/message_publisher.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::string_view same_again = "repeated: not acknowledged within 300 ms";

}  // namespace

wire::Header MessagePublisher::header(const AivProxy& proxy, std::uint32_t id) const {
  return {id, now_, proxy.received.version(), proxy.id().manufacturer, proxy.id().serial_number};
}

MessagePublisher::SentOrder MessagePublisher::send(AivProxy& proxy, wire::Order&& order, std::string_view summary) {
  order.header = header(proxy, proxy.sent.order);
  if (order.header.version.empty()) order.header.version = wire::vda5050::version;
  SentOrder sent = wire::typed(std::move(order));
  wire::Publish message{proxy.identity.order_topic(), {}, 0, false};
  if (as_values_)
    message.typed = sent;
  else
    message.payload = wire::vda5050::encode(std::get<wire::Order>(sent->message));
  send_numbered(proxy, proxy.sent.order, "order", summary, std::move(message));
  return sent;
}

void MessagePublisher::send_again(AivProxy& proxy, SentOrder& order) {
  wire::Order same = std::get<wire::Order>(order->message);
  order = send(proxy, std::move(same), same_again);
}

void MessagePublisher::send(AivProxy& proxy, wire::InstantActions& actions) {
  std::string summary;
  for (const wire::Action& action : actions.actions) {
    if (!summary.empty()) summary += ", ";
    summary += action.action_type;
    if (const auto profile = action.text("profile")) summary += " " + *profile;
    summary += " (" + action.action_id + ")";
  }
  publish(proxy, actions, summary);
}

void MessagePublisher::send_again(AivProxy& proxy, wire::InstantActions& actions) {
  publish(proxy, actions, same_again);
}

void MessagePublisher::publish(AivProxy& proxy, wire::InstantActions& actions, std::string_view summary) {
  actions.header = header(proxy, proxy.sent.actions);
  wire::Publish message{proxy.identity.actions_topic(), wire::vda5050::encode(actions), 0, false};
  send_numbered(proxy, proxy.sent.actions, "instantActions", summary, std::move(message));
}

void MessagePublisher::send_numbered(AivProxy& proxy, std::uint32_t& header_id, std::string_view kind,
                                     std::string_view summary, wire::Publish message) {
  if (proxy.membership.handed_over()) return;
  ++header_id;
  send(proxy, kind, summary, std::move(message));
}

void MessagePublisher::send(AgentProxy& receiver, std::string_view kind, std::string_view summary,
                            wire::Publish message) {
  COSIVA_EXPECT(effects_ != nullptr);
  receiver.send(traces_, now_, kind, summary, std::move(message), *effects_);
}

void MessagePublisher::publish(std::string topic, std::string payload, int qos, bool retained) {
  add_effect(wire::Publish{std::move(topic), std::move(payload), qos, retained});
}

void MessagePublisher::log(char level, std::string text) { add_effect(wire::Log{level, std::move(text)}); }

void MessagePublisher::persist(std::string bytes) {
  COSIVA_EXPECT(effects_ != nullptr && opened_at_ <= effects_->size());
  effects_->insert(effects_->begin() + static_cast<std::ptrdiff_t>(opened_at_), wire::Persist{std::move(bytes)});
}

void MessagePublisher::add_effect(wire::Effect effect) {
  COSIVA_EXPECT(effects_ != nullptr);
  effects_->push_back(std::move(effect));
}

std::string unique_id(std::string_view prefix, SimTime now) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), ms, 36).ptr;
  std::string id{prefix};
  id += '-';
  id.append(digits.data(), end);
  return id;
}

bool InstantActionSender::PendingAction::acknowledged() const {
  return std::ranges::all_of(actions, &Progress::detected);
}

InstantActionSender::ActionHandle InstantActionSender::send(AivProxy& proxy, VehicleIndex vehicle,
                                                            std::vector<wire::Action> actions, SimDuration timeout,
                                                            bool keep, First first) {
  COSIVA_EXPECT(!actions.empty());
  const ActionHandle handle = ++last_handle_;
  COSIVA_EXPECT(pending_.empty() || pending_.back().handle < handle);
  PendingAction pending_action{handle, vehicle, {}, {}, publisher_.now(), publisher_.now() + timeout, keep};
  wire::InstantActions& message = pending_action.message;
  message.actions = std::move(actions);
  const std::string stem = unique_id("A", publisher_.now()) + "-" + std::to_string(handle);
  for (std::size_t i = 0; i < message.actions.size(); ++i) {
    std::string& id = message.actions[i].action_id;
    if (id.empty()) id = i == 0 ? stem : stem + "." + std::to_string(i);
    pending_action.actions.push_back({message.actions[i].action_id, false, wire::ActionStatus::waiting, {}});
  }
  if (first == First::now) publisher_.send(proxy, message);
  pending_.push_back(std::move(pending_action));
  return handle;
}

const InstantActionSender::PendingAction* InstantActionSender::find(ActionHandle handle) const {
  const auto it = std::ranges::find(pending_, handle, &PendingAction::handle);
  return it == pending_.end() ? nullptr : &*it;
}

void InstantActionSender::drop(ActionHandle handle) {
  std::erase_if(pending_, [handle](const PendingAction& pending_action) { return pending_action.handle == handle; });
}

void InstantActionSender::forget(VehicleIndex vehicle) {
  std::erase_if(pending_, [vehicle](const PendingAction& pending_action) { return pending_action.vehicle == vehicle; });
}

void InstantActionSender::drop_stop_pause(VehicleIndex vehicle) {
  std::erase_if(pending_, [vehicle](const PendingAction& one) {
    return one.vehicle == vehicle && !one.kept && one.message.actions.front().action_type == "stopPause";
  });
}

void InstantActionSender::on_state(VehicleIndex vehicle, const wire::State& state) {
  for (PendingAction& pending_action : pending_) {
    if (pending_action.vehicle != vehicle) continue;
    for (Progress& progress : pending_action.actions) {
      const auto it = std::ranges::find(state.action_states, progress.action_id, &wire::ActionState::action_id);
      if (it == state.action_states.end()) continue;
      progress.detected = true;
      progress.status = it->status;
      progress.result = it->result_description;
    }
  }
  std::erase_if(pending_, [&](const PendingAction& l) { return l.vehicle == vehicle && !l.kept && l.acknowledged(); });
}

void InstantActionSender::tick(Registry& registry, bool link_up) {
  const SimTime now = publisher_.now();
  for (PendingAction& pending_action : pending_) {
    if (pending_action.acknowledged() || now >= pending_action.until || now - pending_action.sent_at < resend_after ||
        !link_up)
      continue;
    pending_action.sent_at = now;
    publisher_.send_again(registry[pending_action.vehicle], pending_action.message);
  }
  std::erase_if(pending_, [now](const PendingAction& l) { return !l.kept && now >= l.until; });
}

void MessagePublisher::archive(Archive& archive) { archive(now_); }

void InstantActionSender::archive(Archive& archive) { archive(pending_, last_handle_); }

}  // namespace cosiva::virtual_side
