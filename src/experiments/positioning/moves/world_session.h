#pragma once

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/positioning/metrology/platform_test.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::experiments {

/// Carries a test's messages in a world in virtual time until the test is done, as a live session does on a running
/// platform: the vehicles' own programs respond, and the emulated plant.
/// @param aivs     number of physical AIVs, for which the test waits
/// @param longest  virtual time after which the test is ended, with the runs that are complete by then
/// Fails ("moves.fleet") where the fleet is not complete within two minutes.
[[nodiscard]] Result<void> drive_in_world(PlatformTest& test, World& world, std::uint32_t aivs, SimDuration longest);

}  // namespace cosiva::experiments
