#pragma once

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/hmi/call_context.h"

/// The clock of a run in virtual time (docs/protocols/hmi-api.md, "Doing").
/// Each handles one call of the route table (page_calls.cpp); status and error codes are those of that document.
namespace cosiva::app {

/// PUT /api/v1/clock: stops the clock, starts it, or changes its speed (0.1 to 100); 409 ("clock.not_now") in real
/// time.
[[nodiscard]] adapters::HttpResponse set_clock(CallContext& context, const Call& call);
/// POST /api/v1/clock/step: advances a stopped clock by 1 to 10000 ms.
[[nodiscard]] adapters::HttpResponse step_clock(CallContext& context, const Call& call);

}  // namespace cosiva::app
