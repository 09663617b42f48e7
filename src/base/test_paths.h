#pragma once

#include <string>

namespace cosiva {

/// The directory of this checkout, from which tests and benchmarks read zones and recordings. A function of a separate
/// library (cmake/cosiva_headers.cmake), not a macro, so that compiling a test is the same in every checkout.
[[nodiscard]] std::string source_dir();

}  // namespace cosiva
