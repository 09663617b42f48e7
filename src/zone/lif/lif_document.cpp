#include "cosiva/zone/lif/lif_document.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>

#include "cosiva/zone/lif/lif_fields.h"
#include "cosiva/zone/lif/lif_trajectory.h"

namespace cosiva::zone::lif {
namespace {

constexpr auto mended = Diagnostic::Kind::mended;
constexpr auto lost = Diagnostic::Kind::lost;

/// Beyond this a file's origin is moved: positions are sent as numbers that keep a millimetre up to here.
constexpr double coordinate_max_m = 1e5;
constexpr double any_coordinate_max_m = 1e9;
constexpr double speed_max_mps = 100.0;

using TypeId = std::uint32_t;

/// Vehicle types that may use a node or an edge.
struct Types {
  bool all{false};            ///< not given in the file
  std::vector<TypeId> ids{};  ///< sorted

  [[nodiscard]] bool has(TypeId id) const { return all || std::binary_search(ids.begin(), ids.end(), id); }
};

/// Ids are displayed and sent in messages.
std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

class Reader {
 public:
  Reader(const Selection& selection, LifDiagnostics& diagnostics) : selection_{selection}, diagnostics_{diagnostics} {}
  Result<Document> read(const JsonValue& json);

 private:
  /// The data of an item that are read before the vehicle type is chosen.
  struct Item {
    const JsonValue* value;
    Types types;
    bool taken{true};
  };

  void read_meta(const LifFields& root);
  bool read_layout(const LifFields& layout);
  void read_node(const LifFields& node);
  void read_edge(const LifFields& edge);
  void read_station(const LifFields& station);
  [[nodiscard]] std::optional<std::size_t> find_node(const LifFields& fields, std::string_view key,
                                                     const std::string& id) const;
  [[nodiscard]] Types read_types(const LifFields& fields, std::string_view key);
  [[nodiscard]] bool usable(std::size_t edge, TypeId type) const;
  void choose_type();
  void close_others();
  template <typename Visit>
  void visit_properties(const Item& item, const std::string& location, std::string_view key, const Visit& visit) const;
  void read_node_properties(std::size_t index);
  void read_edge_properties(std::size_t index);
  [[nodiscard]] static Rotation read_rotation(const LifFields& fields, std::string_view key);
  void drop_closed();
  void move_origin();
  void stop(std::string code, std::string message, std::string location);
  /// Layouts with common ids cannot be one zone, but each alone can.
  [[nodiscard]] const char* one_layout_hint() const {
    return document_.layouts.size() > 1 ? ", as layouts may not; [import] layout in the sidecar file takes one alone"
                                        : "";
  }

  const Selection& selection_;
  LifDiagnostics& diagnostics_;
  std::optional<Error> error_;
  Document document_;
  std::string other_layouts_;  ///< names of those not taken
  std::vector<Item> node_items_;
  std::vector<Item> edge_items_;
  std::map<std::string, std::size_t, std::less<>> node_by_id_;
  std::map<std::string, std::size_t, std::less<>> edge_by_id_;
  std::vector<std::string> types_;
  std::map<std::string, TypeId, std::less<>> type_by_name_;
  TypeId type_{};
};

void lose(const LifFields& fields, std::string_view key, std::string_view why) {
  if (!fields.has(key)) return;
  std::string text = "'";
  text.append(key).append("' is not taken: ").append(why);
  fields.record(lost, key, std::move(text));
}

void Reader::stop(std::string code, std::string message, std::string location) {
  if (!error_) error_ = Error{std::move(code), std::move(message), std::move(location)};
}

Result<Document> Reader::read(const JsonValue& json) {
  const LifFields root{diagnostics_, json, {}};
  if (!root.is_object()) return fail("zone.missing", "expected an object with metaInformation and layouts");
  root.known({"metaInformation", "layouts"});
  read_meta(root);

  // Edges may lead to nodes of later layouts, and stations too.
  std::vector<bool> taken;
  const auto count =
      root.each("layouts", [&](const LifFields& layout) { taken.push_back(!error_ && read_layout(layout)); });
  if ((!count || *count == 0) && root.has("origins"))
    return fail("zone.version",
                "expected a list of layouts, found origins, as version 2.0 of LIF has them; this program reads LIF 1.0",
                "origins");
  if (!count || *count == 0)
    return fail("zone.missing", "expected a list of at least one layout, found none", "layouts");
  if (error_) return tl::unexpected(*error_);
  if (document_.layouts.empty()) {
    return fail(
        "zone.field",
        "[import] layout is '" + printable(selection_.layout.value_or("")) + "', but this file has: " + other_layouts_,
        "layouts");
  }
  std::size_t index = 0;
  root.each("layouts", [&](const LifFields& layout) {
    if (!taken[index++]) return;
    if (!layout.has("stations")) layout.record(mended, "stations", "the list of stations is missing; there are none");
    layout.each("edges", [&](const LifFields& edge) {
      if (!error_) read_edge(edge);
    });
    layout.each("stations", [&](const LifFields& station) {
      if (!error_) read_station(station);
    });
  });
  if (error_) return tl::unexpected(*error_);

  choose_type();
  if (error_) return tl::unexpected(*error_);
  close_others();
  for (std::size_t i = 0; i < document_.nodes.size(); ++i) read_node_properties(i);
  for (std::size_t i = 0; i < document_.edges.size(); ++i) {
    if (edge_items_[i].taken) read_edge_properties(i);
  }
  drop_closed();
  move_origin();
  return std::move(document_);
}

void Reader::read_meta(const LifFields& root) {
  const LifFields meta = root.object("metaInformation");
  meta.known({"projectIdentification", "creator", "exportTimestamp", "lifVersion"});
  for (const std::string_view key : {"projectIdentification", "creator", "exportTimestamp", "lifVersion"}) {
    if (!meta.has(key)) meta.record(mended, key, "'" + std::string(key) + "' is missing; read all the same");
  }
  document_.project = printable(meta.text("projectIdentification").value_or(""));
  const auto version = meta.text("lifVersion");
  if (version && !version->starts_with("1."))
    meta.record(mended, "lifVersion",
                "the file has version '" + printable(version->substr(0, 40)) + "'; read as 1.0.0");
}

/// Its nodes; false: the layout is not taken.
bool Reader::read_layout(const LifFields& layout) {
  layout.known(
      {"layoutId", "layoutName", "layoutVersion", "layoutLevelId", "layoutDescription", "nodes", "edges", "stations"});
  if (!layout.is_object()) {
    layout.record(lost, {}, "no object where a layout belongs; not taken");
    return false;
  }
  const auto id = layout.text("layoutId");
  if (selection_.layout && id != selection_.layout && layout.text("layoutName") != selection_.layout) {
    layout.record(lost, {}, "only the layout that [import] names is taken");
    if (other_layouts_.size() < 200)
      other_layouts_ += (other_layouts_.empty() ? "" : ", ") + printable(id.value_or("?"));
    return false;
  }
  if (!id) layout.record(mended, "layoutId", "a layout without an id; taken all the same");
  if (!layout.has("layoutVersion"))
    layout.record(mended, "layoutVersion", "'layoutVersion' is missing; it is not needed");
  lose(layout, "layoutName", "a zone has one name only");
  lose(layout, "layoutDescription", "a zone has none");
  document_.layouts.push_back({id.value_or(""), layout.text("layoutLevelId")});
  layout.each("nodes", [&](const LifFields& node) {
    if (!error_) read_node(node);
  });
  return true;
}

Types Reader::read_types(const LifFields& fields, std::string_view key) {
  Types types;
  fields.each(key, [&](const LifFields& properties) {
    const auto name = properties.text("vehicleTypeId");
    if (!name) return properties.record(lost, "vehicleTypeId", "properties of no vehicle type; not taken");
    const auto [known, fresh] = type_by_name_.emplace(*name, static_cast<TypeId>(types_.size()));
    if (fresh) types_.push_back(*name);
    types.ids.push_back(known->second);
  });
  std::sort(types.ids.begin(), types.ids.end());
  types.ids.erase(std::unique(types.ids.begin(), types.ids.end()), types.ids.end());
  if (types.ids.empty()) {
    types.all = true;
    fields.record(mended, key, "no vehicle type is named; open to all");
  }
  return types;
}

void Reader::read_node(const LifFields& node) {
  node.known({"nodeId", "nodeName", "nodeDescription", "mapId", "nodePosition", "vehicleTypeNodeProperties"});
  const auto id = node.text("nodeId");
  if (!id || id->empty()) return node.record(lost, "nodeId", "a node without an id; not taken");
  const LifFields position = node.object("nodePosition");
  position.known({"x", "y"});
  const auto x = position.number("x");
  const auto y = position.number("y");
  if (!x || !y) return node.record(lost, "nodePosition", "a node without a position; not taken");
  if (!(std::fabs(*x * selection_.scale) <= any_coordinate_max_m &&
        std::fabs(*y * selection_.scale) <= any_coordinate_max_m))
    return node.record(lost, "nodePosition", "a node more than a million kilometres away; not taken");
  if (document_.nodes.size() >= nodes_max)
    return stop("zone.size", "expected at most " + std::to_string(nodes_max) + " nodes", node.location());
  if (!node_by_id_.emplace(*id, document_.nodes.size()).second)
    return stop("zone.duplicate", "two nodes have the id '" + printable(*id) + "'" + one_layout_hint(),
                node.location("nodeId"));

  lose(node, "nodeName", "a node is identified by its id");
  lose(node, "nodeDescription", "a node is identified by its id");
  if (node.text("mapId").value_or(document_.project) != document_.project)
    lose(node, "mapId", "in orders the map's id is the zone's name");
  document_.nodes.push_back({printable(*id),
                             node.location(),
                             document_.layouts.size() - 1,
                             {selection_.scale * *x, selection_.scale * *y},
                             false});
  node_items_.push_back({node.value(), read_types(node, "vehicleTypeNodeProperties")});
}

std::optional<std::size_t> Reader::find_node(const LifFields& fields, std::string_view key,
                                             const std::string& id) const {
  const auto found = node_by_id_.find(id);
  if (found != node_by_id_.end()) return found->second;
  fields.record(lost, key, "there is no node '" + printable(id.substr(0, 64)) + "' among those taken; not taken",
                std::string(key) + " dangles");
  return std::nullopt;
}

void Reader::read_edge(const LifFields& edge) {
  edge.known({"edgeId", "edgeName", "edgeDescription", "startNodeId", "endNodeId", "vehicleTypeEdgeProperties"});
  const auto start = edge.text("startNodeId");
  const auto end = edge.text("endNodeId");
  if (!start) return edge.record(lost, "startNodeId", "an edge without a node that it starts at; not taken");
  if (!end) return edge.record(lost, "endNodeId", "an edge without a node that it ends at; not taken");
  const auto from = find_node(edge, "startNodeId", *start);
  const auto to = find_node(edge, "endNodeId", *end);
  if (!from || !to) return;
  auto id = edge.text("edgeId");
  if (!id || id->empty()) {
    id = *start + "-" + *end;
    edge.record(mended, "edgeId", "an edge without an id is named after its nodes, '" + printable(*id) + "'",
                "no edgeId");
    while (edge_by_id_.contains(*id)) *id += '\'';
  }
  if (document_.edges.size() >= edges_max)
    return stop("zone.size", "expected at most " + std::to_string(edges_max) + " edges", edge.location());
  if (!edge_by_id_.emplace(*id, document_.edges.size()).second)
    return stop("zone.duplicate", "two edges have the id '" + printable(*id) + "'" + one_layout_hint(),
                edge.location("edgeId"));

  std::string section = edge.text("edgeName").value_or("");
  if (section.empty() || (*id != section && !id->starts_with(section + "."))) {
    lose(edge, "edgeName", "an edge is identified by its id");
    section.clear();
  }
  lose(edge, "edgeDescription", "an edge is identified by its id");
  document_.edges.push_back({printable(*id), edge.location(), *from, *to});
  document_.edges.back().section = std::move(section);
  edge_items_.push_back({edge.value(), read_types(edge, "vehicleTypeEdgeProperties")});
}

void Reader::read_station(const LifFields& station) {
  station.known({"stationId", "interactionNodeIds", "stationName", "stationDescription", "stationHeight",
                 "stationPosition", "stationType"});
  if (!station.is_object()) return station.record(lost, {}, "no object where a station belongs; not taken");
  const std::string id = printable(station.text("stationId").value_or(""));
  Station read{id, printable(station.text("stationName").value_or(id)), station.location(), {}, false};
  if (read.name.empty()) return station.record(lost, "stationId", "a station without an id; not taken");
  station.each("interactionNodeIds", [&](const LifFields& node) {
    if (const auto name = node.text()) {
      if (const auto index = find_node(node, {}, *name)) read.nodes.push_back(*index);
    }
  });
  // Not in LIF 1.0, but some programs write the field as 2.0 will define it.
  if (const auto type = station.text("stationType")) {
    read.charges = type->starts_with("CHARG");
    station.record(mended, "stationType",
                   "'stationType' is no field of LIF 1.0; used where it is CHARGING, otherwise ignored");
  }
  lose(station, "stationDescription", "a station is identified by its name");
  (void)station.number("stationHeight");
  lose(station, "stationHeight", "a zone is flat");
  const LifFields position = station.object("stationPosition");
  position.known({"x", "y", "theta"});
  lose(station, "stationPosition", "a station lies where vehicles stop, at its interaction nodes");
  document_.stations.push_back(std::move(read));
}

bool Reader::usable(std::size_t edge, TypeId type) const {
  return edge_items_[edge].types.has(type) && node_items_[document_.edges[edge].from].types.has(type) &&
         node_items_[document_.edges[edge].to].types.has(type);
}

void Reader::choose_type() {
  if (types_.empty()) types_.emplace_back();
  std::vector<std::size_t> usable_edges(types_.size());
  std::vector<std::size_t> named_edges(types_.size());
  for (std::size_t edge = 0; edge < edge_items_.size(); ++edge) {
    const Types* types = &edge_items_[edge].types;
    if (types->all) types = &node_items_[document_.edges[edge].from].types;
    if (types->all) types = &node_items_[document_.edges[edge].to].types;
    for (const TypeId type : types->ids) {
      ++named_edges[type];
      if (usable(edge, type)) ++usable_edges[type];
    }
  }
  if (selection_.vehicle_type) {
    const auto known = type_by_name_.find(*selection_.vehicle_type);
    if (known == type_by_name_.end()) {
      std::string names;
      for (std::size_t i = 0; i < types_.size() && names.size() < 200; ++i)
        names += (i == 0 ? "" : ", ") + printable(types_[i]);
      return stop("zone.field",
                  "[import] vehicle_type is '" + printable(*selection_.vehicle_type) + "', but this file has: " + names,
                  "layouts");
    }
    type_ = known->second;
  } else {
    // The first of those with most edges.
    const auto most = [](const std::vector<std::size_t>& counts) {
      return static_cast<TypeId>(std::max_element(counts.begin(), counts.end()) - counts.begin());
    };
    type_ = most(usable_edges);
    if (usable_edges[type_] == 0) type_ = most(named_edges);
  }
  if (usable_edges[type_] == 0 && named_edges[type_] > 0) {
    for (Item& node : node_items_) node.types.all = true;
    diagnostics_.add(mended, "layouts",
                     "no edge leads between nodes that are open to its vehicle type; all nodes are open");
  }
  if (types_.size() > 1) {
    diagnostics_.add(Diagnostic::Kind::notice, "layouts",
                     "edges and properties are those of vehicle type '" + printable(types_[type_]) + "', one of " +
                         std::to_string(types_.size()) + "; [import] vehicle_type in the sidecar file chooses another");
  }
}

void Reader::close_others() {
  for (std::size_t i = 0; i < edge_items_.size(); ++i) edge_items_[i].taken = usable(i, type_);
  for (Item& node : node_items_) node.taken = node.types.has(type_);
  const auto closed = [](const std::vector<Item>& items) {
    return std::count_if(items.begin(), items.end(), [](const Item& item) { return !item.taken; });
  };
  const auto edges = closed(edge_items_);
  const auto nodes = closed(node_items_);
  if (edges + nodes == 0) return;
  diagnostics_.add(lost, "layouts",
                   std::to_string(edges) + " of " + std::to_string(edge_items_.size()) + " edges and " +
                       std::to_string(nodes) + " of " + std::to_string(node_items_.size()) +
                       " nodes are closed to vehicle type '" + printable(types_[type_]) + "'; not taken");
}

/// The properties for the chosen vehicle type: the first such where there are several.
template <typename Visit>
void Reader::visit_properties(const Item& item, const std::string& location, std::string_view key,
                              const Visit& visit) const {
  const LifFields fields{diagnostics_, *item.value, {nullptr, location, 0}};
  bool found = false;
  fields.each(key, [&](const LifFields& properties) {
    if (properties.text("vehicleTypeId") != types_[type_]) return;
    if (found) return properties.record(lost, {}, "the vehicle type's properties a second time; not taken");
    found = true;
    visit(properties);
  });
}

void Reader::read_node_properties(std::size_t index) {
  Node& node = document_.nodes[index];
  visit_properties(node_items_[index], node.location, "vehicleTypeNodeProperties", [&](const LifFields& properties) {
    properties.known({"vehicleTypeId", "theta", "actions"});
    if (const auto theta = properties.number("theta"); theta && std::fabs(*theta) > 2.0 * pi + 1e-6)
      properties.record(mended, "theta", "an angle beyond ±2π must be meant in degrees");
    lose(properties, "theta", "a stopped vehicle has the heading of its path");
    bool others = false;
    properties.each("actions", [&](const LifFields& action) {
      const auto type = action.text("actionType").value_or("");
      if (type == "startCharging") node.charges = true;
      if (type != "startCharging" && type != "stopCharging") others = true;
    });
    if (others) lose(properties, "actions", "vehicles do nothing at nodes but stop, turn and charge");
  });
}

Rotation Reader::read_rotation(const LifFields& fields, std::string_view key) {
  const auto word = fields.text(key);
  if (!word || *word == "BOTH") return Rotation::any;
  if (*word == "NONE") return Rotation::none;
  if (*word == "CW" || *word == "CCW") {
    fields.record(lost, key, "turning in one direction only is not supported: vehicles turn in the shorter direction");
    return Rotation::one_way;
  }
  fields.record(mended, key,
                "expected NONE, CW, CCW or BOTH, found '" + printable(word->substr(0, 40)) + "'; taken as BOTH");
  return Rotation::any;
}

void Reader::read_edge_properties(std::size_t index) {
  Edge& edge = document_.edges[index];
  visit_properties(edge_items_[index], edge.location, "vehicleTypeEdgeProperties", [&](const LifFields& properties) {
    properties.known({"vehicleTypeId", "vehicleOrientation", "orientationType", "rotationAllowed",
                      "rotationAtStartNodeAllowed", "rotationAtEndNodeAllowed", "maxSpeed", "maxRotationSpeed",
                      "minHeight", "maxHeight", "loadRestriction", "actions", "trajectory", "reentryAllowed"});
    const double orientation = properties.number("vehicleOrientation").value_or(0.0);
    if (std::fabs(orientation) > 2.0 * pi + 1e-6)
      properties.record(mended, "vehicleOrientation", "an angle beyond ±2π must be meant in degrees");
    if (orientation != 0.0 || properties.text("orientationType").value_or("TANGENTIAL") != "TANGENTIAL")
      properties.record(lost, "vehicleOrientation",
                        "another orientation than along the path is not supported: vehicles drive forwards");
    if (!properties.has("rotationAllowed"))
      properties.record(mended, "rotationAllowed",
                        "'rotationAllowed' is missing; vehicles do not turn on edges anyway");
    else if (properties.flag("rotationAllowed").value_or(false))
      properties.record(lost, "rotationAllowed", "turning while driving is not supported: vehicles turn at nodes only");
    edge.leaving = read_rotation(properties, "rotationAtStartNodeAllowed");
    edge.arriving = read_rotation(properties, "rotationAtEndNodeAllowed");
    if (const auto speed = properties.number("maxSpeed")) {
      if (*speed > 0.0 && *speed <= speed_max_mps)
        edge.speed_mps_max = *speed;
      else
        properties.record(mended, "maxSpeed", "expected a positive speed of at most 100 m/s; taken as absent");
    }
    lose(properties, "maxRotationSpeed", "turns on the spot have one speed everywhere");
    lose(properties, "minHeight", "a zone is flat");
    lose(properties, "maxHeight", "a zone is flat");
    lose(properties, "loadRestriction", "vehicles drive here with and without load");
    lose(properties, "actions", "vehicles do nothing on edges but drive");
    if (properties.has("reentryAllowed") && !properties.flag("reentryAllowed").value_or(true))
      lose(properties, "reentryAllowed", "vehicles do not turn round on edges anyway");
    const LifFields trajectory = properties.object("trajectory");
    if (trajectory.is_object()) edge.trajectory = read_trajectory(trajectory, selection_.scale);
  });
}

/// Keeps all nodes, so that indices stay valid; only edges and stations' nodes are removed.
void Reader::drop_closed() {
  std::vector<Edge> kept;
  for (std::size_t i = 0; i < document_.edges.size(); ++i) {
    if (edge_items_[i].taken) kept.push_back(std::move(document_.edges[i]));
  }
  document_.edges = std::move(kept);
  for (Station& station : document_.stations)
    std::erase_if(station.nodes, [this](std::size_t node) { return !node_items_[node].taken; });
}

void Reader::move_origin() {
  if (document_.nodes.empty()) return;
  Point2 low = document_.nodes.front().at;
  Point2 high = low;
  for (const Node& node : document_.nodes) {
    low = {std::min(low.x_m, node.at.x_m), std::min(low.y_m, node.at.y_m)};
    high = {std::max(high.x_m, node.at.x_m), std::max(high.y_m, node.at.y_m)};
  }
  const auto far = [](Point2 p) { return std::max(std::fabs(p.x_m), std::fabs(p.y_m)) > coordinate_max_m; };
  if (!far(low) && !far(high)) return;
  // Whole kilometres, so that coordinates remain easy to compare.
  const auto kilometres = [](double a, double b) { return 1000.0 * std::round(0.5 * (a + b) / 1000.0); };
  const Point2 origin{kilometres(low.x_m, high.x_m), kilometres(low.y_m, high.y_m)};
  for (Node& node : document_.nodes) node.at = {node.at.x_m - origin.x_m, node.at.y_m - origin.y_m};
  for (Edge& edge : document_.edges) {
    if (!edge.trajectory) continue;
    for (Point2& point : edge.trajectory->points) point = {point.x_m - origin.x_m, point.y_m - origin.y_m};
  }
  const auto whole = [](double value) { return std::to_string(static_cast<long long>(value)); };
  diagnostics_.add(mended, "layouts",
                   "coordinates beyond 100 km: the zone's origin is the file's (" + whole(origin.x_m) + " m, " +
                       whole(origin.y_m) + " m)");
}

}  // namespace

Result<Document> read_document(const JsonValue& json, const Selection& selection, LifDiagnostics& diagnostics) {
  return Reader{selection, diagnostics}.read(json);
}

}  // namespace cosiva::zone::lif
