#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace cosiva::zone::lif {

/// The position where a text is no longer JSON, for manual repair: the fast parser only reports that there is a fault.
struct JsonFault {
  std::size_t line;    ///< from 1
  std::size_t column;  ///< in bytes, from 1
  std::string what;
};

/// The first fault; nothing in a good text. Arrays and objects deeper than `depth_max` are one, too.
[[nodiscard]] std::optional<JsonFault> find_json_fault(std::string_view text, std::size_t depth_max = 64);

}  // namespace cosiva::zone::lif
