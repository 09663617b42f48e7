#include "cosiva/app/zone/written_zone.h"

#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/zone/zone_report.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {

Result<WrittenZone> write_as(const std::string& format, const std::string& file, const zone::TrafficZone& zone) {
  const auto factory = zone::circuit_factory_for(format);
  if (!factory) return tl::unexpected(factory.error());
  if (zone.circuit.indirect())
    return fail("zone.write",
                "a zone of indirect travel has no file of its own: convert the zone that it is travelled in, whose "
                "travel_direction is direct",
                file);
  WrittenZone made{format, file, {}, {}};
  const auto written = (*factory)->written(zone, made.lost);
  if (!written) return tl::unexpected(written.error());
  if (!written->sidecar.empty()) {
    const auto sidecar = zone::sidecar_of_file(file);
    if (!sidecar)
      return fail("zone.write",
                  "this format needs a sidecar file, so the file's name must have the format's usual ending", file);
    made.sidecar = *sidecar;
  }
  if (auto stored = write_zone(file, *written); !stored) return tl::unexpected(stored.error());
  return made;
}

std::string written_json_of(const zone::TrafficZone& zone, const WrittenZone& made) {
  JsonWriter json;
  json.begin_object().field("zone", zone.name).field("format", made.format).field("file", made.file).key("sidecar");
  if (made.sidecar.empty())
    json.null();
  else
    json.value(made.sidecar);
  json.field("sections", zone.circuit.size()).field("length_m", zone.circuit.total_length_m());
  json.field("stations", zone.stations.size());
  write_diagnostics(json.key("diagnostics"), zone.diagnostics);
  write_diagnostics(json.key("lost"), made.lost);
  json.end_object();
  return json.take();
}

std::string written_text_of(const zone::TrafficZone& zone, const WrittenZone& made) {
  return zone.name + ": " + size_of(zone) + ", " + counted(zone.stations.size(), "station") + ", written to " +
         made.file + (made.sidecar.empty() ? "" : "\n  what this format cannot express: " + made.sidecar) +
         report_of(zone.diagnostics, "reading it") + report_of(made.lost, "writing it");
}

}  // namespace cosiva::app
