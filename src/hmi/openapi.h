#pragma once

#include <string_view>

namespace cosiva::app {

/// docs/protocols/openapi.json, taken into the program when it was built: `GET /api` answers it wherever it runs.
[[nodiscard]] std::string_view openapi_json();

}  // namespace cosiva::app
