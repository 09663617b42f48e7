#pragma once

#include <cstddef>
#include <string_view>

#include "cosiva/wire/vda5050/decode.h"
#include "cosiva/wire/vda5050/encode.h"
#include "cosiva/wire/vda5050/factsheet.h"

/// JSON of VDA 5050 2.1.0, reading 2.0 peers too. Writing is strict (valid against the official schemas), reading
/// tolerant (unknown fields pass, `instantActions` for `actions`, `allowedDeviationXy`, any number of decimals, "v2" as
/// a version) but bounded: payloads over `payload_bytes_max`, more than `array_items_max` entries, numbers beyond ±1e9
/// and texts longer than `text_bytes_max` are refused; only descriptions, which are for display, are cut instead.
/// A message whose header states version 2.0 is written with the older spellings in addition to the current ones.
///
/// Errors carry the field's path as location ("state.nodeStates[3].sequenceId") and one of these codes: vda.json (not
/// one JSON object), vda.size, vda.missing, vda.type, vda.range, vda.value (not a term of the standard), vda.time,
/// vda.version.
namespace cosiva::wire::vda5050 {

inline constexpr std::string_view version = "2.1.0";
inline constexpr std::size_t payload_bytes_max = 256 * 1024;
inline constexpr std::size_t array_items_max = 4096;
inline constexpr std::size_t text_bytes_max = 1024;

}  // namespace cosiva::wire::vda5050
