#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/wire/messages/stop_target.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

/// The Stops that vehicles have not confirmed: which messages are due, without thread, clock and connection.
///
/// A Stop is the instant action `startPause`; all vehicles get the Stop's id as the `actionId`, so that the core, which
/// publishes the same Stop, and every repetition name one action, which a vehicle performs once. A state with `paused`
/// confirms; soon after a restart, which may not have arrived yet at a vehicle that an earlier Stop has paused, only
/// one that lists the action. The `headerId`s of these messages count from `first_header_id` on for each topic: VDA
/// 5050 has each sender count the messages of a topic, the core counts from 0, and so neither uses an id of the other.
///
/// Invariant: for a vehicle at most one Stop is pending, the latest, and it is due within its resend period.
class PendingStops {
 public:
  static constexpr std::uint32_t first_header_id = std::uint32_t{1} << 31U;
  struct Times {
    std::chrono::milliseconds resend{100};  ///< of our vehicles, which perform an action once
    std::chrono::milliseconds alarm{500};
    /// After this time the vehicle is probably not connected, and the resend period is `resend_later`.
    std::chrono::milliseconds frequent_for{10'000};
    std::chrono::milliseconds resend_later{1'000};  ///< and always of third-party vehicles
    std::chrono::milliseconds restart_arrives_within{10'000};
  };
  PendingStops() : PendingStops(Times{}) {}
  explicit PendingStops(Times times) : times_{times} {}

  using Messages = std::vector<wire::Publish>;
  /// The vehicles get this Stop instead of an earlier one.
  /// @return  the messages to be published at once, one for each vehicle
  [[nodiscard]] Messages begin(const std::string& id, std::span<const wire::StopTarget> targets, SimTime now);
  /// The messages that are due again.
  [[nodiscard]] Messages due(SimTime now);
  /// All messages again: the connection is new.
  [[nodiscard]] Messages all(SimTime now);

  /// A message has arrived on a topic. @return  whether it confirms a Stop
  bool on_state(std::string_view topic, std::string_view payload);
  /// The vehicles ("*": all) may drive again. @return  whether a Stop was pending for one of them
  bool lift(std::span<const std::string> vehicles, SimTime now);
  /// The vehicles that the core knows now. A Stop ends where the core has lifted it, or does not know the vehicle any
  /// more. @return  whether one has ended
  bool know(std::span<const wire::StopTarget> targets);

  struct Overdue {
    std::string id;
    std::string vehicle;
  };
  /// The Stops that have become older than the alarm's time since the last call.
  [[nodiscard]] std::vector<Overdue> take_overdue(SimTime now);
  /// The topics of the states that can confirm.
  [[nodiscard]] std::vector<std::string> state_topics() const;
  /// For each pending Stop's id the names of its vehicles, sorted.
  [[nodiscard]] std::map<std::string, std::vector<std::string>> unconfirmed() const;
  [[nodiscard]] bool empty() const { return pending_.empty(); }

 private:
  struct Pending {
    std::string id;
    wire::StopTarget target;
    SimTime begun{};
    SimTime sent{};
    bool alarmed{false};
    bool was_latched{false};    ///< the core has had this Stop
    bool after_restart{false};  ///< an earlier restart may still arrive at the vehicle
  };
  [[nodiscard]] wire::Publish message(Pending& pending, SimTime now);
  [[nodiscard]] bool restarted(const std::string& vehicle) const {
    return restarted_at_.contains(vehicle) || restarted_at_.contains("*");
  }
  void forget_restarts(SimTime now);

  Times times_;
  std::map<std::string, Pending, std::less<>> pending_;               ///< by the vehicle's state topic
  std::map<std::string, std::uint32_t, std::less<>> last_header_id_;  ///< by the topic of the actions
  std::map<std::string, SimTime, std::less<>> restarted_at_;          ///< by name, "*": all; the last ones
};

}  // namespace cosiva::adapters
