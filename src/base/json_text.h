#pragma once

#include <string>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva {

/// Writes a document, or a part of one, as the next value.
void write_json(JsonWriter& json, const JsonValue& value);
/// A document, or a part of one, as a separate document.
[[nodiscard]] std::string to_text(const JsonValue& value);

}  // namespace cosiva
