#pragma once

#include <memory>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/hmi/call_context.h"

/// The zone's edits and file, the available zones, and the switch from one to another (docs/protocols/hmi-api.md).
/// Each handles one call of the route table (page_calls.cpp); status and error codes are those of that document.
namespace cosiva::app {

/// GET /api/v1/zones: the ready zones.
[[nodiscard]] adapters::HttpResponse list_zones(CallContext& context, const Call& call);
/// GET /api/v1/zone/file: the file of the zone in force, as a download; 404 ("zone.not_found").
[[nodiscard]] adapters::HttpResponse get_zone_file(CallContext& context, const Call& call);
/// The sidecar file of the zone in force likewise.
[[nodiscard]] adapters::HttpResponse get_zone_sidecar(CallContext& context, const Call& call);
/// GET /api/v1/zone/beacons/suggestion: a better origin of the beacons; 409 ("zone.beacons").
[[nodiscard]] adapters::HttpResponse suggest_beacons(CallContext& context, const Call& call);
/// The zone of a request, by name or whole, built; the error is the response to a request without a zone. Without the
/// core: any thread may.
[[nodiscard]] tl::expected<std::shared_ptr<const GivenZone>, adapters::HttpResponse> read_zone(const ZoneLibrary& zones,
                                                                                               const Call& call);
/// POST /api/v1/zone/switch: another zone, by name or whole; 422 where the core refuses it.
[[nodiscard]] adapters::HttpResponse switch_zone(CallContext& context, const Call& call);
/// PUT /api/v1/priorities: the priorities of vehicles.
[[nodiscard]] adapters::HttpResponse put_priorities(CallContext& context, const Call& call);
/// POST /api/v1/zone/edit: changes tags, beacons or priorities.
[[nodiscard]] adapters::HttpResponse edit_zone(CallContext& context, const Call& call);
/// POST /api/v1/zone/undo.
[[nodiscard]] adapters::HttpResponse undo_zone(CallContext& context, const Call& call);
/// POST /api/v1/zone/redo.
[[nodiscard]] adapters::HttpResponse redo_zone(CallContext& context, const Call& call);
/// POST /api/v1/zone/save: writes the zone to its file, or to the user's folder of zones.
[[nodiscard]] adapters::HttpResponse save_zone(CallContext& context, const Call& call);

}  // namespace cosiva::app
