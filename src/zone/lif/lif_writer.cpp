#include "cosiva/zone/lif/lif_writer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <queue>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/zone/lif/lif_circuit.h"
#include "cosiva/zone/lif/lif_document.h"
#include "cosiva/zone/lif/lif_factory.h"
#include "cosiva/zone/lif/nurbs_of.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_write.h"

namespace cosiva::zone::lif {
namespace {

constexpr std::string_view vehicle_type = "CoSiVA";
constexpr double at_node_m = 1e-3;

/// The two ends of each section, and which of them are one node.
class Ends {
 public:
  explicit Ends(const Circuit& circuit) : node_(2 * circuit.size()) {
    std::iota(node_.begin(), node_.end(), std::size_t{0});
    for (SectionId id = 0; id < circuit.size(); ++id) {
      for (const SectionId after : circuit.next(id)) unite(end(id), start(after));
    }
  }
  static std::size_t start(SectionId id) { return 2 * std::size_t{id}; }
  static std::size_t end(SectionId id) { return 2 * std::size_t{id} + 1; }
  [[nodiscard]] std::size_t size() const { return node_.size(); }
  /// The same for all ends at one node: the least of them.
  [[nodiscard]] std::size_t node(std::size_t of) const {
    while (node_[of] != of) of = node_[of];
    return of;
  }

 private:
  void unite(std::size_t a, std::size_t b) {
    a = node(a);
    b = node(b);
    node_[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::size_t> node_;
};

class Writer {
 public:
  Writer(const TrafficZone& zone, std::vector<Diagnostic>& lost) : zone_{zone}, lost_{lost}, ends_{zone.circuit} {}
  ZoneConfiguration write();

 private:
  void name_nodes();
  void name(std::size_t node, std::string id, Point2 at);
  void add_stations();
  [[nodiscard]] std::size_t node_at(TrackPosition track_position);
  [[nodiscard]] std::vector<SectionId> edges_in_order() const;
  void write_nodes();
  void write_section(SectionId id);
  void write_edge(SectionId id, const Section& piece, std::size_t number, std::size_t from, std::size_t to);
  void write_trajectory(const Section& section);
  void write_stations();
  void report_sidecar();
  void compare(const std::string& text);

  struct Node {
    std::string id;
    Point2 at;
    bool charges{false};
  };

  const TrafficZone& zone_;
  std::vector<Diagnostic>& lost_;
  Ends ends_;
  std::map<std::size_t, Node> nodes_;  ///< by Ends::node; beyond those, nodes between a section's ends
  std::map<SectionId, std::map<double, std::size_t>> cuts_;  ///< by arc length: nodes between a section's ends
  std::vector<std::size_t> station_nodes_;                   ///< by station
  std::set<std::string> node_ids_;
  JsonWriter json_{2};
};

ZoneConfiguration Writer::write() {
  name_nodes();
  add_stations();
  json_.begin_object().key("metaInformation").begin_object();
  // A core has no clock; the same zone gives the same file.
  json_.field("projectIdentification", zone_.name)
      .field("creator", "CoSiVA")
      .field("exportTimestamp", "1970-01-01T00:00:00.00Z")
      .field("lifVersion", "1.0.0")
      .end_object();
  json_.key("layouts").begin_array().begin_object();
  json_.field("layoutId", zone_.name).field("layoutVersion", "1");
  write_nodes();
  json_.key("edges").begin_array();
  for (const SectionId id : edges_in_order()) write_section(id);
  json_.end_array();
  write_stations();
  json_.end_object().end_array().end_object();
  std::string text = json_.take();
  text += '\n';

  report_sidecar();
  compare(text);
  return {"lif", zone_.name + ".lif.json", std::move(text),
          sidecar_text(zone_, {.limits = false, .stations = false, .closed = true})};
}

/// After the waypoint there, so that orders name the same positions as before.
void Writer::name_nodes() {
  std::map<SectionId, std::string> starts;
  std::map<SectionId, std::string> finishes;
  for (const Waypoint& at : zone_.waypoints) {
    const double length_m = zone_.circuit.section(at.position.section).length_m();
    if (at.position.s_m <= at_node_m) starts.emplace(at.position.section, at.id);
    if (length_m - at.position.s_m <= at_node_m) finishes.emplace(at.position.section, at.id);
  }
  // Starts first: a joint lies where the successor begins.
  for (SectionId id = 0; id < zone_.circuit.size(); ++id) {
    const auto known = starts.find(id);
    name(ends_.node(Ends::start(id)), known != starts.end() ? known->second : zone_.circuit.part(id).name + "@0",
         position(zone_.circuit.section(id).start()));
  }
  for (SectionId id = 0; id < zone_.circuit.size(); ++id) {
    const Section& section = zone_.circuit.section(id);
    const auto known = finishes.find(id);
    const auto millimetres = static_cast<long long>(std::floor(section.length_m() * 1000.0 + 0.5));
    name(ends_.node(Ends::end(id)),
         known != finishes.end() ? known->second : zone_.circuit.part(id).name + "@" + std::to_string(millimetres),
         position(section.end()));
  }
}

/// The first name counts.
void Writer::name(std::size_t node, std::string id, Point2 at) {
  const auto [there, fresh] = nodes_.try_emplace(node);
  if (!fresh) return;
  while (!node_ids_.insert(id).second) id += '\'';
  there->second = {std::move(id), at, false};
}

/// The node at a position; between a section's ends a node is made, and the section becomes several edges.
std::size_t Writer::node_at(TrackPosition track_position) {
  const Section& section = zone_.circuit.section(track_position.section);
  if (track_position.s_m <= at_node_m) return ends_.node(Ends::start(track_position.section));
  if (section.length_m() - track_position.s_m <= at_node_m) return ends_.node(Ends::end(track_position.section));
  auto& cuts = cuts_[track_position.section];
  const auto near = cuts.lower_bound(track_position.s_m - at_node_m);
  if (near != cuts.end() && near->first <= track_position.s_m + at_node_m) return near->second;
  const std::size_t node = ends_.size() + nodes_.size();
  const auto millimetres = static_cast<long long>(std::floor(track_position.s_m * 1000.0 + 0.5));
  name(node, zone_.circuit.part(track_position.section).name + "@" + std::to_string(millimetres),
       position(section.pose_at(track_position.s_m)));
  cuts.emplace(track_position.s_m, node);
  return node;
}

void Writer::add_stations() {
  for (const zone::Station& station : zone_.stations) {
    const std::size_t node = node_at(station.position);
    station_nodes_.push_back(node);
    if (station.kind == StationKind::charger) nodes_.at(node).charges = true;
  }
}

/// Where two edges leave a node equally straight the first in the file is the default: this order keeps every section's
/// successors in the zone's order, wherever such an order exists, and is otherwise that of the zone.
std::vector<SectionId> Writer::edges_in_order() const {
  const auto size = static_cast<SectionId>(zone_.circuit.size());
  std::vector<std::vector<SectionId>> after(size);
  std::vector<std::size_t> waits_for(size);
  for (SectionId id = 0; id < size; ++id) {
    const auto next = zone_.circuit.next(id);
    for (std::size_t i = 1; i < next.size(); ++i) {
      if (next[i - 1] == next[i]) continue;
      after[next[i - 1]].push_back(next[i]);
      ++waits_for[next[i]];
    }
  }
  std::vector<bool> done(size);
  std::vector<SectionId> order;
  std::priority_queue<SectionId, std::vector<SectionId>, std::greater<>> ready;
  SectionId oldest = 0;
  for (SectionId id = 0; id < size; ++id) {
    if (waits_for[id] == 0) ready.push(id);
  }
  while (order.size() < size) {
    // Where they contradict one another, the oldest goes first.
    while (ready.empty()) {
      if (!done[oldest]) ready.push(oldest);
      ++oldest;
    }
    const SectionId id = ready.top();
    ready.pop();
    if (done[id]) continue;
    done[id] = true;
    order.push_back(id);
    for (const SectionId waiting : after[id]) {
      if (--waits_for[waiting] == 0) ready.push(waiting);
    }
  }
  return order;
}

void Writer::write_nodes() {
  json_.key("nodes").begin_array();
  for (const auto& [end, node] : nodes_) {
    json_.begin_object().field("nodeId", node.id).field("mapId", zone_.name);
    json_.key("nodePosition").begin_object().field("x", node.at.x_m).field("y", node.at.y_m).end_object();
    json_.key("vehicleTypeNodeProperties").begin_array().begin_object().field("vehicleTypeId", vehicle_type);
    if (node.charges) {
      json_.key("actions").begin_array();
      for (const std::string_view action : {"startCharging", "stopCharging"}) {
        json_.begin_object()
            .field("actionType", action)
            .field("requirementType", "CONDITIONAL")
            .field("blockingType", "HARD")
            .end_object();
      }
      json_.end_array();
    }
    json_.end_object().end_array().end_object();
  }
  json_.end_array();
}

/// Cut at the stations on it. The common name of its edges shows our reader that they are one section.
void Writer::write_section(SectionId id) {
  const Section& section = zone_.circuit.section(id);
  const std::size_t finish = ends_.node(Ends::end(id));
  std::size_t from = ends_.node(Ends::start(id));
  double from_m = 0.0;
  std::size_t number = 1;
  const auto cut = cuts_.find(id);
  if (cut == cuts_.end()) return write_edge(id, section, 0, from, finish);
  const auto piece = [&](double to_m, std::size_t to) {
    COSIVA_EXPECT(from_m < to_m);
    write_edge(id, part_of(section, from_m, to_m), number++, from, to);  // a millimetre is enough for a section
    from = to;
    from_m = to_m;
  };
  for (const auto& [s_m, node] : cut->second) piece(s_m, node);
  piece(section.length_m(), finish);
}

/// @param number  of the section's edges, from 1; 0: the only one
void Writer::write_edge(SectionId id, const Section& piece, std::size_t number, std::size_t from, std::size_t to) {
  const Circuit::Part& part = zone_.circuit.part(id);
  const bool last = to == ends_.node(Ends::end(id));
  std::string edge_id = part.name;
  if (number > 1) edge_id += "." + std::to_string(number);
  json_.begin_object().field("edgeId", edge_id);
  if (number > 0) json_.field("edgeName", part.name);
  json_.field("startNodeId", nodes_.at(from).id).field("endNodeId", nodes_.at(to).id);
  json_.key("vehicleTypeEdgeProperties").begin_array().begin_object();
  json_.field("vehicleTypeId", vehicle_type)
      .field("vehicleOrientation", 0.0)
      .field("orientationType", "TANGENTIAL")
      .field("rotationAllowed", false)
      .field("rotationAtEndNodeAllowed", last && part.pivots ? "BOTH" : "NONE");
  if (part.speed_mps_max) json_.field("maxSpeed", *part.speed_mps_max);
  if (piece.kind() != SectionKind::straight) write_trajectory(piece);
  json_.end_object().end_array().end_object();
}

void Writer::write_trajectory(const Section& section) {
  const Nurbs curve = nurbs_of(section);
  json_.key("trajectory").begin_object().field("degree", curve.degree).key("knotVector").begin_array();
  for (const double knot : curve.knots) json_.value(knot);
  json_.end_array().key("controlPoints").begin_array();
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    json_.begin_object()
        .field("x", curve.points[i].x_m)
        .field("y", curve.points[i].y_m)
        .field("weight", curve.weights[i])
        .end_object();
  }
  json_.end_array().end_object();
}

void Writer::write_stations() {
  json_.key("stations").begin_array();
  for (std::size_t i = 0; i < zone_.stations.size(); ++i) {
    json_.begin_object().field("stationId", zone_.stations[i].name);
    json_.key("interactionNodeIds").begin_array().value(nodes_.at(station_nodes_[i]).id).end_array().end_object();
  }
  json_.end_array();
}

void Writer::report_sidecar() {
  const std::pair<bool, const char*> rest[] = {
      {!zone_.tags.empty(), "tags"},
      {zone_.beacons.has_value(), "beacons"},
      {!zone_.loops.empty(), "loops"},
      {!zone_.priorities.empty(), "priorities"},
      {!zone_.starts.empty(), "starts"},
      {!zone_.closed.empty(), "closed sections"},
      {true, "the vehicle's measures and profiles"},
  };
  std::string names;
  for (const auto& [there, name] : rest) {
    if (!there) continue;
    if (!names.empty()) names += ", ";
    names += name;
  }
  lost_.push_back({Diagnostic::Kind::lost, "zone", "LIF cannot express " + names + "; the sidecar file can"});
  lost_.push_back(
      {Diagnostic::Kind::notice, "metaInformation.exportTimestamp", "is the same in every file written here"});
}

/// Reads the written file back, and reports where it differs from the zone.
void Writer::compare(const std::string& text) {
  const auto differs = [this](const std::string& section, std::string what) {
    lost_.push_back({Diagnostic::Kind::lost, "section '" + section + "'", std::move(what)});
  };
  const auto again = LifCircuitFactory{}.make_zone({"lif", zone_.name + ".lif.json", text, {}});
  if (!again) return differs("", "what was written cannot be read again: " + to_string(again.error()));
  const auto names = [](const Circuit& circuit, SectionId id) {
    std::string all;
    for (const SectionId after : circuit.next(id)) all += (all.empty() ? "" : ", ") + circuit.part(after).name;
    return all.empty() ? std::string("nothing") : all;
  };
  for (SectionId id = 0; id < zone_.circuit.size(); ++id) {
    const std::string& name = zone_.circuit.part(id).name;
    const auto found = again->circuit.find(name);
    if (!found) {
      differs(name, "is missing");
      continue;
    }
    const double shorter_m = zone_.circuit.section(id).length_m() - again->circuit.section(*found).length_m();
    if (std::fabs(shorter_m) > at_node_m) {
      differs(name, "becomes several sections when it is read again");
      continue;
    }
    const std::string now = names(again->circuit, *found);
    const std::string before = names(zone_.circuit, id);
    if (now == before) continue;
    std::string what = "is followed by ";
    differs(name, what.append(before).append(", which LIF can only express as ").append(now));
  }
}

}  // namespace

Result<ZoneConfiguration> write_zone(const TrafficZone& zone, std::vector<Diagnostic>& lost) {
  if (zone.circuit.size() > edges_max) {
    return fail(
        "zone.size",
        "expected at most " + std::to_string(edges_max) + " sections, found " + std::to_string(zone.circuit.size()),
        zone.name);
  }
  return Writer{zone, lost}.write();
}

}  // namespace cosiva::zone::lif
