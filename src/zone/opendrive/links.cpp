#include "cosiva/zone/opendrive/links.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
namespace {

// Ends without a link belong together when they are this close.
constexpr double meets_m = 0.01;
constexpr double meets_rad = 0.01;
// A link to an end this far off is assumed to mean the other one, if that is this close.
constexpr double contact_far_m = 2.0;
constexpr double contact_near_m = 0.5;
// A hostile file may put many ends at one position; real ones have a handful there.
constexpr std::size_t pairs_max = 2'000'000;

class Linker {
 public:
  Linker(const Network& network, Tracks& tracks, Report& report) : network_{network}, tracks_{tracks}, report_{report} {
    for (std::uint32_t i = 0; i < network.roads.size(); ++i) roads_.emplace(network.roads[i].id, i);
  }

  void link_sections(std::uint32_t road);
  void link_road(std::uint32_t road, bool at_start);
  void link_connection(const Junction& junction, const Connection& connection);
  void link_what_meets();
  void finish();

 private:
  [[nodiscard]] std::optional<std::uint32_t> road(const std::string& id, const std::string& location);
  [[nodiscard]] const Lane* lane(const Tracks::End& end) const;
  [[nodiscard]] bool exit_of(const Tracks::End& end, TrackId track) const {
    return tracks_.tracks[track].curve.forward() != end.at_start;
  }
  [[nodiscard]] Point2 end_of(std::uint32_t road, bool at_start) const;
  [[nodiscard]] bool contact(std::uint32_t road, bool at_start, std::uint32_t other, bool other_at_start,
                             const std::string& location);
  [[nodiscard]] bool start_faces(std::uint32_t incoming, std::uint32_t connecting, bool at_start) const;
  void link(const Tracks::End& a, const Tracks::End& b, const std::string& location);
  void join_if_met(TrackId from, TrackId to);

  const Network& network_;
  Tracks& tracks_;
  Report& report_;
  std::map<std::string, std::uint32_t, std::less<>> roads_;
};

std::optional<std::uint32_t> Linker::road(const std::string& id, const std::string& location) {
  const auto found = roads_.find(id);
  if (found != roads_.end()) return found->second;
  report_.add(Diagnostic::Kind::lost, "links to roads that are not there", location,
              "leads to road '" + id + "', which is not there");
  return std::nullopt;
}

const Lane* Linker::lane(const Tracks::End& end) const {
  const auto& section = network_.roads[end.road].sections[end.section];
  const auto& side = end.lane > 0 ? section.left : section.right;
  const auto at = std::find_if(side.begin(), side.end(), [&](const Lane& lane) { return lane.id == end.lane; });
  return at == side.end() ? nullptr : &*at;
}

void Linker::link(const Tracks::End& a, const Tracks::End& b, const std::string& location) {
  const TrackId one = tracks_.find(a);
  const TrackId two = tracks_.find(b);
  if (one == no_track || two == no_track) {
    for (const Tracks::End& end : {a, b}) {
      if (lane(end) == nullptr && end.lane != 0)
        return report_.add(Diagnostic::Kind::lost, "links to lanes that are not there", location,
                           "leads to lane " + std::to_string(end.lane) + " of road '" + network_.roads[end.road].id +
                               "', which is not there");
    }
    // A link between two lanes that are not driven on is no loss.
    if (one != no_track || two != no_track) report_.count("links to lanes not driven on");
    return;
  }
  if (exit_of(a, one) == exit_of(b, two))
    return report_.add(Diagnostic::Kind::lost, "links of lanes that run against each other", location,
                       "links '" + tracks_.tracks[one].name(network_) + "' to '" + tracks_.tracks[two].name(network_) +
                           "', which run against each other");
  const TrackId from = exit_of(a, one) ? one : two;
  tracks_.tracks[from].next.push_back(from == one ? two : one);
}

/// Of its reference line, which it must have.
Point2 Linker::end_of(std::uint32_t road, bool at_start) const {
  const ReferenceLine& line = *tracks_.lines[road];
  return line.at(at_start ? line.from() : line.length()).p;
}

/// The end of a road that meets an end of another: the one that the file names, unless that is metres away and the
/// road's other end lies right there.
bool Linker::contact(std::uint32_t road, bool at_start, std::uint32_t other, bool other_at_start,
                     const std::string& location) {
  if (!tracks_.lines[road] || !tracks_.lines[other]) return at_start;
  const Point2 here = end_of(other, other_at_start);
  const double named_m = distance(here, end_of(road, at_start));
  const double opposite_m = distance(here, end_of(road, !at_start));
  if (named_m <= contact_far_m || opposite_m >= contact_near_m) return at_start;
  report_.add(Diagnostic::Kind::mended, "links to the wrong end of a road", location,
              std::string("leads to the ") + (at_start ? "start" : "end") + " of road '" + network_.roads[road].id +
                  "', which is " + metres(named_m) + " away; its other end is only " + metres(opposite_m) +
                  " away and is taken");
  return !at_start;
}

/// Lanes of a road's consecutive sections.
void Linker::link_sections(std::uint32_t road) {
  const Road& it = network_.roads[road];
  for (std::uint32_t i = 0; i + 1 < it.sections.size(); ++i) {
    for (const auto* side : {&it.sections[i].left, &it.sections[i].right}) {
      for (const Lane& lane : *side) {
        for (const int to : lane.successors) link({road, i, lane.id, false}, {road, i + 1, to, true}, it.location);
      }
    }
    for (const auto* side : {&it.sections[i + 1].left, &it.sections[i + 1].right}) {
      for (const Lane& lane : *side) {
        for (const int to : lane.predecessors) link({road, i + 1, lane.id, true}, {road, i, to, false}, it.location);
      }
    }
  }
}

/// Lanes at one end of a road, to those of the road that follows there.
void Linker::link_road(std::uint32_t index, bool at_start) {
  const Road& it = network_.roads[index];
  const auto& published = at_start ? it.predecessor : it.successor;
  if (!published || published->junction || it.sections.empty()) return;
  const std::string location = it.location + (at_start ? ", link/predecessor" : ", link/successor");
  const auto other = road(published->id, location);
  if (!other || network_.roads[*other].sections.empty()) return;
  const bool to_start = contact(*other, published->at_start, index, at_start, location);
  const auto last = [&](std::uint32_t of) {
    return static_cast<std::uint32_t>(network_.roads[of].sections.size() - 1);
  };
  const std::uint32_t here = at_start ? 0 : last(index);
  const std::uint32_t there = to_start ? 0 : last(*other);
  for (const auto* side : {&it.sections[here].left, &it.sections[here].right}) {
    for (const Lane& lane : *side) {
      for (const int to : at_start ? lane.predecessors : lane.successors)
        link({index, here, lane.id, at_start}, {*other, there, network_.roads[*other].lane_at(to_start, to), to_start},
             it.location);
    }
  }
}

/// The end of the incoming road that is nearer to where the connecting road begins.
bool Linker::start_faces(std::uint32_t incoming, std::uint32_t connecting, bool at_start) const {
  const auto& in = tracks_.lines[incoming];
  const auto& out = tracks_.lines[connecting];
  if (!in || !out) return false;
  const Point2 contact = out->at(at_start ? out->from() : out->length()).p;
  return distance(in->at(in->from()).p, contact) < distance(in->at(in->length()).p, contact);
}

void Linker::link_connection(const Junction& junction, const Connection& connection) {
  if (connection.incoming.empty() || connection.connecting.empty()) return;
  const auto incoming = road(connection.incoming, connection.location);
  const auto connecting = road(connection.connecting, connection.location);
  if (!incoming || !connecting) return;
  const Road& in = network_.roads[*incoming];
  const Road& out = network_.roads[*connecting];
  if (in.sections.empty() || out.sections.empty()) return;
  const auto leads_here = [&](const std::optional<RoadLink>& link) {
    return link && link->junction && link->id == junction.id;
  };
  bool in_start = leads_here(in.predecessor);
  if (in_start == leads_here(in.successor)) in_start = start_faces(*incoming, *connecting, connection.at_start);
  const auto section = [](const Road& of, bool start) {
    return start ? 0 : static_cast<std::uint32_t>(of.sections.size() - 1);
  };
  const bool out_start = contact(*connecting, connection.at_start, *incoming, in_start, connection.location);
  for (const auto& [from, to] : connection.lanes) {
    link({*incoming, section(in, in_start), in.lane_at(in_start, from), in_start},
         {*connecting, section(out, out_start), out.lane_at(out_start, to), out_start}, connection.location);
  }
}

void Linker::join_if_met(TrackId from, TrackId to) {
  // A road hardly longer than this meets everything, itself too.
  for (const TrackId track : {from, to}) {
    if (tracks_.tracks[track].curve.span() < 5.0 * meets_m) return;
  }
  const Pose2 exit = tracks_.tracks[from].curve.exit();
  const Pose2 entry = tracks_.tracks[to].curve.entry();
  if (distance(exit, entry) > meets_m || std::fabs(wrap_angle(exit.heading_rad - entry.heading_rad)) > meets_rad)
    return;
  tracks_.tracks[from].next.push_back(to);
  report_.add(
      Diagnostic::Kind::mended, "ends that meet without a link", "lane '" + tracks_.tracks[from].name(network_) + "'",
      "ends where '" + tracks_.tracks[to].name(network_) + "' begins, although the file has no such link; joined");
}

void Linker::link_what_meets() {
  std::vector<bool> followed(tracks_.tracks.size());
  std::vector<bool> led_to(tracks_.tracks.size());
  std::vector<std::pair<double, TrackId>> entries;
  for (TrackId id = 0; id < tracks_.tracks.size(); ++id) {
    followed[id] = !tracks_.tracks[id].next.empty();
    for (const TrackId to : tracks_.tracks[id].next) led_to[to] = true;
    entries.emplace_back(tracks_.tracks[id].curve.entry().x_m, id);
  }
  std::sort(entries.begin(), entries.end());
  std::size_t pairs = 0;
  for (TrackId from = 0; from < tracks_.tracks.size(); ++from) {
    const double x = tracks_.tracks[from].curve.exit().x_m;
    for (auto at = std::lower_bound(entries.begin(), entries.end(), std::pair{x - meets_m, TrackId{0}});
         at != entries.end() && at->first <= x + meets_m; ++at) {
      if (followed[from] && led_to[at->second]) continue;
      if (++pairs > pairs_max)
        return report_.add(Diagnostic::Kind::lost, "many ends at one position", "file",
                           "so many lanes end at the same positions that those without a link are not all joined");
      join_if_met(from, at->second);
    }
  }
}

void Linker::finish() {
  for (Track& track : tracks_.tracks) {
    std::sort(track.next.begin(), track.next.end());
    track.next.erase(std::unique(track.next.begin(), track.next.end()), track.next.end());
  }
}

}  // namespace

void link_tracks(const Network& network, Tracks& tracks, Report& report) {
  Linker linker{network, tracks, report};
  for (std::uint32_t road = 0; road < network.roads.size(); ++road) {
    linker.link_sections(road);
    linker.link_road(road, true);
    linker.link_road(road, false);
  }
  for (const Junction& junction : network.junctions) {
    for (const Connection& connection : junction.connections) linker.link_connection(junction, connection);
  }
  linker.finish();
  linker.link_what_meets();
  linker.finish();
}

}  // namespace cosiva::zone::opendrive
