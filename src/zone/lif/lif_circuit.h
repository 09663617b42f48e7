#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/geometry/fit.h"
#include "cosiva/zone/lif/lif_diagnostics.h"
#include "cosiva/zone/lif/lif_document.h"

namespace cosiva::zone::lif {

/// The sections of a document, joined at its nodes.
struct Tracks {
  std::vector<Circuit::Part> parts;
  std::vector<std::string> start_ids;  ///< by section: its node's id; empty inside a trajectory
  std::vector<std::string> end_ids;
  std::vector<zone::Station> stations;
};

/// Fails ("circuit.empty") where no edge is left, ("zone.size") where there are too many sections or joints.
[[nodiscard]] Result<Tracks> make_tracks(const Document& document, FitTolerance tolerance, LifDiagnostics& diagnostics);

}  // namespace cosiva::zone::lif
