#include "cosiva/app/zone/opened_zone.h"

#include <utility>

#include "cosiva/app/resources/zone_files.h"

namespace cosiva::app {

Result<zone::ZoneConfiguration> load_zone(const ZoneArguments& arguments) {
  auto configuration = load_zone(arguments.zone, arguments.sidecar);
  if (configuration && arguments.pitch_m) configuration = zone::with_pitch(*configuration, *arguments.pitch_m);
  if (configuration && arguments.stations) configuration = zone::with_stations(*configuration, *arguments.stations);
  return configuration;
}

Result<zone::Rtm> open_zone(const ZoneArguments& arguments) {
  auto configuration = load_zone(arguments);
  if (!configuration) return tl::unexpected(configuration.error());
  return zone::Rtm::initialise(*std::move(configuration));
}

}  // namespace cosiva::app
