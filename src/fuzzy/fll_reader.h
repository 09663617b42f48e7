#pragma once

#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/fuzzy/engine.h"

namespace cosiva::fuzzy {

/// Reads FLL, the language of fuzzylite 6: Engine, InputVariable, OutputVariable and RuleBlock with their lines, and
/// comments after #. Unsupported text fails ("rules.syntax", "rules.size") with "origin:line:column", what was found,
/// and what to write instead; this includes Mamdani outputs, activations other than General, hedges in conclusions and
/// outputs that depend on earlier ones (lock-previous). @param origin  of the text, for the errors: a file's name
[[nodiscard]] Result<Engine> read_fll(std::string_view text, std::string_view origin);

}  // namespace cosiva::fuzzy
