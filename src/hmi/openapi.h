#pragma once

#include <string_view>

namespace cosiva::app {

/// docs/protocols/openapi.json, compiled into the program: the response to `GET /api`.
[[nodiscard]] std::string_view openapi_json();

}  // namespace cosiva::app
