#include "cosiva/zone/opendrive/joints.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cosiva::zone::opendrive {
namespace {

// Ends this close are left as they are: the circuit requires a millimetre and a milliradian.
constexpr double free_m = 5e-6;
constexpr double free_rad = 2e-5;
constexpr double worth_a_diagnostic = 1e-3;  // metres or radians
constexpr double short_track_m = 1.0;

/// Ends of tracks: 2·way is where a track is entered, 2·way + 1 where it is left.
using EndId = std::size_t;
EndId entry_of(TrackId track) { return 2 * std::size_t{track}; }
EndId exit_of(TrackId track) { return 2 * std::size_t{track} + 1; }

class Joiner {
 public:
  Joiner(const Network& network, Tracks& tracks, Report& report) : network_{network}, tracks_{tracks}, report_{report} {
    for (const Track& track : tracks.tracks) {
      poses_.push_back(track.curve.entry());
      poses_.push_back(track.curve.exit());
    }
    parent_.resize(poses_.size());
    std::iota(parent_.begin(), parent_.end(), EndId{0});
  }

  void unlink_what_is_apart();
  void join();

 private:
  [[nodiscard]] bool apart(TrackId from, TrackId to);
  [[nodiscard]] EndId root(EndId end);
  void join_group(const std::vector<EndId>& ends);
  [[nodiscard]] const Track& track_of(EndId end) const { return tracks_.tracks[end / 2]; }
  [[nodiscard]] double width(EndId end) const {
    return end % 2 == 0 ? track_of(end).width_entry : track_of(end).width_exit;
  }
  /// The weight of an end's position: high for wide lanes, and for those that have no room to be bent in.
  [[nodiscard]] double weight(EndId end) const {
    return width(end) * width(end) * (track_of(end).curve.span() < short_track_m ? 100.0 : 1.0);
  }

  const Network& network_;
  Tracks& tracks_;
  Report& report_;
  std::vector<Pose2> poses_;
  std::vector<EndId> parent_;
};

EndId Joiner::root(EndId end) {
  while (parent_[end] != end) {
    parent_[end] = parent_[parent_[end]];
    end = parent_[end];
  }
  return end;
}

/// Whether one would have to be bent too much to reach the other. The narrower one is moved, since a lane that begins
/// with no width begins at its neighbour's edge.
bool Joiner::apart(TrackId from, TrackId to) {
  const Pose2& exit = poses_[exit_of(from)];
  const Pose2& entry = poses_[entry_of(to)];
  const double gap_m = distance(exit, entry);
  const double kink_rad = wrap_angle(entry.heading_rad - exit.heading_rad);
  const Track& moves = width(exit_of(from)) < width(entry_of(to)) ? tracks_.tracks[from] : tracks_.tracks[to];
  if (gap_m <= std::min(gap_max_m, 0.25 * moves.curve.span()) && std::fabs(kink_rad) <= kink_max_rad) return false;
  std::string text = "its successor '" + tracks_.tracks[to].name(network_) + "' begins " + metres(gap_m) + " and ";
  text += std::to_string(kink_rad) + " rad from where it ends, too much to bend: they are not joined";
  report_.add(Diagnostic::Kind::lost, "links between ends too far apart",
              "lane '" + tracks_.tracks[from].name(network_) + "'", std::move(text));
  return true;
}

void Joiner::unlink_what_is_apart() {
  for (TrackId from = 0; from < tracks_.tracks.size(); ++from)
    std::erase_if(tracks_.tracks[from].next, [&](TrackId to) { return apart(from, to); });
}

void Joiner::join() {
  for (TrackId from = 0; from < tracks_.tracks.size(); ++from) {
    for (const TrackId to : tracks_.tracks[from].next) parent_[root(exit_of(from))] = root(entry_of(to));
  }
  std::vector<std::vector<EndId>> groups(poses_.size());
  for (EndId end = 0; end < poses_.size(); ++end) groups[root(end)].push_back(end);
  for (const auto& group : groups) {
    if (group.size() > 1) join_group(group);
  }
}

/// All ends move to their mean, by their weights.
void Joiner::join_group(const std::vector<EndId>& ends) {
  const Pose2& first = poses_[ends.front()];
  double worst_m = 0.0;
  double worst_rad = 0.0;
  double weights = 0.0;
  for (const EndId end : ends) {
    worst_m = std::max(worst_m, distance(first, poses_[end]));
    worst_rad = std::max(worst_rad, std::fabs(wrap_angle(poses_[end].heading_rad - first.heading_rad)));
    weights += weight(end);
  }
  if (worst_m <= free_m && worst_rad <= free_rad) return;
  Pose2 mean = first;
  for (const EndId end : ends) {
    const double ratio = weights > 1e-6 ? weight(end) / weights : 1.0 / static_cast<double>(ends.size());
    mean.x_m += ratio * (poses_[end].x_m - first.x_m);
    mean.y_m += ratio * (poses_[end].y_m - first.y_m);
    mean.heading_rad += ratio * wrap_angle(poses_[end].heading_rad - first.heading_rad);
  }
  mean.heading_rad = wrap_angle(mean.heading_rad);
  for (const EndId end : ends) {
    const double shift_m = distance(mean, poses_[end]);
    const double turn_rad = wrap_angle(mean.heading_rad - poses_[end].heading_rad);
    if (shift_m <= 1e-9 && std::fabs(turn_rad) <= 1e-9) continue;
    const double reach_m = std::min(easing_reach(shift_m, turn_rad), track_of(end).curve.span());
    tracks_.tracks[end / 2].curve.move_end(end % 2 == 0, mean, reach_m);
    if (shift_m <= worth_a_diagnostic && std::fabs(turn_rad) <= worth_a_diagnostic) continue;
    report_.add(Diagnostic::Kind::mended, "lane ends that did not meet", "lane '" + track_of(end).name(network_) + "'",
                std::string(end % 2 == 0 ? "its beginning" : "its end") + " is moved by " + metres(shift_m) + " and " +
                    std::to_string(turn_rad) + " rad, over " + metres(reach_m) + ", to meet the lanes linked to it");
  }
}

}  // namespace

void join_tracks(const Network& network, Tracks& tracks, Report& report) {
  Joiner joiner{network, tracks, report};
  joiner.unlink_what_is_apart();
  joiner.join();
}

}  // namespace cosiva::zone::opendrive
