#include "cosiva/zone/lif/lif_circuit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>

#include "cosiva/zone/lif/lif_tracks.h"

namespace cosiva::zone::lif {
namespace {

constexpr auto mended = Diagnostic::Kind::mended;
constexpr auto lost = Diagnostic::Kind::lost;

/// Nodes this close are one point: no vehicle is positioned more accurately.
constexpr double same_point_m = 1e-3;
/// A kink that a vehicle drives over where its node forbids to turn: files have their coordinates rounded to
/// centimetres.
constexpr double straight_on_rad = 0.1;
constexpr double turns_back_rad = 0.75 * pi;
constexpr std::size_t sections_max = 100'000;
constexpr std::size_t joints_max = 1'000'000;
constexpr double length_max_m = 1e5;
constexpr double turned_max_rad = 1e5;

class Maker {
 public:
  Maker(const Document& document, FitTolerance tolerance, LifDiagnostics& diagnostics)
      : document_{document}, diagnostics_{diagnostics}, track_maker_{tolerance, diagnostics} {}
  Result<Tracks> make();

 private:
  void merge_nodes();
  [[nodiscard]] bool is_lift(const Edge& edge) const;
  void find_pieces();
  void lay(const Edge& edge);
  [[nodiscard]] Track rejoined(Track track, const Edge& edge);
  [[nodiscard]] std::string unused(std::string name);
  [[nodiscard]] bool is_reached(std::size_t point) const {
    return !arriving_[point].empty() || !leaving_[point].empty() || impl_.contains(point);
  }
  void join();
  void join_end(std::size_t laid);
  void add_stations();
  void add_station(const std::string& name, std::size_t node, bool charges);
  void add_lonely_chargers(const std::set<std::size_t>& served);

  /// An edge that has become sections.
  struct Laid {
    const Edge* edge;    ///< its first edge
    const Edge* finish;  ///< its last edge: the same, except where pieces form one section again
    SectionId first;
    SectionId last;
  };

  const Document& document_;
  LifDiagnostics& diagnostics_;
  TrackMaker track_maker_;
  std::optional<Error> error_;
  std::vector<std::size_t> point_;  ///< by node: the node whose point it has, itself where it is the first there
  std::vector<Laid> laid_;
  std::vector<std::vector<std::size_t>> leaving_;   ///< by point: indices into laid_
  std::vector<std::vector<std::size_t>> arriving_;  ///< likewise
  std::map<const Edge*, const Edge*> piece_after_;  ///< of a section that our writer has cut at stations
  std::set<const Edge*> rejoined_;
  std::map<std::size_t, TrackPosition> impl_;  ///< by point: where it lies within such a section
  std::set<std::string, std::less<>> names_;
  double length_m_{0.0};
  double turned_rad_{0.0};
  Tracks tracks_;
  std::set<std::string> station_names_;
};

Result<Tracks> Maker::make() {
  merge_nodes();
  for (const Edge& edge : document_.edges) names_.insert(edge.id);
  find_pieces();
  for (const Edge& edge : document_.edges) {
    if (!rejoined_.contains(&edge)) lay(edge);
    if (error_) return tl::unexpected(*error_);
  }
  if (tracks_.parts.empty()) return fail("circuit.empty", "no edge is left that a vehicle could drive on", "layouts");
  join();
  if (error_) return tl::unexpected(*error_);
  add_stations();
  track_maker_.record_worst();
  return std::move(tracks_);
}

/// Nodes at one point of one level are one: 10.9 and 10.16 of the standard's examples have several, one for each
/// action.
void Maker::merge_nodes() {
  std::map<std::string, std::size_t, std::less<>> levels;
  const auto level_of = [&](const Node& node) {
    const Layout& layout = document_.layouts[node.layout];
    std::string key = layout.level ? "=" + *layout.level : std::to_string(node.layout);
    return levels.emplace(std::move(key), levels.size()).first->second;
  };
  std::map<std::tuple<std::size_t, std::int64_t, std::int64_t>, std::vector<std::size_t>> cells;
  point_.resize(document_.nodes.size());
  for (std::size_t i = 0; i < document_.nodes.size(); ++i) {
    const Node& node = document_.nodes[i];
    const std::size_t level = level_of(node);
    const auto x = static_cast<std::int64_t>(std::floor(node.at.x_m / same_point_m));
    const auto y = static_cast<std::int64_t>(std::floor(node.at.y_m / same_point_m));
    point_[i] = i;
    for (std::int64_t cell = 0; cell < 9 && point_[i] == i; ++cell) {
      const auto found = cells.find({level, x + cell % 3 - 1, y + cell / 3 - 1});
      if (found == cells.end()) continue;
      for (const std::size_t other : found->second) {
        if (distance(document_.nodes[other].at, node.at) <= same_point_m) point_[i] = other;
      }
    }
    if (point_[i] == i) {
      cells[{level, x, y}].push_back(i);
    } else {
      diagnostics_.add(Diagnostic::Kind::notice, node.location,
                       "node '" + node.id + "' lies where '" + document_.nodes[point_[i]].id +
                           "' lies; they are one point with several ids",
                       "merged nodes");
    }
  }
  leaving_.resize(document_.nodes.size());
  arriving_.resize(document_.nodes.size());
}

bool Maker::is_lift(const Edge& edge) const {
  const auto& from = document_.layouts[document_.nodes[edge.from].layout].level;
  const auto& to = document_.layouts[document_.nodes[edge.to].layout].level;
  return from && to && *from != *to;
}

/// Edges X, X.2, X.3 … that all name X as their section, each from the end of the one before it, where no other edge
/// leads.
void Maker::find_pieces() {
  std::map<std::string_view, const Edge*> by_id;
  std::vector<std::size_t> ends(document_.nodes.size());  // by point
  for (const Edge& edge : document_.edges) {
    ++ends[point_[edge.from]];
    ++ends[point_[edge.to]];
    if (!edge.section.empty()) by_id.emplace(edge.id, &edge);
  }
  for (const Edge& edge : document_.edges) {
    if (edge.section != edge.id || edge.section.empty()) continue;
    const Edge* before = &edge;
    for (std::size_t number = 2;; ++number) {
      const auto found = by_id.find(edge.section + "." + std::to_string(number));
      if (found == by_id.end() || found->second->section != edge.section) break;
      const std::size_t point = point_[before->to];
      // In the order of the file, so that the first is laid first.
      if (found->second < before || point_[found->second->from] != point || ends[point] != 2) break;
      piece_after_[before] = found->second;
      before = found->second;
    }
  }
}

/// The section that an edge and the pieces after it form; the edge's own geometry where they form none.
Track Maker::rejoined(Track track, const Edge& edge) {
  std::vector<const Edge*> pieces;
  std::vector<double> ends_m;
  std::vector<Section> sections;
  const auto append = [&](const Edge& piece, const Track& part) {
    if (part.sections.size() != 1) return false;
    pieces.push_back(&piece);
    sections.push_back(part.sections.front());
    ends_m.push_back((ends_m.empty() ? 0.0 : ends_m.back()) + sections.back().length_m());
    return true;
  };
  bool whole = append(edge, track);
  for (auto after = piece_after_.find(&edge); whole && after != piece_after_.end();
       after = piece_after_.find(after->second)) {
    const Edge& piece = *after->second;
    whole = append(
        piece, track_maker_.make(piece, document_.nodes[point_[piece.from]].at, document_.nodes[point_[piece.to]].at));
  }
  auto section = whole ? track_maker_.as_one(sections) : std::nullopt;
  if (!section) return track;
  const auto id = static_cast<SectionId>(tracks_.parts.size());
  for (std::size_t i = 0; i + 1 < pieces.size(); ++i) {
    impl_[point_[pieces[i]->to]] = {id, ends_m[i] * section->length_m() / ends_m.back()};
    rejoined_.insert(pieces[i + 1]);
  }
  track.sections = {std::move(*section)};
  return track;
}

std::string Maker::unused(std::string name) {
  while (!names_.insert(name).second) name += '\'';
  return name;
}

void Maker::lay(const Edge& edge) {
  if (is_lift(edge)) {
    diagnostics_.add(lost, edge.location, "edge '" + edge.id + "' leads to another level; lifts are not taken", "lift");
    return;
  }
  const std::size_t from = point_[edge.from];
  const std::size_t to = point_[edge.to];
  Track track = track_maker_.make(edge, document_.nodes[from].at, document_.nodes[to].at);
  if (track.sections.empty()) {
    if (from == to || distance(document_.nodes[from].at, document_.nodes[to].at) < same_point_m) {
      diagnostics_.add(mended, edge.location,
                       "edge '" + edge.id + "' has no length: its nodes are one point, where vehicles turn on the spot",
                       "edge without length");
    }
    return;
  }
  const Edge* finish = &edge;
  if (piece_after_.contains(&edge)) {
    track = rejoined(std::move(track), edge);
    for (auto after = piece_after_.find(finish); after != piece_after_.end() && rejoined_.contains(after->second);
         after = piece_after_.find(finish))
      finish = after->second;
  }
  const auto first = static_cast<SectionId>(tracks_.parts.size());
  for (std::size_t i = 0; i < track.sections.size(); ++i) {
    length_m_ += track.sections[i].length_m();
    turned_rad_ += track.sections[i].length_m() * track.sections[i].curvature_max_per_m();
    std::string name = i == 0 ? edge.id : unused(edge.id + "." + std::to_string(i + 1));
    Circuit::Part part{std::move(name), std::move(track.sections[i]), edge.speed_mps_max, {}, track.corner[i]};
    if (i + 1 < track.sections.size()) part.next = {static_cast<SectionId>(tracks_.parts.size() + 1)};
    tracks_.parts.push_back(std::move(part));
    tracks_.start_ids.push_back(i == 0 ? document_.nodes[edge.from].id : std::string{});
    tracks_.end_ids.push_back(i + 1 == track.sections.size() ? document_.nodes[finish->to].id : std::string{});
  }
  if (tracks_.parts.size() > sections_max || length_m_ > length_max_m || turned_rad_ > turned_max_rad) {
    error_ = Error{"zone.size",
                   "a zone may have 100000 sections, be 100 km long and turn 100000 rad in all; the edges up to here "
                   "exceed it. [import] scale or layout may help",
                   edge.location};
    return;
  }
  leaving_[from].push_back(laid_.size());
  arriving_[point_[finish->to]].push_back(laid_.size());
  laid_.push_back({&edge, finish, first, static_cast<SectionId>(tracks_.parts.size() - 1)});
}

void Maker::join() {
  // Checked before any is made: at a node where thousands meet they are millions.
  std::size_t joints = 0;
  for (const Laid& laid : laid_) {
    joints += leaving_[point_[laid.finish->to]].size();
    if (joints <= joints_max) continue;
    error_ = Error{"zone.size", "expected at most 1000000 joints between edges, found more", laid.finish->location};
    return;
  }
  for (std::size_t i = 0; i < laid_.size(); ++i) join_end(i);
}

void Maker::join_end(std::size_t index) {
  const Laid& laid = laid_[index];
  const auto& leaving = leaving_[point_[laid.finish->to]];
  Circuit::Part& part = tracks_.parts[laid.last];
  struct Choice {
    bool back;
    double turn_rad;
    std::size_t index;  // into laid_
    bool allowed;
  };
  std::vector<Choice> choices;
  bool any_allowed = false;
  for (const std::size_t after : leaving) {
    const Laid& next = laid_[after];
    double turn_rad =
        std::fabs(wrap_angle(tracks_.parts[next.first].section.start().heading_rad - part.section.end().heading_rad));
    if (turn_rad <= Circuit::smooth_rad) turn_rad = 0.0;
    const bool back = turn_rad > turns_back_rad && point_[next.finish->to] == point_[laid.edge->from];
    const bool turns = laid.finish->arriving != Rotation::none && next.edge->leaving != Rotation::none;
    choices.push_back({back, turn_rad, after, turns || turn_rad <= straight_on_rad});
    any_allowed = any_allowed || choices.back().allowed;
  }
  if (!any_allowed && !choices.empty()) {
    diagnostics_.add(mended, laid.edge->location,
                     "no path leads on from edge '" + laid.edge->id +
                         "' without a turn, which its node forbids; vehicles turn there all the same",
                     "forbidden turn");
  }
  std::sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
    return std::tie(a.back, a.turn_rad, a.index) < std::tie(b.back, b.turn_rad, b.index);
  });
  part.pivots = laid.finish->arriving != Rotation::none;
  for (const Choice& choice : choices) {
    if (any_allowed && !choice.allowed) continue;
    part.next.push_back(laid_[choice.index].first);
    part.pivots = part.pivots || choice.turn_rad > 0.0;
  }
}

void Maker::add_stations() {
  std::set<std::size_t> served;
  for (const Station& station : document_.stations) {
    std::string name = station.name;
    if (station_names_.contains(name)) {
      diagnostics_.add(mended, station.location, "another station is called '" + name + "'; identified by its id",
                       "station names");
      name = station.id;
    }
    std::set<std::size_t> points;
    for (const std::size_t node : station.nodes) {
      const std::size_t point = point_[node];
      if (!is_reached(point)) continue;
      if (!points.insert(point).second) continue;
      const bool charges = std::any_of(station.nodes.begin(), station.nodes.end(), [&](std::size_t other) {
        return point_[other] == point && document_.nodes[other].charges;
      });
      if (points.size() == 2) {
        diagnostics_.add(
            Diagnostic::Kind::notice, station.location,
            "station '" + name + "' has several interaction nodes; the further ones are numbered: .2, .3 …",
            "several interaction nodes");
      }
      add_station(points.size() == 1 ? name : name + "." + std::to_string(points.size()), node,
                  charges || station.charges);
      served.insert(point);
    }
    if (points.empty()) {
      diagnostics_.add(lost, station.location,
                       "no edge leads to an interaction node of station '" + name + "'; not taken",
                       "station without edge");
    }
  }
  add_lonely_chargers(served);
}

/// Chargers must be reachable as destinations.
void Maker::add_lonely_chargers(const std::set<std::size_t>& served) {
  for (std::size_t i = 0; i < document_.nodes.size(); ++i) {
    const Node& node = document_.nodes[i];
    const std::size_t point = point_[i];
    if (!node.charges || served.contains(point) || !is_reached(point)) continue;
    diagnostics_.add(mended, node.location,
                     "node '" + node.id + "' offers startCharging but no station; it is a charger of that name",
                     "lonely charger");
    add_station(node.id, i, true);
  }
}

/// At the end of the first section to the node itself, else to its point, else where the first section from there
/// begins.
void Maker::add_station(const std::string& name, std::size_t node, bool charges) {
  std::string unique = name;
  while (!station_names_.insert(unique).second) unique += '\'';
  const auto& arriving = arriving_[point_[node]];
  TrackPosition position{};
  if (const auto inside = impl_.find(point_[node]); inside != impl_.end()) {
    position = inside->second;
  } else if (!arriving.empty()) {
    auto chosen = std::find_if(arriving.begin(), arriving.end(),
                               [&](std::size_t laid) { return laid_[laid].finish->to == node; });
    if (chosen == arriving.end()) chosen = arriving.begin();
    const SectionId section = laid_[*chosen].last;
    position = {section, tracks_.parts[section].section.length_m()};
  } else {
    position = {laid_[leaving_[point_[node]].front()].first, 0.0};
  }
  tracks_.stations.push_back({std::move(unique), position, charges ? StationKind::charger : StationKind::stop});
}

}  // namespace

Result<Tracks> make_tracks(const Document& document, FitTolerance tolerance, LifDiagnostics& diagnostics) {
  return Maker{document, tolerance, diagnostics}.make();
}

}  // namespace cosiva::zone::lif
