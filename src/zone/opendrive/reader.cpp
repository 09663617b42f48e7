#include "cosiva/zone/opendrive/reader.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <set>

namespace cosiva::zone::opendrive {
namespace {

constexpr std::size_t lanes_max = 100;  // of one side

constexpr Range coordinate{"metres within ±100000000", -1e8, 1e8};
constexpr Range length{"a length from 0 to 100000 metres", 0.0, 1e5};
constexpr Range station{"metres along the road, 0 to 1000000", 0.0, 1e6};
constexpr Range heading{"a heading in radians within ±100000", -1e5, 1e5};
constexpr Range curvature{"a curvature per metre within ±10000", -1e4, 1e4};
constexpr Range coefficient{"a number within ±1e30", -1e30, 1e30};
constexpr Range speed{"a speed", -1e6, 1e6};

class Reader {
 public:
  Reader(XmlFile& file, Report& report) : file_{file}, report_{report} {}

  Result<Network> read();

 private:
  void read_header(pugi::xml_node header);
  [[nodiscard]] std::string id_of(pugi::xml_node node, std::set<std::string>& known);
  [[nodiscard]] Road read_road(pugi::xml_node node);
  [[nodiscard]] std::optional<RoadLink> read_link(pugi::xml_node node);
  [[nodiscard]] Geometry read_geometry(pugi::xml_node node, std::string location);
  [[nodiscard]] Cubics read_cubics(pugi::xml_node node);
  [[nodiscard]] Polynomial read_polynomial(pugi::xml_node node, const char* from);
  [[nodiscard]] SpeedFrom read_speed(pugi::xml_node node, double s);
  [[nodiscard]] LaneSection read_lane_section(pugi::xml_node node);
  [[nodiscard]] Lane read_lane(pugi::xml_node node, int sign);
  [[nodiscard]] Junction read_junction(pugi::xml_node node);
  [[nodiscard]] Connection read_connection(pugi::xml_node node, std::string location);
  void record(Diagnostic::Kind kind, std::string_view topic, pugi::xml_node node, std::string text);
  void count_what_is_not_taken(pugi::xml_node road);

  XmlFile& file_;
  Report& report_;
  std::set<std::string> road_ids_;
  std::set<std::string> junction_ids_;
};

Result<Network> Reader::read() {
  const pugi::xml_node root = file_.root();
  Network network;
  if (std::strcmp(root.name(), "OpenDRIVE") != 0) {
    std::string found = "expected the root element OpenDRIVE, found ";
    found += root ? std::string(root.name()).substr(0, 40) : "none";
    file_.fault(root, {}, "zone.format", std::move(found));
  }
  read_header(root.child("header"));
  network.name = root.child("header").attribute("name").value();
  for (const auto node : root.children("road")) {
    if (file_.error()) break;
    network.roads.push_back(read_road(node));
  }
  for (const auto node : root.children("junction")) {
    if (file_.error()) break;
    network.junctions.push_back(read_junction(node));
  }
  for (const char* name : {"controller", "station", "junctionGroup"}) {
    for ([[maybe_unused]] const auto node : root.children(name)) report_.count(name);
  }
  if (file_.error()) return tl::unexpected(*file_.error());
  if (network.roads.empty()) file_.fault(root, {}, "circuit.empty", "expected at least one road, found none");
  if (file_.error()) return tl::unexpected(*file_.error());
  return network;
}

/// The index of an element among its siblings costs a walk along them, so it is only computed for display.
void Reader::record(Diagnostic::Kind kind, std::string_view topic, pugi::xml_node node, std::string text) {
  report_.add(kind, topic, report_.full(topic) ? std::string{} : XmlFile::path(node), std::move(text));
}

void Reader::read_header(pugi::xml_node header) {
  if (const auto major = file_.whole(header, "revMajor"); major && *major != 1)
    file_.fault(header, "revMajor", "zone.version", "this program reads versions 1.1 to 1.8 of OpenDRIVE");
  if (header.child("geoReference"))
    report_.add(Diagnostic::Kind::notice, "geoReferences", "header/geoReference",
                "where on earth this lies is not taken: x and y are used as they are");
}

std::string Reader::id_of(pugi::xml_node node, std::set<std::string>& known) {
  std::string id;
  if (node.attribute("id") && *node.attribute("id").value() != '\0') {
    id = file_.id(node, "id");
  } else {
    id = "unnamed" + std::to_string(known.size() + 1);
    record(Diagnostic::Kind::mended, "elements without an id", node,
           "has no id; it is called '" + id + "' here, and nothing links to it");
  }
  if (!known.insert(id).second)
    file_.fault(node, "id", "zone.duplicate",
                "two elements \"" + std::string(node.name()) + "\" have the id '" + id + "'");
  return id;
}

Road Reader::read_road(pugi::xml_node node) {
  Road road;
  road.id = id_of(node, road_ids_);
  road.location = "road " + road.id;
  road.length = file_.number(node, "length", length, 0.0);
  road.left_hand = std::strcmp(node.attribute("rule").value(), "LHT") == 0;
  const std::string junction = node.attribute("junction").value();
  if (junction != "-1") road.junction = junction;
  road.predecessor = read_link(node.child("link").child("predecessor"));
  road.successor = read_link(node.child("link").child("successor"));
  for (const auto type : node.children("type"))
    road.speeds.push_back(read_speed(type.child("speed"), file_.number(type, "s", station, 0.0)));
  for (const auto geometry : node.child("planView").children("geometry")) {
    std::string location = road.location + ", planView/geometry[";
    location += std::to_string(road.plan.size() + 1) + ']';
    road.plan.push_back(read_geometry(geometry, std::move(location)));
  }
  const auto lanes = node.child("lanes");
  for (const auto offset : lanes.children("laneOffset")) road.offsets.push_back(read_polynomial(offset, "s"));
  for (const auto section : lanes.children("laneSection")) road.sections.push_back(read_lane_section(section));
  count_what_is_not_taken(node);
  return road;
}

std::optional<RoadLink> Reader::read_link(pugi::xml_node node) {
  if (!node) return std::nullopt;
  RoadLink link;
  link.id = file_.id(node, "elementId");
  link.junction = std::strcmp(node.attribute("elementType").value(), "junction") == 0;
  const std::string_view contact = node.attribute("contactPoint").value();
  link.at_start = contact == "start";
  if (link.junction || contact == "start" || contact == "end") return link;
  record(Diagnostic::Kind::mended, "links without a contact point", node,
         "does not state the end of the road; lanes are joined where their ends meet");
  return std::nullopt;
}

Geometry Reader::read_geometry(pugi::xml_node node, std::string location) {
  Geometry geometry;
  geometry.location = std::move(location);
  geometry.s = file_.number(node, "s", station);
  geometry.start = {file_.number(node, "x", coordinate), file_.number(node, "y", coordinate),
                    file_.number(node, "hdg", heading)};
  geometry.length = file_.number(node, "length", length);
  if (node.child("line")) {
    geometry.shape = Clothoid{};
  } else if (const auto arc = node.child("arc")) {
    const double bend = file_.number(arc, "curvature", curvature);
    geometry.shape = Clothoid{bend, bend};
  } else if (const auto spiral = node.child("spiral")) {
    geometry.shape = Clothoid{file_.number(spiral, "curvStart", curvature), file_.number(spiral, "curvEnd", curvature)};
  } else if (const auto cubic = node.child("poly3")) {
    geometry.shape = Cubics{{0.0, 0.0, 1.0, 0.0, 0.0}, read_polynomial(cubic, ""), Cubics::Range::along_u};
  } else if (const auto cubics = node.child("paramPoly3")) {
    geometry.shape = read_cubics(cubics);
  } else {
    file_.fault(node, {}, "zone.missing", "expected one of line, arc, spiral, poly3, paramPoly3, found none of them");
  }
  return geometry;
}

Cubics Reader::read_cubics(pugi::xml_node node) {
  const auto of = [&](const char* a, const char* b, const char* c, const char* d) {
    return Polynomial{0.0, file_.number(node, a, coefficient, 0.0), file_.number(node, b, coefficient, 0.0),
                      file_.number(node, c, coefficient, 0.0), file_.number(node, d, coefficient, 0.0)};
  };
  Cubics cubics{of("aU", "bU", "cU", "dU"), of("aV", "bV", "cV", "dV")};
  const std::string_view range = node.attribute("pRange").value();
  if (range == "arcLength") {
    cubics.range = Cubics::Range::arc_length;
  } else if (range.empty()) {
    record(Diagnostic::Kind::mended, "paramPoly3 without pRange", node,
           "has no pRange; taken as normalized, p from 0 to 1");
  } else if (range != "normalized") {
    file_.fault(node, "pRange", "zone.field", "expected \"arcLength\" or \"normalized\"");
  }
  return cubics;
}

/// @param from  the attribute with the start; none: at 0
Polynomial Reader::read_polynomial(pugi::xml_node node, const char* from) {
  return {*from == '\0' ? 0.0 : file_.number(node, from, station, 0.0), file_.number(node, "a", coefficient, 0.0),
          file_.number(node, "b", coefficient, 0.0), file_.number(node, "c", coefficient, 0.0),
          file_.number(node, "d", coefficient, 0.0)};
}

SpeedFrom Reader::read_speed(pugi::xml_node node, double s) {
  SpeedFrom from{s};
  const std::string_view published = node.attribute("max").value();
  if (published.empty() || published == "no limit" || published == "undefined") return from;
  const std::string_view unit = node.attribute("unit").value();
  const double factor = unit == "km/h" ? 1.0 / 3.6 : unit == "mph" ? 0.44704 : 1.0;
  const double mps = factor * file_.number(node, "max", speed);
  if (mps > 0.0)
    from.mps = mps;
  else
    record(Diagnostic::Kind::mended, "speed limits that are not positive", node, "is no limit, and none is set");
  return from;
}

LaneSection Reader::read_lane_section(pugi::xml_node node) {
  LaneSection section;
  section.s = file_.number(node, "s", station);
  for (const char* name : {"left", "right"}) {
    for (const auto lane : node.child(name).children("lane")) {
      if (section.left.size() == lanes_max || section.right.size() == lanes_max)
        file_.fault(lane, {}, "zone.size", "expected at most " + std::to_string(lanes_max) + " lanes on one side");
      if (file_.error()) return section;
      Lane read = read_lane(lane, *name == 'l' ? 1 : -1);
      if (read.id != 0) (read.id > 0 ? section.left : section.right).push_back(std::move(read));
    }
  }
  for (auto* side : {&section.left, &section.right}) {
    const auto further_in = [](const Lane& a, const Lane& b) { return std::abs(a.id) < std::abs(b.id); };
    std::stable_sort(side->begin(), side->end(), further_in);
    for (std::size_t i = 1; i < side->size(); ++i) {
      if ((*side)[i].id == (*side)[i - 1].id)
        file_.fault(node, {}, "zone.duplicate",
                    "two lanes of this section have the id " + std::to_string((*side)[i].id));
    }
  }
  return section;
}

/// @param sign  of the ids on this side; another sign is accepted, with a diagnostic
Lane Reader::read_lane(pugi::xml_node node, int sign) {
  Lane lane;
  const auto id = file_.whole(node, "id");
  if (!id) file_.fault(node, "id", "zone.missing", "expected a lane's id, found nothing");
  lane.id = id.value_or(sign);
  if (lane.id * sign <= 0)
    record(lane.id == 0 ? Diagnostic::Kind::lost : Diagnostic::Kind::mended, "lanes on the wrong side", node,
           lane.id == 0 ? "is the centre line, which has no width and belongs under center; not taken"
                        : std::string("lies ") + (sign > 0 ? "right" : "left") +
                              " of the reference line by its id, although it is listed under the other side");
  lane.type = std::string(std::string_view(node.attribute("type").value()).substr(0, 40));
  if (lane.type.empty()) lane.type = "none";
  const std::string_view direction = node.attribute("direction").value();
  lane.reversed = direction == "reversed";
  if (direction == "both") report_.count("direction both");
  for (const auto link : node.child("link").children("predecessor"))
    if (const auto to = file_.whole(link, "id")) lane.predecessors.push_back(*to);
  for (const auto link : node.child("link").children("successor"))
    if (const auto to = file_.whole(link, "id")) lane.successors.push_back(*to);
  for (const auto width : node.children("width")) lane.widths.push_back(read_polynomial(width, "sOffset"));
  for (const auto border : node.children("border")) lane.borders.push_back(read_polynomial(border, "sOffset"));
  for (const auto limit : node.children("speed"))
    lane.speeds.push_back(read_speed(limit, file_.number(limit, "sOffset", station, 0.0)));
  return lane;
}

Junction Reader::read_junction(pugi::xml_node node) {
  Junction junction;
  junction.id = id_of(node, junction_ids_);
  if (std::strcmp(node.attribute("type").value(), "virtual") == 0)
    record(Diagnostic::Kind::lost, "virtual junctions", node,
           "is a virtual junction: branches between the ends of a road are not taken");
  for (const auto connection : node.children("connection")) {
    if (file_.error()) break;
    std::string location = "junction " + junction.id;
    location += ", connection[" + std::to_string(junction.connections.size() + 1) + ']';
    junction.connections.push_back(read_connection(connection, std::move(location)));
  }
  return junction;
}

Connection Reader::read_connection(pugi::xml_node node, std::string location) {
  Connection connection;
  connection.location = std::move(location);
  // A direct junction (1.7) links roads without a connecting one between them.
  const char* to = node.attribute("connectingRoad") ? "connectingRoad" : "linkedRoad";
  if (node.attribute("incomingRoad")) connection.incoming = file_.id(node, "incomingRoad");
  if (node.attribute(to)) connection.connecting = file_.id(node, to);
  const std::string_view contact = node.attribute("contactPoint").value();
  connection.at_start = contact != "end";
  if (contact != "end" && contact != "start" && !contact.empty())
    file_.fault(node, "contactPoint", "zone.field", "expected \"start\" or \"end\"");
  for (const auto link : node.children("laneLink")) {
    const auto from = file_.whole(link, "from");
    const auto onto = file_.whole(link, "to");
    if (from && onto) connection.lanes.emplace_back(*from, *onto);
  }
  return connection;
}

void Reader::count_what_is_not_taken(pugi::xml_node road) {
  const auto differs = [](pugi::xml_node record) {
    for (const char* name : {"a", "b", "c", "d"}) {
      if (record.attribute(name).as_double() != 0.0) return true;
    }
    return false;
  };
  for (const auto record : road.child("elevationProfile").children("elevation"))
    if (differs(record)) report_.count("elevation");
  for (const char* name : {"superelevation", "crossfall", "shape"}) {
    for (const auto record : road.child("lateralProfile").children(name))
      if (differs(record)) report_.count(name);
  }
  for (const auto node : road.child("signals").children("signal")) {
    (void)node;
    report_.count("signals");
  }
  for (const auto node : road.child("objects").children()) {
    if (node.type() == pugi::node_element) report_.count("objects");
  }
  if (road.child("railroad")) report_.count("railroad");
}

}  // namespace

Result<Network> read_network(XmlFile& file, Report& report) { return Reader{file, report}.read(); }

}  // namespace cosiva::zone::opendrive
