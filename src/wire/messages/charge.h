#pragma once

#include "cosiva/wire/messages/messages.h"

namespace cosiva::wire {

/// A vehicle without a gauge reports its charge as unknown (A17). VDA 5050 2.1 requires a batteryCharge (§6.10.6), and
/// has 80 % for a good level of a vehicle that measures none; an information "battery" with charge = unknown states
/// that this is no measurement.
void set_charge_unknown(State& state);
[[nodiscard]] bool charge_unknown(const State& state);

}  // namespace cosiva::wire
