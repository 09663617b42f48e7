#pragma once

#include <optional>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::aiv {

/// The vehicle's side of a battery test (A37, A38): changeBattery is received, and batteryReady sent.
///
/// The rule: a person or a machine exchanges the battery. Where a person does (`byHand`), the vehicle responds when
/// that person confirms the battery. Elsewhere it responds when its RALI has read a full battery for two seconds since
/// the request, while the vehicle was stopped: an exchange that the request has caused is over by then. Temperature and
/// charge are RALI's, the charge at most that which the person has stated; a vehicle without RALI repeats the person.
///
/// The state is in no snapshot: the request is retained by the broker and arrives again.
///
/// Invariant: a request gets one response; a repeated request gets another one.
class BatteryExchange {
 public:
  /// Charge from which a battery is full.
  static constexpr double full = 0.97;
  /// How long RALI must have read it.
  static constexpr SimDuration full_min{std::chrono::seconds{2}};
  /// An older reading is not the fitted battery's.
  static constexpr SimDuration reading_max{std::chrono::seconds{2}};

  /// changeBattery; an empty payload withdraws it. Fails as wire::battery_request_from_json() does.
  [[nodiscard]] Result<void> on_request(std::string_view payload);
  /// The person's confirmation. Fails as wire::battery_ready_from_json() does, and ("battery.not_requested").
  [[nodiscard]] Result<void> on_fitted(std::string_view payload);
  /// A reading of RALI.
  void on_power(SimTime now, const wire::Power& power) { reading_ = Reading{now, power}; }
  /// The response that is due now, if any; to be called in each cycle.
  [[nodiscard]] std::optional<wire::BatteryReady> take_ready(SimTime now, bool stopped);

 private:
  struct Reading {
    SimTime at{};
    wire::Power power;
  };
  /// RALI's last reading; nothing: RALI is absent or sends nothing.
  [[nodiscard]] const wire::Power* power(SimTime now) const;
  [[nodiscard]] bool full_for_long(SimTime now, const wire::Power* power);

  std::optional<wire::BatteryRequest> requested_;  ///< without a response yet
  std::optional<wire::BatteryReady> fitted_;       ///< as a person has stated it
  std::optional<Reading> reading_;
  std::optional<SimTime> full_since_;  ///< of the stopped vehicle, since the request
};

}  // namespace cosiva::aiv
