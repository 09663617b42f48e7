#include "cosiva/zone/opendrive/sections.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
namespace {

constexpr std::size_t sections_max = 100'000;
constexpr double length_max_m = 3e5;       // of all lanes: a city's; a diverging polynomial needs more
constexpr std::size_t pieces_max = 5'000;  // of one lane between two lane sections
// Lanes without sections cost the most; a file with more of them is no road network.
constexpr std::size_t failures_max = 50;

struct Run {
  SectionId first{no_section};
  SectionId last{no_section};
};

class Layer {
 public:
  Layer(const Network& network, const Tracks& tracks, double scale, FitTolerance tolerance, Report& report)
      : network_{network}, tracks_{tracks.tracks}, scale_{scale}, tolerance_{tolerance}, report_{report} {}

  Result<std::vector<Circuit::Part>> lay();

 private:
  void lay_track(TrackId id);
  void add_parts(const Track& track, std::vector<Section> sections, double length_m);
  [[nodiscard]] std::optional<double> limit_at(const Track& track, double s) const;
  void link(TrackId id);

  const Network& network_;
  const std::vector<Track>& tracks_;
  double scale_;
  FitTolerance tolerance_;
  Report& report_;
  std::vector<Circuit::Part> parts_;
  std::vector<Run> runs_;
  std::size_t failures_{0};
  double length_m_{};
  double worst_m_{};
  double worst_rad_{};
};

void Layer::lay_track(TrackId id) {
  const Track& track = tracks_[id];
  std::vector<double> limits;
  for (const SpeedFrom& limit : track.speeds) limits.push_back(limit.s);
  auto fitted = fit(track.curve.curve(scale_, limits), tolerance_, pieces_max);
  if (!fitted) {
    ++failures_;
    return report_.add(Diagnostic::Kind::lost, "lanes that no sections follow", "lane '" + track.name(network_) + "'",
                       "is not taken: " + fitted.error().message);
  }
  if (fitted->worst_heading_rad > tolerance_.heading_rad)
    report_.add(Diagnostic::Kind::mended, "lanes that kink", "lane '" + track.name(network_) + "'",
                "kinks, as where its road begins to bend while its width changes; rounded, it heads " +
                    std::to_string(1e3 * fitted->worst_heading_rad) + " mrad off there at worst");
  worst_m_ = std::max(worst_m_, fitted->worst_position_m);
  if (fitted->worst_heading_rad <= tolerance_.heading_rad) worst_rad_ = std::max(worst_rad_, fitted->worst_heading_rad);
  runs_[id] = {static_cast<SectionId>(parts_.size()),
               static_cast<SectionId>(parts_.size() + fitted->sections.size() - 1)};
  length_m_ += fitted->length_m;
  add_parts(track, std::move(fitted->sections), fitted->length_m);
}

void Layer::add_parts(const Track& track, std::vector<Section> sections, double length_m) {
  const std::string name = track.name(network_);
  double before_m = 0.0;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    Circuit::Part part{name, std::move(sections[i]), std::nullopt, {}};
    if (i > 0) part.name += '.' + std::to_string(i + 1);
    if (i + 1 < sections.size()) part.next.push_back(static_cast<SectionId>(parts_.size() + 1));
    // Limits begin where sections do, so any position well inside will do.
    const double ratio = (before_m + 0.5 * part.section.length_m()) / length_m;
    const double s = track.curve.from() + track.curve.span() * (track.curve.forward() ? ratio : 1.0 - ratio);
    if (const auto limit = limit_at(track, s)) part.speed_mps_max = scale_ * *limit;
    before_m += part.section.length_m();
    parts_.push_back(std::move(part));
  }
}

std::optional<double> Layer::limit_at(const Track& track, double s) const {
  std::optional<double> limit;
  for (const SpeedFrom& from : track.speeds) {
    if (from.s <= s + 1e-3) limit = from.mps;
  }
  return limit;
}

void Layer::link(TrackId id) {
  if (runs_[id].last == no_section) return;
  Circuit::Part& part = parts_[runs_[id].last];
  // The straightest successor is the default.
  const auto turn = [&](TrackId to) {
    const LaneCurve& curve = tracks_[to].curve;
    return std::fabs(wrap_angle(curve.exit().heading_rad - curve.entry().heading_rad));
  };
  std::vector<std::pair<double, TrackId>> next;
  for (const TrackId to : tracks_[id].next) next.emplace_back(turn(to), to);
  std::stable_sort(next.begin(), next.end());
  for (const auto& [turned, to] : next) {
    if (runs_[to].first == no_section) continue;
    const Pose2& start = parts_[runs_[to].first].section.start();
    const Pose2& end = part.section.end();
    if (distance(start, end) < 1e-3 && std::fabs(wrap_angle(start.heading_rad - end.heading_rad)) < 1e-3) {
      part.next.push_back(runs_[to].first);
      continue;
    }
    report_.add(Diagnostic::Kind::lost, "links whose ends drifted apart", "lane '" + tracks_[id].name(network_) + "'",
                "its successor '" + tracks_[to].name(network_) + "' could not be bent to meet it: they are not joined");
  }
}

/// Reports the lanes present instead, and the lost ones.
std::string nothing_to_drive_on(const Report& report) {
  std::string text = "there is no lane that can be driven on";
  std::string types;
  for (const auto& [type, count] : report.counted_under("lane type ")) {
    if (types.size() < 200) types += (types.empty() ? "" : ", ") + std::to_string(count) + ' ' + type;
  }
  if (!types.empty()) text += "; lanes of other types: " + types + " ([import] lane_types in the sidecar file chooses)";
  bool lost = false;
  for (const Diagnostic& diagnostic : report.diagnostics()) {
    if (diagnostic.kind != Diagnostic::Kind::lost) continue;
    lost = true;
    if (text.size() > 600) break;
    text += "; " + diagnostic.location;
    text += ' ' + diagnostic.text;
  }
  if (types.empty() && !lost) text += "; its roads have none but their centre line";
  return text;
}

Result<std::vector<Circuit::Part>> Layer::lay() {
  runs_.resize(tracks_.size());
  for (TrackId id = 0; id < tracks_.size(); ++id) {
    lay_track(id);
    if (parts_.size() > sections_max)
      return fail("zone.size", "following the lanes takes more than " + std::to_string(sections_max) + " sections");
    if (length_m_ > length_max_m)
      return fail("zone.size", "expected at most 300 km of lanes, found more up to lane '" +
                                   tracks_[id].name(network_) +
                                   "'; [import] scale in the sidecar file makes a large network small");
    if (failures_ > failures_max)
      return fail("zone.size", "more than " + std::to_string(failures_max) +
                                   " lanes cannot be followed; the first: " + report_.diagnostics().back().text);
  }
  if (parts_.empty()) return fail("circuit.empty", nothing_to_drive_on(report_));
  for (TrackId id = 0; id < tracks_.size(); ++id) link(id);
  report_.add(Diagnostic::Kind::notice, "fits", "lanes",
              "their centre lines are followed by " + std::to_string(parts_.size()) + " sections, at worst " +
                  metres(worst_m_) + " and " + std::to_string(1e3 * worst_rad_) + " mrad off");
  return std::move(parts_);
}

}  // namespace

Result<std::vector<Circuit::Part>> lay_sections(const Network& network, const Tracks& tracks, double scale,
                                                FitTolerance tolerance, Report& report) {
  return Layer{network, tracks, scale, tolerance, report}.lay();
}

}  // namespace cosiva::zone::opendrive
