#include "cosiva/aiv/decision/obstacle_watch.h"

#include <limits>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// Clearance around a body that turns on the spot.
constexpr double sweep_margin_m = 0.05;
/// At a bend this near ahead the turn may begin at any moment.
constexpr double bend_near_m = 0.03;

}  // namespace

ObstacleWatch::ObstacleWatch(const zone::TrafficZone& zone, bool one_way)
    : zone_{zone}, one_way_{one_way}, corridor_{zone}, sweep_{zone.vehicle} {}

void ObstacleWatch::on_ranges(const PositionEstimator& position, const wire::Ranges& ranges) {
  COSIVA_EXPECT(position.known());
  scan_ = corridor_.scan(position.outlook(), ranges);
  ahead_.add(scan_.ahead_m, position.travelled_m());
  if (!one_way_ || position.off_path()) around_.add(corridor_.nearest_m(ranges), 0.0);
  if (position.near_path()) entry_.add(in_entry(position, ranges) ? 0.0 : std::numeric_limits<double>::infinity(), 0.0);
}

bool ObstacleWatch::in_entry(const PositionEstimator& position, const wire::Ranges& ranges) {
  const Pose2 X_MG = zone_.circuit.pose_at(position.track_position());
  const OffPathEstimator& manoeuvre = position.off_path_estimator();
  if (manoeuvre.manoeuvred() && manoeuvre.left_line_at())
    sweep_.take_rest({*manoeuvre.left_line_at(), X_MG}, *manoeuvre.manoeuvred());
  else
    sweep_.take({position.pose(), X_MG});
  return corridor_.any_echo(ranges, [&](Point2 p_B) { return sweep_.over(position.pose() * p_B); });
}

bool ObstacleWatch::may_sweep(const PositionEstimator& position, double bend_ahead_m) const {
  if (position.near_path()) return entry_.obstacle_ahead_m(0.0) > 0.0;
  if (one_way_ && !position.off_path()) return true;
  if (!position.off_path() && bend_ahead_m > bend_near_m) return true;
  const double corner_m = 0.5 * norm(zone_.vehicle.length_m, zone_.vehicle.width_m);
  return around_.obstacle_ahead_m(0.0) > corner_m + sweep_margin_m;
}

void ObstacleWatch::archive(Archive& archive) { archive(scan_, ahead_, around_, entry_); }

}  // namespace cosiva::aiv
