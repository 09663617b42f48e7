#pragma once

#include <string>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/hmi/call_context.h"

/// The queries of the page and of other programs (docs/protocols/hmi-api.md, "Reading").
/// Each handles one call of the route table (page_calls.cpp); status and error codes are those of that document.
namespace cosiva::app {

/// GET /api: the OpenAPI document of all calls.
[[nodiscard]] adapters::HttpResponse get_openapi(CallContext& context, const Call& call);
/// GET /api/v1/zone: the zone in the form that the page draws.
[[nodiscard]] adapters::HttpResponse get_zone(CallContext& context, const Call& call);
/// GET /api/v1/snapshot: the state of all vehicles.
[[nodiscard]] adapters::HttpResponse get_snapshot(CallContext& context, const Call& call);
/// GET /api/v1/bijection: how twins and vehicles match.
[[nodiscard]] adapters::HttpResponse get_bijection(CallContext& context, const Call& call);
/// GET /api/v1/run: name, scenario, version and clock of the run.
[[nodiscard]] adapters::HttpResponse get_run(CallContext& context, const Call& call);
/// GET /api/v1/traces: traces after a running number; 400 ("http.query") where a parameter is not a number.
[[nodiscard]] adapters::HttpResponse get_traces(CallContext& context, const Call& call);
/// GET /api/v1/traces/{n}: one trace whole; 404 ("trace.not_found").
[[nodiscard]] adapters::HttpResponse get_trace(CallContext& context, const Call& call);
/// GET /api/v1/battery/curves/{id}: the curve of one vehicle's battery; 404 ("battery.not_found").
[[nodiscard]] adapters::HttpResponse get_battery_curve(CallContext& context, const Call& call);
/// The latest image of the GVS as Netpbm; 404 where there is no recent one.
[[nodiscard]] adapters::HttpResponse get_gvs_preview(CallContext& context, const Call& call);

/// The body of `GET /api/v1/snapshot`: the core's, and the parts of the platform where they are known.
[[nodiscard]] std::string snapshot_json(const PageHost& host);
/// The body of `GET /api/v1/run`.
[[nodiscard]] std::string run_json(const CallContext& context);

}  // namespace cosiva::app
