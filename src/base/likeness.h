#pragma once

#include <cstddef>
#include <string_view>

namespace cosiva {

/// Letters to change, add or leave out on the way from one word to the other (Levenshtein): what was probably meant by
/// a word that nobody knows. Bytes count, so a letter beyond ASCII may count twice. Time and memory grow with the
/// product and the second word's length: cut what strangers send.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace cosiva
