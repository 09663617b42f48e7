#pragma once

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/battery/procedure.h"

namespace cosiva::experiments {

/// A record whole, with its curve: to go on from.
void write_record(JsonWriter& json, const BatteryRun& run);
/// Fails ("battery.state").
[[nodiscard]] Result<BatteryRun> read_record(const JsonValue& json);
/// A part of a document as a document of its own.
[[nodiscard]] std::string to_text(const JsonValue& json);
void write_sample(JsonWriter& json, const BatterySample& sample);
[[nodiscard]] Result<BatterySample> read_sample(const JsonValue& json);

}  // namespace cosiva::experiments
