#include "cosiva/aiv/experiments/battery_exchange.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {

Result<void> BatteryExchange::on_request(std::string_view payload) {
  fitted_.reset();
  full_since_.reset();
  requested_.reset();
  if (payload.empty()) return {};
  auto request = wire::battery_request_from_json(payload);
  if (!request) return tl::unexpected(request.error());
  requested_ = std::move(*request);
  return {};
}

Result<void> BatteryExchange::on_fitted(std::string_view payload) {
  auto fitted = wire::battery_ready_from_json(payload);
  if (!fitted) return tl::unexpected(fitted.error());
  if (!requested_)
    return fail("battery.not_requested", "no test has requested a battery for this vehicle", fitted->battery);
  fitted_ = std::move(*fitted);
  return {};
}

const wire::Power* BatteryExchange::power(SimTime now) const {
  return reading_ && now - reading_->at <= reading_max ? &reading_->power : nullptr;
}

bool BatteryExchange::full_for_long(SimTime now, const wire::Power* power) {
  if (power == nullptr || power->charge() < full) {
    full_since_.reset();
    return false;
  }
  if (!full_since_ || *full_since_ > now) full_since_ = now;
  return now - *full_since_ >= full_min;
}

std::optional<wire::BatteryReady> BatteryExchange::take_ready(SimTime now, bool stopped) {
  if (!requested_) return std::nullopt;
  if (!stopped) {
    full_since_.reset();
    return std::nullopt;
  }
  const wire::Power* const measured = power(now);
  const bool full_on_board = full_for_long(now, measured);
  if (!fitted_ && (requested_->by_hand || !full_on_board)) return std::nullopt;
  // The vehicle cannot read a battery's name, type or age: without a person it responds with the requested name.
  const bool by_person = fitted_.has_value();
  wire::BatteryReady ready =
      by_person ? *std::exchange(fitted_, std::nullopt) : wire::BatteryReady{requested_->change.battery, "unknown"};
  COSIVA_EXPECT(!fitted_);
  requested_.reset();
  if (measured == nullptr) return ready;
  ready.temperature_c = 0.1 * measured->temperature_01C;
  const double measured_percent = 100.0 * measured->charge();
  // A person may know of a battery that it is not full; a person's word does not make it fuller than RALI reads.
  ready.charge_percent = by_person ? std::min(ready.charge_percent, measured_percent) : measured_percent;
  return ready;
}

}  // namespace cosiva::aiv
