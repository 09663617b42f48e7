#pragma once

#include "cosiva/app/traffic/traffic_arguments.h"

namespace cosiva::app {

/// `cosiva traffic --zones`: several zones with transfer points between them. Gives the exit status as run_traffic
/// does.
int run_site(const FleetTrafficArguments& arguments);

}  // namespace cosiva::app
