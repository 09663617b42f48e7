#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/exchange/traces.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// Publishes all messages of the server: fills in headers, encodes, and hands each to the proxy of its receiver, which
/// traces it. A message to all has no proxy.
///
/// Invariant: each message becomes an effect of the input that is being handled; open() precedes the first one.
class MessagePublisher {
 public:
  /// @param as_values  orders are passed on as values (wire/in_process/typed_message.h)
  explicit MessagePublisher(Traces& traces, bool as_values = false) : traces_{traces}, as_values_{as_values} {}
  MessagePublisher(const MessagePublisher&) = delete;  // other components hold references to it
  MessagePublisher& operator=(const MessagePublisher&) = delete;

  /// Sets the time and the effects of all messages until the next call.
  void open(SimTime now, wire::Effects& effects) {
    now_ = now;
    effects_ = &effects;
    opened_at_ = effects.size();
  }

  /// An order as it was sent, for repetition; null: none.
  using SentOrder = std::shared_ptr<const wire::TypedMessage>;
  // Every message gets its own header, whose id counts the messages of its topic (VDA 5050 §6.4). A repeated message
  // has the same content and the next id.
  [[nodiscard]] SentOrder send(AivProxy& proxy, wire::Order&& order, std::string_view summary);
  void send(AivProxy& proxy, wire::InstantActions& actions);
  void send_again(AivProxy& proxy, SentOrder& order);
  void send_again(AivProxy& proxy, wire::InstantActions& actions);
  /// Through the proxy of its receiver; `kind` and `summary` are for the trace.
  void send(AgentProxy& receiver, std::string_view kind, std::string_view summary, wire::Publish message);
  /// To all subscribers of the topic.
  void publish(std::string topic, std::string payload, int qos, bool retained);
  void log(char level, std::string text);
  /// Traces a decision of the server about a vehicle; no message is sent.
  void explain(const AivProxy& proxy, std::string_view kind, std::string_view content) {
    traces_.add(now_, "AIV_Server", proxy.name(), kind, content);
  }
  /// Persists what the messages of this input follow from: before they are sent.
  void persist(std::string bytes);

  [[nodiscard]] SimTime now() const { return now_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] wire::Header header(const AivProxy& proxy, std::uint32_t id) const;
  void publish(AivProxy& proxy, wire::InstantActions& actions, std::string_view summary);
  /// @param header_id  of the topic; incremented only when the message is sent
  void send_numbered(AivProxy& proxy, std::uint32_t& header_id, std::string_view kind, std::string_view summary,
                     wire::Publish message);
  void add_effect(wire::Effect effect);

  Traces& traces_;
  bool as_values_;
  wire::Effects* effects_{};
  std::size_t opened_at_{0};
  SimTime now_{};
};

/// Pending instant actions: each is repeated with the same action id every 300 ms until the vehicle's state lists it.
///
/// Invariant: handles ascend and are never used again, and each pending message contains at least one action, so that a
/// message is acknowledged only by a state that lists it.
class InstantActionSender {
 public:
  using ActionHandle = std::uint64_t;
  static constexpr SimDuration resend_after{std::chrono::milliseconds{300}};
  /// A timeout that never passes.
  static constexpr SimDuration without_end{std::chrono::hours{24 * 365 * 10}};

  explicit InstantActionSender(MessagePublisher& publisher) : publisher_{publisher} {}
  InstantActionSender(const InstantActionSender&) = delete;  // other components hold references to it
  InstantActionSender& operator=(const InstantActionSender&) = delete;

  struct Progress {
    std::string action_id;
    bool detected{false};
    wire::ActionStatus status{wire::ActionStatus::waiting};
    std::string result;
  };
  struct PendingAction {
    ActionHandle handle{};
    VehicleIndex vehicle{};
    wire::InstantActions message;
    std::vector<Progress> actions;
    SimTime sent_at{};
    SimTime until{};
    bool kept{false};  ///< the caller follows the action and will drop it
    [[nodiscard]] bool acknowledged() const;
  };

  enum class First : std::uint8_t {
    now,
    elsewhere,  ///< another connection has sent the message, with these ids; here it is only repeated
  };
  /// Assigns an id to every action that has none, and sends all actions in one message.
  /// @param timeout  how long the message is repeated; zero: sent only once
  /// @param keep     the caller follows the action and drops it
  ActionHandle send(AivProxy& proxy, VehicleIndex vehicle, std::vector<wire::Action> actions, SimDuration timeout,
                    bool keep, First first = First::now);
  [[nodiscard]] const PendingAction* find(ActionHandle handle) const;
  void drop(ActionHandle handle);
  void on_state(VehicleIndex vehicle, const wire::State& state);
  /// The vehicle has been removed: nothing more is sent to it.
  void forget(VehicleIndex vehicle);
  /// Before a Stop: a stopPause that no caller follows, and that is not acknowledged, would end it if it was sent
  /// again.
  void drop_stop_pause(VehicleIndex vehicle);
  void tick(Registry& registry, bool link_up);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  MessagePublisher& publisher_;
  std::vector<PendingAction> pending_;
  ActionHandle last_handle_{0};
};

/// "<prefix>-<time in ms, base 36>-<n>": unique over restarts of the server.
[[nodiscard]] std::string unique_id(std::string_view prefix, SimTime now);

}  // namespace cosiva::virtual_side
