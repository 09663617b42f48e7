#pragma once

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/battery/procedure.h"

namespace cosiva::experiments {

/// A complete record, with its curve: to continue from.
void write_record(JsonWriter& json, const BatteryRun& run);
/// Fails ("battery.state").
[[nodiscard]] Result<BatteryRun> read_record(const JsonValue& json);
void write_sample(JsonWriter& json, const BatterySample& sample);
[[nodiscard]] Result<BatterySample> read_sample(const JsonValue& json);

}  // namespace cosiva::experiments
