#include "cosiva/virtual/fleet/spread.h"

#include <algorithm>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/fleet/ground.h"
#include "cosiva/virtual/fleet/spacing.h"

namespace cosiva::virtual_side {
namespace {

/// Between two vehicles placed one behind the other.
constexpr double start_gap_m = aiv::clearance_m + 0.01;

/// Takes track positions one after the other. Invariant: two of them are never nearer to each other than a vehicle's
/// length and clearance.
class Spread {
 public:
  Spread(const zone::TrafficZone& zone, const Ground& ground)
      : zone_{zone}, ground_{ground}, apart_m_{occupied_m(zone) + start_gap_m}, taken_(ground.size()) {}

  /// As many as there is room for, at most `count`, a new one after each `every_m` of track.
  [[nodiscard]] std::vector<zone::TrackPosition> take(std::size_t count, double every_m) {
    for (auto& positions : taken_) positions.clear();
    std::vector<zone::TrackPosition> found;
    const double pitch_m = std::min(0.25 * apart_m_, every_m);
    double since_m = every_m;
    for (zone::SectionId id = 0; id < ground_.size() && found.size() < count; ++id) {
      for (double s_m = 0.0; s_m < ground_.length_m(id) && found.size() < count; s_m += pitch_m, since_m += pitch_m) {
        if (since_m < every_m || !ground_.may_stop({id, s_m}) || !is_free(id, s_m)) continue;
        COSIVA_EXPECT(taken_[id].empty() || s_m - taken_[id].back() >= apart_m_);
        found.push_back({id, s_m});
        taken_[id].push_back(s_m);
        since_m = 0.0;
      }
    }
    return found;
  }

 private:
  [[nodiscard]] bool is_free(zone::SectionId id, double s_m) const {
    for (const double other : taken_[id])
      if (other > s_m - apart_m_ && other < s_m + apart_m_) return false;
    return is_free_ahead(id, ground_.length_m(id) - s_m, 0) && is_free_behind(id, s_m, 0);
  }
  [[nodiscard]] bool is_free_ahead(zone::SectionId id, double path_distance_m, int depth) const {
    if (path_distance_m >= apart_m_ || depth > 16) return true;
    return std::ranges::all_of(zone_.circuit.next(id), [&](zone::SectionId to) {
      return std::ranges::none_of(taken_[to], [&](double s_m) { return path_distance_m + s_m < apart_m_; }) &&
             is_free_ahead(to, path_distance_m + ground_.length_m(to), depth + 1);
    });
  }
  [[nodiscard]] bool is_free_behind(zone::SectionId id, double path_distance_m, int depth) const {
    if (path_distance_m >= apart_m_ || depth > 16) return true;
    return std::ranges::all_of(zone_.circuit.previous(id), [&](zone::SectionId from) {
      const double length_m = ground_.length_m(from);
      return std::ranges::none_of(taken_[from],
                                  [&](double s_m) { return path_distance_m + length_m - s_m < apart_m_; }) &&
             is_free_behind(from, path_distance_m + length_m, depth + 1);
    });
  }

  const zone::TrafficZone& zone_;
  const Ground& ground_;
  double apart_m_;
  std::vector<std::vector<double>> taken_;
};

}  // namespace

std::vector<FleetStart> spread_starts(const zone::TrafficZone& zone, std::size_t count, std::uint32_t copy) {
  auto ground = Ground::make(std::shared_ptr<const zone::TrafficZone>(std::shared_ptr<void>{}, &zone));
  if (!ground || count == 0) return {};
  Spread spread{zone, *ground};
  double every_m = zone.circuit.total_length_m() / static_cast<double>(count);
  std::vector<zone::TrackPosition> positions;
  std::vector<zone::TrackPosition> best;
  // Positions in crossings are lost; so the pitch is reduced until all fit, or until the vehicles are as close as
  // permitted.
  constexpr int tries = 60;
  for (int attempt = 0; attempt < tries; ++attempt) {
    positions = spread.take(count, every_m);
    if (positions.size() > best.size()) best = std::move(positions);
    if (best.size() == count || every_m < 0.5 * zone.vehicle.length_m) break;
    every_m *= 0.93;
  }
  std::vector<FleetStart> starts;
  starts.reserve(best.size());
  for (const zone::TrackPosition& position : best) starts.push_back({copy, position, 0});
  return starts;
}

}  // namespace cosiva::virtual_side
