#pragma once

#include "cosiva/zone/lif/lif_diagnostics.h"
#include "cosiva/zone/lif/lif_document.h"

namespace cosiva::zone::lif {

/// Moves nodes and trajectories by whole kilometres, with a diagnostic, where coordinates are beyond 100 km.
void move_origin(Document& document, LifDiagnostics& diagnostics);

}  // namespace cosiva::zone::lif
