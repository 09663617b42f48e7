#pragma once

#include <string>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// A response with a JSON body.
[[nodiscard]] adapters::HttpResponse json_response(std::string json, unsigned status = 200);
/// The core's refusal: 409 for a request that is only impossible at present, 429 for one too many, 404 for an unknown
/// object, else 400.
[[nodiscard]] adapters::HttpResponse refusal(const Error& error);

}  // namespace cosiva::app
