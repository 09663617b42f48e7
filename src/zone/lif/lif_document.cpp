#include "cosiva/zone/lif/lif_document.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>

#include "cosiva/base/math.h"
#include "cosiva/zone/lif/lif_fields.h"
#include "cosiva/zone/lif/lif_origin.h"
#include "cosiva/zone/lif/lif_properties.h"

namespace cosiva::zone::lif {
namespace {

constexpr auto mended = Diagnostic::Kind::mended;
constexpr auto lost = Diagnostic::Kind::lost;

constexpr double any_coordinate_max_m = 1e9;

using TypeId = std::uint32_t;

/// Vehicle types that may use a node or an edge.
struct Types {
  bool all{false};            ///< not given in the file
  std::vector<TypeId> ids{};  ///< sorted

  [[nodiscard]] bool has(TypeId id) const { return all || std::binary_search(ids.begin(), ids.end(), id); }
};

/// The vehicle types that properties are for: the vehicleTypeId of LIF 1.0, or the vehicleTypeIds of 2.0.
std::vector<std::string> types_of(const LifFields& properties) {
  std::vector<std::string> names;
  if (auto name = properties.text("vehicleTypeId")) names.push_back(*std::move(name));
  properties.each("vehicleTypeIds", [&](const LifFields& type) {
    if (auto name = type.text()) names.push_back(*std::move(name));
  });
  return names;
}

class Reader {
 public:
  Reader(const Selection& selection, LifDiagnostics& diagnostics) : selection_{selection}, diagnostics_{diagnostics} {}
  Result<Document> read(const JsonValue& json);

 private:
  /// Of a layout of version 2.0; of version 1.0 all layouts have one origin.
  struct OriginId {
    std::size_t index{0};
    std::optional<std::string> id{};
  };
  /// The data of an item that are read before the vehicle type is chosen.
  struct Item {
    const JsonValue* value;
    Types types;
    bool taken{true};
  };

  void read_meta(const LifFields& root);
  void read_origins(const LifFields& root);
  template <typename Visit>
  std::size_t each_layout(const LifFields& root, const Visit& visit) const;
  [[nodiscard]] bool is_selected(const LifFields& layout, const OriginId& origin) const;
  bool read_layout(const LifFields& layout, const OriginId& origin);
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
  void drop_closed();
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
  bool is_version_2_{false};
  std::optional<std::size_t> origin_;  ///< of the layouts taken
};

void Reader::stop(std::string code, std::string message, std::string location) {
  if (!error_) error_ = Error{std::move(code), std::move(message), std::move(location)};
}

Result<Document> Reader::read(const JsonValue& json) {
  const LifFields root{diagnostics_, json, {}};
  if (!root.is_object()) return fail("zone.missing", "expected an object with metaInformation and layouts");
  is_version_2_ =
      root.has("origins") || root.object("metaInformation").text("lifVersion").value_or("").starts_with("2.");
  if (is_version_2_) diagnostics_.set_version("2.0");
  root.known({"metaInformation", "layouts", "origins"});
  read_meta(root);
  read_origins(root);

  // Edges may lead to nodes of later layouts, and stations too.
  std::vector<bool> taken;
  const std::size_t count = each_layout(root, [&](const LifFields& layout, const OriginId& origin) {
    taken.push_back(!error_ && read_layout(layout, origin));
  });
  if (count == 0)
    return fail("zone.missing", "expected a list of at least one layout, found none",
                root.has("origins") ? "origins" : "layouts");
  if (error_) return tl::unexpected(*error_);
  if (document_.layouts.empty()) {
    return fail(
        "zone.field",
        "[import] layout is '" + printable(selection_.layout.value_or("")) + "', but this file has: " + other_layouts_,
        "layouts");
  }
  std::size_t index = 0;
  each_layout(root, [&](const LifFields& layout, const OriginId&) {
    if (!taken[index++]) return;
    if (!layout.has("stations") && !is_version_2_)
      layout.record(mended, "stations", "the list of stations is missing; there are none");
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
    const Edge& edge = document_.edges[i];
    edge_items_[i].taken = edge_items_[i].taken && node_items_[edge.from].taken && node_items_[edge.to].taken;
    if (edge_items_[i].taken) read_edge_properties(i);
  }
  drop_closed();
  move_origin(document_, diagnostics_);
  return std::move(document_);
}

void Reader::read_meta(const LifFields& root) {
  const LifFields meta = root.object("metaInformation");
  meta.known({"projectIdentification", "lifId", "creator", "exportTimestamp", "lifVersion"});
  const std::string_view name = is_version_2_ ? "lifId" : "projectIdentification";
  for (const std::string_view key :
       {name, std::string_view{"creator"}, std::string_view{"exportTimestamp"}, std::string_view{"lifVersion"}}) {
    if (!meta.has(key)) meta.record(mended, key, "'" + std::string(key) + "' is missing; read all the same");
  }
  document_.project = printable(meta.text("projectIdentification").value_or(meta.text("lifId").value_or("")));
  const auto version = meta.text("lifVersion");
  if (version && !version->starts_with(is_version_2_ ? "2." : "1."))
    meta.record(mended, "lifVersion",
                "the file has version '" + printable(version->substr(0, 40)) + "'; read as " +
                    (is_version_2_ ? "2.0.0" : "1.0.0"));
}

void Reader::read_origins(const LifFields& root) {
  root.each("origins", [](const LifFields& origin) {
    if (!origin.is_object()) return origin.record(lost, {}, "no object where an origin belongs; not taken");
    origin.known({"originId", "originDescription", "layouts"});
    if (!origin.has("originId"))
      origin.record(mended, "originId", "an origin without an id; its layouts are taken all the same");
    origin.lose("originDescription", "a zone has none");
  });
}

/// Calls visit(layout, origin) for each, in the file's order, and returns their number.
template <typename Visit>
std::size_t Reader::each_layout(const LifFields& root, const Visit& visit) const {
  std::size_t count = 0;
  OriginId id;
  const auto counted = [&](const LifFields& layout) {
    ++count;
    visit(layout, id);
  };
  root.each("origins", [&](const LifFields& origin) {
    id.id = origin.text("originId");
    origin.each("layouts", counted);
    ++id.index;
  });
  id.id.reset();
  root.each("layouts", counted);
  return count;
}

/// By the layout's id or name, or by its origin's id.
bool Reader::is_selected(const LifFields& layout, const OriginId& origin) const {
  return !selection_.layout || layout.text("layoutId") == selection_.layout ||
         layout.text("layoutName") == selection_.layout || origin.id == selection_.layout;
}

/// Its nodes; false: the layout is not taken.
bool Reader::read_layout(const LifFields& layout, const OriginId& origin) {
  layout.known(
      {"layoutId", "layoutName", "layoutVersion", "layoutLevelId", "layoutDescription", "nodes", "edges", "stations"});
  if (!layout.is_object()) {
    layout.record(lost, {}, "no object where a layout belongs; not taken");
    return false;
  }
  const auto id = layout.text("layoutId");
  if (!is_selected(layout, origin)) {
    layout.record(lost, {}, "only the layout that [import] names is taken");
    if (other_layouts_.size() < 200)
      other_layouts_ += (other_layouts_.empty() ? "" : ", ") + printable(id.value_or("?"));
    return false;
  }
  if (origin_.value_or(origin.index) != origin.index) {
    layout.record(lost, {},
                  "positions of different origins cannot be compared; [import] layout takes the layouts of this origin "
                  "instead of those of the first");
    return false;
  }
  origin_ = origin.index;
  if (!id) layout.record(mended, "layoutId", "a layout without an id; taken all the same");
  if (!layout.has("layoutVersion"))
    layout.record(mended, "layoutVersion", "'layoutVersion' is missing; it is not needed");
  layout.lose("layoutName", "a zone has one name only");
  layout.lose("layoutDescription", "a zone has none");
  document_.layouts.push_back({id.value_or(""), layout.text("layoutLevelId")});
  layout.each("nodes", [&](const LifFields& node) {
    if (!error_) read_node(node);
  });
  return true;
}

Types Reader::read_types(const LifFields& fields, std::string_view key) {
  Types types;
  fields.each(key, [&](const LifFields& properties) {
    const auto names = types_of(properties);
    if (names.empty()) return properties.record(lost, "vehicleTypeId", "properties of no vehicle type; not taken");
    for (const std::string& name : names) {
      const auto [known, fresh] = type_by_name_.emplace(name, static_cast<TypeId>(types_.size()));
      if (fresh) types_.push_back(name);
      types.ids.push_back(known->second);
    }
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

  node.lose("nodeName", "a node is identified by its id");
  node.lose("nodeDescription", "a node is identified by its id");
  if (node.text("mapId").value_or(document_.project) != document_.project)
    node.lose("mapId", "in orders the map's id is the zone's name");
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
    edge.lose("edgeName", "an edge is identified by its id");
    section.clear();
  }
  edge.lose("edgeDescription", "an edge is identified by its id");
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
  station.lose("stationDescription", "a station is identified by its name");
  (void)station.number("stationHeight");
  station.lose("stationHeight", "a zone is flat");
  const LifFields position = station.object("stationPosition");
  position.known({"x", "y", "theta"});
  station.lose("stationPosition", "a station lies where vehicles stop, at its interaction nodes");
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
    const auto names = types_of(properties);
    if (std::find(names.begin(), names.end(), types_[type_]) == names.end()) return;
    if (found) return properties.record(lost, {}, "the vehicle type's properties a second time; not taken");
    found = true;
    visit(properties);
  });
}

void Reader::read_node_properties(std::size_t index) {
  Node& node = document_.nodes[index];
  visit_properties(node_items_[index], node.location, "vehicleTypeNodeProperties", [&](const LifFields& properties) {
    if (!lif::read_node_properties(properties, node)) node_items_[index].taken = false;
  });
}

void Reader::read_edge_properties(std::size_t index) {
  Edge& edge = document_.edges[index];
  const Point2 from = document_.nodes[edge.from].at;
  const Point2 to = document_.nodes[edge.to].at;
  const EdgeRules rules{selection_.scale, det_atan2(to.y_m - from.y_m, to.x_m - from.x_m), is_version_2_};
  visit_properties(edge_items_[index], edge.location, "vehicleTypeEdgeProperties", [&](const LifFields& properties) {
    if (!lif::read_edge_properties(properties, rules, edge)) edge_items_[index].taken = false;
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

}  // namespace

Result<Document> read_document(const JsonValue& json, const Selection& selection, LifDiagnostics& diagnostics) {
  return Reader{selection, diagnostics}.read(json);
}

}  // namespace cosiva::zone::lif
