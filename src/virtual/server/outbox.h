#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/time.h"
#include "virtual/server/proxy.h"
#include "virtual/server/traces.h"
#include "wire/core.h"

namespace cosiva::virtual_side {

/// What the server says, in one place: fills in headers, encodes, publishes and traces.
class Outbox {
 public:
  /// @param as_values  orders are passed on as values (wire/said.h)
  explicit Outbox(Traces& traces, bool as_values = false) : traces_{traces}, as_values_{as_values} {}

  /// Where everything goes until the next call.
  void open(SimTime now, wire::Effects& effects) {
    now_ = now;
    effects_ = &effects;
  }

  /// Give what was said, for sending the very same again.
  wire::Publish send(AivProxy& proxy, wire::Order&& order, std::string_view summary);
  std::string send(AivProxy& proxy, wire::InstantActions& actions);
  void resend_order(const AivProxy& proxy, const wire::Publish& order);
  void resend_actions(const AivProxy& proxy, const std::string& payload);
  void publish(std::string topic, std::string payload, int qos, bool retained);
  void log(char level, std::string text);
  /// What the server decided about a vehicle, which is no message.
  void explain(const AivProxy& proxy, std::string_view kind, std::string_view content) {
    traces_.add(now_, "AIV_Server", proxy.name, kind, content);
  }
  void remember(std::string bytes) { effects_->emplace_back(wire::Remember{std::move(bytes)}); }

  [[nodiscard]] SimTime now() const { return now_; }

 private:
  [[nodiscard]] wire::Header header(const AivProxy& proxy, std::uint32_t id) const;
  void say(const AivProxy& proxy, wire::Publish message);

  Traces& traces_;
  bool as_values_;
  wire::Effects* effects_{};
  SimTime now_{};
};

/// Instant actions on their way: each is sent again, unchanged, every 300 ms until the vehicle's state lists it.
class ActionDesk {
 public:
  using Ticket = std::uint64_t;
  static constexpr SimDuration resend_after{std::chrono::milliseconds{300}};

  explicit ActionDesk(Outbox& outbox) : outbox_{outbox} {}

  struct Progress {
    std::string action_id;
    bool seen{false};
    wire::ActionStatus status{wire::ActionStatus::waiting};
    std::string result;
  };
  struct Letter {
    Ticket ticket{};
    VehicleIndex vehicle{};
    std::string payload;
    std::vector<Progress> actions;
    SimTime sent_at{};
    SimTime until{};
    bool kept{false};  ///< somebody follows it and will drop it
    [[nodiscard]] bool acknowledged() const;
  };

  /// Gives every action its id and sends them in one message.
  /// @param patience  how long it is sent again; zero: once only
  /// @param keep      the caller follows the letter and drops it
  Ticket send(AivProxy& proxy, VehicleIndex vehicle, std::vector<wire::Action> actions, SimDuration patience,
              bool keep);
  [[nodiscard]] const Letter* find(Ticket ticket) const;
  void drop(Ticket ticket);
  void on_state(VehicleIndex vehicle, const wire::State& state);
  /// It has been taken away: nothing is sent to it any more.
  void forget(VehicleIndex vehicle);
  void tick(Registry& registry, bool link_up);

 private:
  Outbox& outbox_;
  std::vector<Letter> letters_;
  Ticket last_ticket_{0};
};

/// "<prefix>-<time in ms, base 36>-<n>": unique over restarts of the server.
[[nodiscard]] std::string unique_id(std::string_view prefix, SimTime now);

}  // namespace cosiva::virtual_side
