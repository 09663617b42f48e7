#pragma once

#include <cstddef>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/fll_tokens.h"

namespace cosiva::fuzzy {

/// "name Shape numbers… [height]".
[[nodiscard]] Result<Term> read_input_term(const Word& value, std::string_view origin);
/// "name Constant number" or "name Linear coefficients… [constant]".
[[nodiscard]] Result<Term> read_output_term(const Word& value, std::string_view origin, std::size_t inputs);

}  // namespace cosiva::fuzzy
