#pragma once

#include "cosiva/zone/lif/lif_document.h"
#include "cosiva/zone/lif/lif_fields.h"

namespace cosiva::zone::lif {

/// What the properties of an edge are read with.
struct EdgeRules {
  double scale;        ///< metres per unit of the file's coordinates
  double heading_rad;  ///< of the straight line from its first node to its last one
  bool is_version_2;
};

/// Properties of one vehicle type, of LIF 1.0 and of the draft of 2.0; what vehicles cannot do is reported as lost.
/// False: neither loaded nor unloaded vehicles may be there.
[[nodiscard]] bool read_node_properties(const LifFields& properties, Node& node);
[[nodiscard]] bool read_edge_properties(const LifFields& properties, const EdgeRules& rules, Edge& edge);

}  // namespace cosiva::zone::lif
