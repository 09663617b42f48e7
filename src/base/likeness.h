#pragma once

#include <cstddef>
#include <string_view>

namespace cosiva {

/// Number of letters to change, add or remove to turn one word into the other (Levenshtein), to suggest what an unknown
/// word was meant to be. Bytes count, so a letter beyond ASCII may count twice. Time and memory grow with the product
/// and the second word's length: truncate text from unknown senders.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace cosiva
