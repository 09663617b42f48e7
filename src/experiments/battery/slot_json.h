#pragma once

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/battery/procedure.h"

namespace cosiva::experiments {

/// A vehicle's complete slot, to continue from after a crash.
void write_slot(JsonWriter& json, const ProcedureSlot& slot);
/// Fails ("battery.state") where the phase or a record is missing or wrong.
[[nodiscard]] Result<ProcedureSlot> read_slot(const JsonValue& json);

}  // namespace cosiva::experiments
