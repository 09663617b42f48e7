#include "cosiva/zone/opendrive/tracks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cosiva::zone::opendrive {
namespace {

constexpr double section_min_m = 1e-3;
constexpr double width_min_m = 0.01;
// Of all lanes together: a file may contain many records, and each lane has those of all lanes further in.
constexpr std::size_t pieces_max = 10'000'000;

/// Work used so far, and the remaining work, over all roads.
struct Work {
  std::size_t pieces{0};
  std::size_t samples{20'000'000};  ///< for folds; in a file with more than 5000 km of lanes the search ends
};

std::string lane_location(const Road& road, std::size_t section, int lane) {
  std::string text = road.location + ", laneSection[" + std::to_string(section + 1);
  return text + "], lane " + std::to_string(lane);
}

/// Reads one road's lanes.
class RoadLanes {
 public:
  RoadLanes(const Network& network, std::uint32_t road, const std::vector<std::string>& types, Tracks& tracks,
            Work& work, Report& report)
      : road_{network.roads[road]}, index_{road}, types_{types}, tracks_{tracks}, work_{work}, report_{report} {}

  void read(std::shared_ptr<const ReferenceLine> line);

 private:
  void read_side(std::size_t section, int sign, double from, double to);
  [[nodiscard]] Pieces outer_border(const Lane& lane, const Pieces& inner, int sign, std::size_t section, double from,
                                    double to);
  void add(const Lane& lane, std::size_t section, const Pieces& inner, const Pieces& outer, double from, double to);
  [[nodiscard]] std::vector<SpeedFrom> speeds(const Lane& lane, double from) const;

  const Road& road_;
  std::uint32_t index_;
  const std::vector<std::string>& types_;
  Tracks& tracks_;
  Work& work_;
  Report& report_;
  std::shared_ptr<const ReferenceLine> line_;
};

void RoadLanes::read(std::shared_ptr<const ReferenceLine> line) {
  line_ = std::move(line);
  const auto& sections = road_.sections;
  const double first = road_.plan.front().s;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    // A gap of a hair's breadth before the first section is ignored.
    const double from = i == 0 && sections[i].s < first + 0.01 ? first : sections[i].s;
    const double to = std::min(i + 1 < sections.size() ? sections[i + 1].s : line_->length(), line_->length());
    if (i > 0 && sections[i].s < sections[i - 1].s)
      report_.add(Diagnostic::Kind::mended, "lane sections out of order", road_.location,
                  "its lane sections do not follow each other; the one that begins too early is left out");
    if (to - from < section_min_m) {
      report_.add(Diagnostic::Kind::mended, "lane sections without length", lane_location(road_, i, 0),
                  "has no length here, and its lanes are not taken");
      continue;
    }
    for (const int sign : {1, -1}) read_side(i, sign, from, to);
  }
}

void RoadLanes::read_side(std::size_t section, int sign, double from, double to) {
  const auto& lanes = sign > 0 ? road_.sections[section].left : road_.sections[section].right;
  Pieces inner = holding(road_.offsets, from, to, false);
  for (const Lane& lane : lanes) {
    const Pieces outer = outer_border(lane, inner, sign, section, from, to);
    work_.pieces += outer.size();
    if (work_.pieces > pieces_max) {
      report_.add(Diagnostic::Kind::lost, "lanes of too many records", lane_location(road_, section, lane.id),
                  "is not taken: the file has more records of width than any real one");
      return;
    }
    if (std::find(types_.begin(), types_.end(), lane.type) != types_.end())
      add(lane, section, inner, outer, from, to);
    else
      report_.count("lane type " + lane.type);
    inner = outer;
  }
}

Pieces RoadLanes::outer_border(const Lane& lane, const Pieces& inner, int sign, std::size_t section, double from,
                               double to) {
  const bool by_width = !lane.widths.empty() || lane.borders.empty();
  std::vector<Polynomial> records = by_width ? lane.widths : lane.borders;
  double first = std::numeric_limits<double>::infinity();
  for (Polynomial& record : records) {
    record.s += road_.sections[section].s;
    first = std::min(first, record.s - from);
  }
  if (first > 0.05 && !records.empty())
    report_.add(Diagnostic::Kind::mended, "lanes whose width begins late", lane_location(road_, section, lane.id),
                "has no width in its first " + metres(first) + "; the first width after that is used there");
  const Pieces published = holding(std::move(records), from, to, true);
  if (by_width) return sum(inner, 1.0, published, sign, nearness(from, to));
  // A border is measured from lane 0, and some exporters write it without its sign.
  const double centre = 0.5 * (from + to);
  const double there = piece_at(published, centre).at(centre - piece_at(published, centre).s);
  const double facing = there * sign < 0.0 ? -1.0 : 1.0;
  return sum(holding(road_.offsets, from, to, false), 1.0, published, facing, nearness(from, to));
}

void RoadLanes::add(const Lane& lane, std::size_t section, const Pieces& inner, const Pieces& outer, double from,
                    double to) {
  const std::string location = lane_location(road_, section, lane.id);
  const Pieces width = sum(outer, lane.id > 0 ? 1.0 : -1.0, inner, lane.id > 0 ? -1.0 : 1.0, nearness(from, to));
  const auto width_at = [&](double s) {
    const Polynomial& piece = piece_at(width, s);
    return std::max(piece.at(s - piece.s), 0.0);
  };
  double widest = 0.0;
  for (int i = 0; i <= 16; ++i) widest = std::max(widest, width_at(from + (to - from) * i / 16));
  if (widest < width_min_m)
    return report_.add(Diagnostic::Kind::lost, "lanes without width", location, "has no width, and is not taken");
  auto lateral = Lateral::make(sum(inner, 0.5, outer, 0.5, nearness(from, to)), to);
  if (!lateral)
    return report_.add(Diagnostic::Kind::lost, "lanes that jump sideways", location,
                       "jumps sideways further than can be smoothed, and is not taken");
  if (lateral->greatest_jump() > 1e-4 || lateral->greatest_kink() > 1e-2)
    report_.add(Diagnostic::Kind::mended, "lanes whose width jumps or kinks", location,
                "its centre line jumps sideways by up to " + metres(lateral->greatest_jump()) + " and kinks by up to " +
                    std::to_string(lateral->greatest_kink()) + " rad where records of width or offset meet; smoothed");
  if (lane.type == "bidirectional")
    report_.add(Diagnostic::Kind::lost, "lanes of both directions", location,
                "is driven both ways in the file; here only in the direction of its side");
  const bool forward = ((lane.id < 0) != road_.left_hand) != lane.reversed;
  const double at_from = width_at(from);
  const double at_to = width_at(to);
  LaneCurve curve{line_, std::move(*lateral), from, to, forward};
  if (const double cut_m = curve.cut_folds(work_.samples); cut_m > 0.0)
    report_.add(Diagnostic::Kind::mended, "lanes that fold in a bend", location,
                "lies so far inside a bend of its road that it would kink or run backwards there; cut short over " +
                    metres(cut_m) + " of the road");
  tracks_.tracks.push_back({index_, static_cast<std::uint32_t>(section), lane.id, std::move(curve),
                            forward ? at_from : at_to, forward ? at_to : at_from, speeds(lane, from)});
}

/// The lane's own limits take precedence over the road's.
std::vector<SpeedFrom> RoadLanes::speeds(const Lane& lane, double from) const {
  std::vector<SpeedFrom> own = lane.speeds;
  for (SpeedFrom& limit : own) limit.s += from;  // sOffset counts from the lane section
  const auto by_s = [](const SpeedFrom& a, const SpeedFrom& b) { return a.s < b.s; };
  std::stable_sort(own.begin(), own.end(), by_s);
  std::vector<SpeedFrom> all = road_.speeds;
  std::stable_sort(all.begin(), all.end(), by_s);
  if (!own.empty()) std::erase_if(all, [&](const SpeedFrom& limit) { return limit.s >= own.front().s; });
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

}  // namespace

TrackId Tracks::find(const End& end) const {
  const auto key = [](const auto& of) { return std::tuple{of.road, of.section, of.lane}; };
  const auto at = std::lower_bound(tracks.begin(), tracks.end(), end,
                                   [&](const Track& track, const End& wanted) { return key(track) < key(wanted); });
  if (at == tracks.end() || key(*at) != key(end)) return no_track;
  return static_cast<TrackId>(at - tracks.begin());
}

Tracks find_tracks(const Network& network, const std::vector<std::string>& lane_types, Report& report) {
  Tracks found;
  found.lines.resize(network.roads.size());
  Work work;
  for (std::uint32_t road = 0; road < network.roads.size(); ++road) {
    if (network.roads[road].sections.empty()) {
      report.add(Diagnostic::Kind::lost, "roads without lanes", network.roads[road].location, "has no lane section");
      continue;
    }
    auto line = ReferenceLine::make(network.roads[road], report);
    if (!line) continue;
    found.lines[road] = std::make_shared<const ReferenceLine>(std::move(*line));
    RoadLanes{network, road, lane_types, found, work, report}.read(found.lines[road]);
  }
  std::sort(found.tracks.begin(), found.tracks.end(), [](const Track& a, const Track& b) {
    return std::tuple{a.road, a.section, a.lane} < std::tuple{b.road, b.section, b.lane};
  });
  return found;
}

}  // namespace cosiva::zone::opendrive
