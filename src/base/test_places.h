#pragma once

#include <string>

namespace cosiva {

/// Where this checkout lies: what tests and benches read their zones and recordings from. A function of a library of
/// its own (cmake/cosiva_headers.cmake), not a macro, so that compiling a test is the same in every checkout.
[[nodiscard]] std::string source_dir();

}  // namespace cosiva
