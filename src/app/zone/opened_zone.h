#pragma once

#include "cosiva/app/zone/zone_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {

/// The zone of a subcommand's arguments, with their sidecar file and pitch. Fails as load_zone(name, sidecar) and
/// zone::with_pitch do.
[[nodiscard]] Result<zone::ZoneConfiguration> load_zone(const ZoneArguments& arguments);
/// The same, built. Fails as Rtm::initialise does, too.
[[nodiscard]] Result<zone::Rtm> open_zone(const ZoneArguments& arguments);

}  // namespace cosiva::app
