#pragma once

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/hmi/call_context.h"

/// Commands to vehicles, and adding and removing of objects (docs/protocols/hmi-api.md, "Doing").
/// Each handles one call of the route table (page_calls.cpp); status and error codes are those of that document.
namespace cosiva::app {

/// POST /api/v1/commands: a command to vehicles; 202 with its id.
[[nodiscard]] adapters::HttpResponse post_command(CallContext& context, const Call& call);
/// POST /api/v1/battery/ready: a battery is in its vehicle; 202.
[[nodiscard]] adapters::HttpResponse post_battery_ready(CallContext& context, const Call& call);
/// Adds a virtual AIV, person or obstacle; 201 with its id.
[[nodiscard]] adapters::HttpResponse add_virtual_object(CallContext& context, const Call& call);
/// Moves a virtual AIV, person or obstacle; 404 where there is none of this id.
[[nodiscard]] adapters::HttpResponse move_virtual_object(CallContext& context, const Call& call);
/// Removes one of those; 404 where there is none of this id.
[[nodiscard]] adapters::HttpResponse remove_virtual_object(CallContext& context, const Call& call);
/// Removes all of them.
[[nodiscard]] adapters::HttpResponse remove_virtual_objects(CallContext& context, const Call& call);
/// POST /api/v1/plant/obstacles: an obstacle of the emulated world; 409 ("plant.not_now") where there is none.
[[nodiscard]] adapters::HttpResponse add_plant_obstacle(CallContext& context, const Call& call);
/// DELETE /api/v1/plant/obstacles/{id}: removes one of those.
[[nodiscard]] adapters::HttpResponse remove_plant_obstacle(CallContext& context, const Call& call);

}  // namespace cosiva::app
