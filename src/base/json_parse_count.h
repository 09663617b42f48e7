#pragma once

#include <cstdint>

namespace cosiva {

/// How many texts JsonValue::parse has read on this thread: tests count that no text is read twice.
[[nodiscard]] std::uint64_t json_parse_count();
/// To be called by JsonValue::parse for each text that it reads.
void count_json_parse();

}  // namespace cosiva
