#include "cosiva/aiv/estimation/track.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cosiva::estimation {

Result<Track> Track::make(std::shared_ptr<const zone::Circuit> circuit, std::vector<zone::SectionId> sections,
                          bool closed) {
  if (sections.empty()) return fail("track.empty", "a track has at least one section");
  for (std::size_t i = 0; i + (closed ? 0 : 1) < sections.size(); ++i) {
    const auto next = circuit->next(sections[i]);
    const zone::SectionId wanted = sections[(i + 1) % sections.size()];
    if (std::ranges::find(next, wanted) == next.end())
      return fail("track.gap", "section " + circuit->part(wanted).name + " does not follow it",
                  circuit->part(sections[i]).name);
  }
  Track track;
  track.starts_.push_back(0.0);
  for (const zone::SectionId id : sections)
    track.starts_.push_back(track.starts_.back() + circuit->section(id).length_m());
  track.circuit_ = std::move(circuit);
  track.sections_ = std::move(sections);
  track.closed_ = closed;
  return track;
}

Result<Track> Track::of_loop(std::shared_ptr<const zone::Circuit> circuit) {
  std::vector<zone::SectionId> sections;
  zone::SectionId id = 0;
  while (id != zone::no_section && std::ranges::find(sections, id) == sections.end()) {
    sections.push_back(id);
    const auto next = circuit->next(id);
    id = next.empty() ? zone::no_section : next.front();
  }
  // The sections that only lead into the loop are no part of it.
  const bool closed = id != zone::no_section;
  if (closed) sections.erase(sections.begin(), std::ranges::find(sections, id));
  return make(std::move(circuit), std::move(sections), closed);
}

Result<Track> Track::round(const std::shared_ptr<const zone::TrafficZone>& zone,
                           std::optional<zone::SectionId> through) {
  const std::shared_ptr<const zone::Circuit> circuit(zone, &zone->circuit);
  const auto leads = [&](const zone::Loop& loop) {
    return !through || std::ranges::find(loop.sections, *through) != loop.sections.end();
  };
  const auto loop = std::ranges::find_if(zone->loops, leads);
  if (loop != zone->loops.end()) return make(circuit, loop->sections, true);
  return of_loop(circuit);
}

std::optional<double> Track::along_of(zone::TrackPosition position) const {
  const auto found = std::ranges::find(sections_, position.section);
  if (found == sections_.end()) return std::nullopt;
  return starts_[static_cast<std::size_t>(found - sections_.begin())] + position.s_m;
}

double Track::once(double along_m) const {
  if (!closed_) return std::clamp(along_m, 0.0, length_m());
  if (along_m >= 0.0 && along_m < length_m()) return along_m;
  const double once_m = along_m - length_m() * std::floor(along_m / length_m());
  return once_m < length_m() ? std::fmax(once_m, 0.0) : 0.0;
}

std::size_t Track::index_at(double once_m) const {
  const auto after = std::upper_bound(starts_.begin() + 1, starts_.end() - 1, once_m);
  return static_cast<std::size_t>(after - starts_.begin()) - 1;
}

zone::TrackPosition Track::position_at(double along_m) const {
  const double once_m = once(along_m);
  const std::size_t i = index_at(once_m);
  return {sections_[i], once_m - starts_[i]};
}

Pose2 Track::pose_at(double along_m) const { return circuit_->pose_at(position_at(along_m)); }

double Track::curvature_at(double along_m) const {
  const zone::TrackPosition position = position_at(along_m);
  return circuit_->section(position.section).curvature_at(position.s_m);
}

std::optional<double> Track::foot(Point2 p_M, double near_m, double reach_m, double beside_m) const {
  // A proper foot is at right angles to the path. Only where there is none, beyond a corner, does an end serve:
  // otherwise the end of the section before would always seem a little nearer to an estimate that lags behind.
  std::optional<double> proper;
  std::optional<double> end;
  const double laps = closed_ ? std::floor((near_m - reach_m) / length_m()) : 0.0;
  const double laps_last = closed_ ? std::floor((near_m + reach_m) / length_m()) : 0.0;
  for (double lap = laps; lap <= laps_last; lap += 1.0) {
    for (std::size_t i = 0; i < sections_.size(); ++i) {
      const double from_m = lap * length_m() + starts_[i];
      const zone::Section& section = circuit_->section(sections_[i]);
      if (from_m > near_m + reach_m || from_m + section.length_m() < near_m - reach_m) continue;
      const zone::Section::Nearest nearest = section.nearest(p_M);
      const double along_m = from_m + nearest.s_m;
      if (nearest.distance_m > beside_m || std::fabs(along_m - near_m) > reach_m) continue;
      auto& best = nearest.distance_m > std::fabs(nearest.left_m) + 1e-9 ? end : proper;
      if (!best || std::fabs(along_m - near_m) < std::fabs(*best - near_m)) best = along_m;
    }
  }
  return proper ? proper : end;
}

}  // namespace cosiva::estimation
