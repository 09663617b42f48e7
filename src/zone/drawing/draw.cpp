#include "cosiva/zone/drawing/draw.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

constexpr double sagitta_min_m = 0.0005;
// A drawing with more of these is a grey haze that takes a browser seconds; all of them stay in the zone.
constexpr std::uint64_t beacons_drawn_max = 10'000;
constexpr std::size_t names_drawn_max = 3'000;
constexpr double points_drawn_max = 300'000.0;

/// Sizes in a drawing follow the vehicle, so that a yard of lorries and a table of toys look alike.
struct Sizes {
  explicit Sizes(const VehicleShape& vehicle)
      : road_m{vehicle.width_m * 1.5},
        line_m{vehicle.width_m / 12.0},
        tag_m{vehicle.width_m / 6.0},
        beacon_m{vehicle.width_m / 12.0},
        pivot_m{vehicle.width_m * 0.2},
        station_m{vehicle.width_m * 0.3},
        arrow_m{vehicle.width_m * 0.35},
        text_m{vehicle.width_m * 0.45} {}
  double road_m, line_m, tag_m, beacon_m, pivot_m, station_m, arrow_m, text_m;
};

/// Parts of a section whose chords stray at most `sagitta_m` from it.
double parts_of(const Section& section, double sagitta_m) {
  const double bend = section.curvature_max_per_m();
  if (bend <= 0.0) return 1.0;
  // Chord of length c on radius R strays c²/(8R); beyond half a turn the formula's chord would span the circle.
  const double chord_m = std::min(std::sqrt(8.0 * sagitta_m / bend), 0.5 / bend);
  return std::max(1.0, std::ceil(section.length_m() / chord_m));
}

/// As fine as is visible, but coarser where that would give too many points in all.
double sagitta_of(const Circuit& circuit) {
  double points = 0.0;
  for (SectionId id = 0; id < circuit.size(); ++id) points += parts_of(circuit.section(id), sagitta_min_m) + 1.0;
  const double over = std::max(points / points_drawn_max, 1.0);
  return sagitta_min_m * over * over;
}

std::vector<Point2> trace(const Section& section, double sagitta_m) {
  const double parts = parts_of(section, sagitta_m);
  std::vector<Point2> points;
  for (double i = 0.0; i <= parts; i += 1.0)
    points.push_back(position(section.pose_at(section.length_m() * (i / parts))));
  return points;
}

std::string kind_name(StationKind kind) { return kind == StationKind::charger ? "charger" : "stop"; }

/// A shape given in a body frame, transformed to the map.
std::vector<Point2> placed(const Pose2& X_MB, std::initializer_list<Point2> points_B) {
  std::vector<Point2> points;
  for (const Point2& p_B : points_B) points.push_back(X_MB * p_B);
  return points;
}

/// Draws layer after layer. Invariant: every shape has a point.
class Painter {
 public:
  explicit Painter(const TrafficZone& zone) : zone_{zone}, sizes_{zone.vehicle} {}

  std::vector<Primitive> paint() {
    draw_sections();
    crossings();
    pivots();
    beacons();
    tags();
    stations();
    section_names();
    crossing_names();
    return std::move(out_);
  }

 private:
  using Shape = Primitive::Shape;

  void add(Shape shape, std::string layer, std::vector<Point2> points, double size_m, std::string label = {},
           double heading_rad = 0.0, std::string kind = {}) {
    COSIVA_EXPECT(!points.empty());
    out_.push_back(
        {shape, std::move(layer), std::move(points), size_m, std::move(label), heading_rad, std::move(kind)});
  }

  void draw_sections() {
    std::vector<std::vector<Point2>> traces;
    const double sagitta_m = sagitta_of(zone_.circuit);
    for (SectionId id = 0; id < zone_.circuit.size(); ++id)
      traces.push_back(trace(zone_.circuit.section(id), sagitta_m));
    // All bands under all centre lines, so that no road covers another's centre line.
    for (SectionId id = 0; id < traces.size(); ++id)
      add(Shape::polyline, "road", traces[id], sizes_.road_m, zone_.circuit.part(id).name);
    for (SectionId id = 0; id < traces.size(); ++id) {
      add(Shape::polyline, "line", std::move(traces[id]), sizes_.line_m, {}, 0.0,
          std::string(kind_name(zone_.circuit.section(id))));
    }
  }

  /// Once at each position, however many sections end there.
  void pivots() {
    std::set<std::pair<double, double>> drawn;
    for (SectionId id = 0; id < zone_.circuit.size(); ++id) {
      const auto next = zone_.circuit.next(id);
      const bool turns = std::any_of(next.begin(), next.end(),
                                     [&](SectionId after) { return zone_.circuit.turn_at(id, after) != 0.0; });
      const Point2 end = position(zone_.circuit.section(id).end());
      if (!turns || !drawn.emplace(std::nearbyint(end.x_m * 1e3), std::nearbyint(end.y_m * 1e3)).second) continue;
      add(Shape::disc, "pivot", {end}, sizes_.pivot_m, "turn on the spot");
    }
  }

  void crossings() {
    for (const Crossing& crossing : zone_.crossings) {
      // A box across the roads, turned like the first section through it.
      const CrossingSpan& span = crossing.spans.front();
      Pose2 X_MC = zone_.circuit.pose_at({span.section, 0.5 * (span.from_m + span.to_m)});
      X_MC.x_m = crossing.centre.x_m;
      X_MC.y_m = crossing.centre.y_m;
      const double half_m = 0.5 * sizes_.road_m;
      add(Shape::polygon, "crossing",
          placed(X_MC, {{-half_m, -half_m}, {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}}), 0.0,
          crossing.name);
    }
  }

  void beacons() {
    if (!zone_.beacons) return;
    const BeaconGrid& grid = *zone_.beacons;
    if (std::uint64_t{grid.columns} * grid.rows > beacons_drawn_max) return;
    for (std::uint32_t row = 0; row < grid.rows; ++row) {
      for (std::uint32_t column = 0; column < grid.columns; ++column) {
        add(Shape::disc, "beacon", {grid.at(column, row)}, sizes_.beacon_m,
            "beacon " + std::to_string(grid.first_number + row * grid.columns + column));
      }
    }
  }

  void tags() {
    for (const Tag& tag : zone_.tags)
      add(Shape::disc, "tag", {position(zone_.circuit.pose_at(tag.position))}, sizes_.tag_m,
          "tag " + std::to_string(tag.number));
  }

  void stations() {
    for (const Station& station : zone_.stations) {
      const Pose2 X_MP = zone_.circuit.pose_at(station.position);
      const double h = sizes_.station_m;
      // A charger is drawn on its corner.
      const double r = 1.4 * h;
      auto outline = station.kind == StationKind::charger ? placed(X_MP, {{r, 0.0}, {0.0, r}, {-r, 0.0}, {0.0, -r}})
                                                          : placed(X_MP, {{-h, -h}, {h, -h}, {h, h}, {-h, h}});
      add(Shape::polygon, "station", std::move(outline), 0.0, station.name, 0.0, kind_name(station.kind));
      if (zone_.stations.size() <= names_drawn_max)
        add(Shape::text, "label", {X_MP * Point2{0.0, sizes_.road_m}}, sizes_.text_m, station.name);
    }
  }

  void section_names() {
    if (zone_.circuit.size() > names_drawn_max) return;
    for (SectionId id = 0; id < zone_.circuit.size(); ++id) {
      const Section& section = zone_.circuit.section(id);
      // An arrow needs room; short pieces are followed by others that have it.
      const double arrow_m = sizes_.arrow_m;
      if (section.length_m() < 6.0 * arrow_m) continue;
      // A quarter of the section: its centre is where crossings and tags often lie.
      const Pose2 X_MP = section.pose_at(0.25 * section.length_m());
      add(Shape::polygon, "section",
          placed(X_MP, {{arrow_m, 0.0},
                        {-0.6 * arrow_m, 0.6 * arrow_m},
                        {-0.2 * arrow_m, 0.0},
                        {-0.6 * arrow_m, -0.6 * arrow_m}}),
          0.0, {}, X_MP.heading_rad);
      // Names are inside the bend, where the road leaves room; on a straight at its right.
      const double side = section.curvature_at(0.0) > 0.0 ? 1.0 : -1.0;
      const double beside_m = 0.5 * sizes_.road_m + 1.6 * sizes_.text_m;
      const Pose2 X_MT = section.pose_at(0.125 * section.length_m());
      add(Shape::text, "section", {X_MT * Point2{0.0, side * beside_m}}, sizes_.text_m, zone_.circuit.part(id).name);
    }
  }

  void crossing_names() {
    if (zone_.crossings.size() > names_drawn_max) return;
    for (const Crossing& crossing : zone_.crossings) {
      // In a corner of the box, clear of the lines.
      const double corner_m = 0.28 * sizes_.road_m;
      const Point2 at{crossing.centre.x_m + corner_m, crossing.centre.y_m + corner_m};
      add(Shape::text, "label", {at}, sizes_.text_m, crossing.name);
    }
  }

  const TrafficZone& zone_;
  Sizes sizes_;
  std::vector<Primitive> out_;
};

std::string_view shape_name(Primitive::Shape shape) {
  switch (shape) {
    case Primitive::Shape::polyline: return "polyline";
    case Primitive::Shape::polygon: return "polygon";
    case Primitive::Shape::disc: return "disc";
    case Primitive::Shape::text: return "text";
  }
  return "unknown";
}

/// The data that the page edits and names, next to the drawing, which it need not interpret.
void write_metadata(JsonWriter& json, const TrafficZone& zone) {
  json.key("sections").begin_array();
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    const Circuit::Part& part = zone.circuit.part(id);
    json.begin_object().field("name", part.name).field("length_m", part.section.length_m()).end_object();
  }
  json.end_array().key("tags").begin_array();
  for (const Tag& tag : zone.tags) {
    const Pose2 pose = zone.circuit.pose_at(tag.position);
    json.begin_object().field("number", tag.number).field("section", zone.circuit.part(tag.position.section).name);
    json.field("s", tag.position.s_m).field("x", pose.x_m).field("y", pose.y_m).end_object();
  }
  json.end_array().key("beacons");
  if (!zone.beacons) {
    json.null();
    return;
  }
  const BeaconGrid& grid = *zone.beacons;
  json.begin_object().field("pitch_m", grid.pitch_m).key("origin").begin_array();
  json.value(grid.origin.x_m).value(grid.origin.y_m).end_array().field("rotation", grid.rotation_rad);
  json.field("columns", grid.columns).field("rows", grid.rows).end_object();
}

/// The destinations of vehicles, and the reader's diagnostics.
void write_goals(JsonWriter& json, const TrafficZone& zone) {
  json.key("stations").begin_array();
  for (const Station& station : zone.stations) {
    const Pose2 pose = zone.circuit.pose_at(station.position);
    json.begin_object().field("name", station.name).field("kind", kind_name(station.kind));
    json.field("x", pose.x_m).field("y", pose.y_m);
    json.field("section", zone.circuit.part(station.position.section).name)
        .field("s", station.position.s_m)
        .end_object();
  }
  json.end_array().key("loops").begin_array();
  for (const Loop& loop : zone.loops) json.value(loop.name);
  json.end_array().key("diagnostics").begin_array();
  for (const Diagnostic& diagnostic : zone.diagnostics) {
    json.begin_object().field("kind", to_string(diagnostic.kind)).field("location", diagnostic.location);
    json.field("text", diagnostic.text).end_object();
  }
  json.end_array();
}

/// To 0.01 mm, the resolution that a drawing needs.
void write_point(JsonWriter& json, Point2 p) {
  const auto rounded = [](double value_m) { return std::nearbyint(value_m * 1e5) / 1e5; };
  json.begin_array().value(rounded(p.x_m)).value(rounded(p.y_m)).end_array();
}

}  // namespace

std::vector<Primitive> draw(const TrafficZone& zone) { return Painter{zone}.paint(); }

Bounds bounds(const std::vector<Primitive>& primitives) {
  Bounds all;
  bool first = true;
  for (const Primitive& primitive : primitives) {
    // A stroke reaches half its width, a disc its radius; text does not widen a drawing.
    double reach_m = 0.0;
    if (primitive.shape == Primitive::Shape::polyline) reach_m = 0.5 * primitive.size_m;
    if (primitive.shape == Primitive::Shape::disc) reach_m = primitive.size_m;
    for (const Point2& p : primitive.points) {
      const Point2 low{p.x_m - reach_m, p.y_m - reach_m};
      const Point2 high{p.x_m + reach_m, p.y_m + reach_m};
      all.low = first ? low : Point2{std::min(all.low.x_m, low.x_m), std::min(all.low.y_m, low.y_m)};
      all.high = first ? high : Point2{std::max(all.high.x_m, high.x_m), std::max(all.high.y_m, high.y_m)};
      first = false;
    }
  }
  return all;
}

void write_json(JsonWriter& json, const TrafficZone& zone, const std::vector<Primitive>& primitives) {
  const Bounds box = bounds(primitives);
  json.begin_object().field("name", zone.name);
  json.key("bounds").begin_array();
  json.value(box.low.x_m).value(box.low.y_m).value(box.high.x_m).value(box.high.y_m).end_array();
  json.key("vehicle").begin_object();
  json.field("length_m", zone.vehicle.length_m).field("width_m", zone.vehicle.width_m).end_object();
  json.key("primitives").begin_array();
  for (const Primitive& primitive : primitives) {
    json.begin_object().field("shape", shape_name(primitive.shape)).field("layer", primitive.layer);
    if (!primitive.kind.empty()) json.field("kind", primitive.kind);
    json.key("points").begin_array();
    for (const Point2& p : primitive.points) write_point(json, p);
    json.end_array();
    json.field("size_m", primitive.size_m).field("label", primitive.label);
    json.field("heading", primitive.heading_rad).end_object();
  }
  json.end_array();
  write_metadata(json, zone);
  write_goals(json, zone);
  json.end_object();
}

}  // namespace cosiva::zone
