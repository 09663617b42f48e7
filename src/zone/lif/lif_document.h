#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/lif/lif_diagnostics.h"
#include "cosiva/zone/lif/nurbs.h"

namespace cosiva::zone::lif {

inline constexpr std::size_t edges_max = 100'000;
inline constexpr std::size_t nodes_max = 1'000'000;

/// The permitted turn of a vehicle on the spot at one end of an edge.
enum class Rotation { any, one_way, none };

struct Node {
  std::string id;
  std::string location;  ///< in the file
  std::size_t layout;    ///< index into Document::layouts
  Point2 at{};
  bool charges{false};  ///< offers startCharging
};

struct Edge {
  std::string id;
  std::string location;
  std::size_t from;  ///< index into Document::nodes; so is `to`
  std::size_t to;
  Rotation leaving{Rotation::any};   ///< at `from`
  Rotation arriving{Rotation::any};  ///< at `to`
  std::string section{};  ///< the edge of which it is a piece, as our writer names it: edgeName of X, X.2, X.3 …
  std::optional<double> speed_mps_max{};
  std::optional<Nurbs> trajectory{};
};

struct Station {
  std::string id;
  std::string name;
  std::string location;
  std::vector<std::size_t> nodes;
  bool charges{false};  ///< from its own field
};

struct Layout {
  std::string id;
  std::optional<std::string> level;
};

/// The part of a LIF file that vehicles of one type may use. Node and edge ids are unique, and coordinates small enough
/// to be driven in.
struct Document {
  std::string project;
  std::vector<Layout> layouts;
  std::vector<Node> nodes;
  std::vector<Edge> edges;
  std::vector<Station> stations;
};

/// The part of a file to read.
struct Selection {
  std::optional<std::string> vehicle_type;  ///< none: the one for which there are most edges
  std::optional<std::string> layout;        ///< by id or name; none: all
  double scale{1.0};                        ///< metres per unit of the file's coordinates
};

/// Reads leniently: a faulty item is repaired with a diagnostic, or lost. An error's location is one in the file,
/// without the file's name. Fails ("zone.missing") where there are no layouts, ("zone.duplicate") on two nodes or edges
/// of one id, ("zone.size") on too many, ("zone.field") where the selection finds nothing.
[[nodiscard]] Result<Document> read_document(const JsonValue& json, const Selection& selection,
                                             LifDiagnostics& diagnostics);

}  // namespace cosiva::zone::lif
