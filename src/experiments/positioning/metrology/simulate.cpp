#include "cosiva/experiments/positioning/metrology/simulate.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "cosiva/base/gaussians.h"
#include "cosiva/base/math.h"
#include "cosiva/base/math_inline.h"
#include "cosiva/base/random.h"

namespace cosiva::experiments {
namespace {

using estimation::Odometry;
using estimation::Reading;

/// Distance after which a vehicle's lateral offset is independent of the previous one.
constexpr double line_length_m = 0.3;

/// The next beacon on the unrolled path.
class Beacons {
 public:
  explicit Beacons(const Simulation& simulation) : simulation_{simulation} {}

  [[nodiscard]] double next_m() const {
    if (simulation_.fiducials.empty())
      return simulation_.fiducials_only ? 1e300 : static_cast<double>(k_ + 1) * simulation_.pitch_m;
    if (k_ >= simulation_.fiducials.size() && !simulation_.track->closed()) return 1e300;
    const std::size_t rounds = k_ / simulation_.fiducials.size();
    return static_cast<double>(rounds) * simulation_.track->length_m() +
           simulation_.fiducials[k_ % simulation_.fiducials.size()].along_m;
  }
  [[nodiscard]] std::uint32_t number() const {
    if (simulation_.fiducials.empty()) return static_cast<std::uint32_t>(k_ + 1);
    return simulation_.fiducials[k_ % simulation_.fiducials.size()].number;
  }
  [[nodiscard]] Point2 surveyed() const {
    if (simulation_.fiducials.empty()) return position(simulation_.track->pose_at(next_m()));
    return simulation_.fiducials[k_ % simulation_.fiducials.size()].position_M;
  }
  void pass() { ++k_; }

 private:
  const Simulation& simulation_;
  std::size_t k_{0};
};

/// One run being made.
class Drive {
 public:
  Drive(const Simulation& simulation, std::uint64_t seed, Trial& run)
      : simulation_{simulation},
        run_{run},
        beacons_{simulation},
        survey_seed_{seed},
        odometer_{seed, "metrology/odometer"},
        reader_{seed, "metrology/reader"},
        line_{seed, "metrology/line"},
        scale_{1.0 + Random(seed, "metrology/scale").gaussian(0.0, simulation.scale_sigma)},
        left_m_{line_.next(0.0, simulation.sensors.line_sigma_m)},
        ground_truth_{pose()} {
    begin(seed);
  }

  void go() {
    const auto steps = static_cast<std::size_t>(
        std::floor(simulation_.distance_m * simulation_.odometry_hz / simulation_.speed_mps + 1e-9));
    run_.moments.reserve(steps);
    run_.events.reserve(steps + static_cast<std::size_t>(2.5 * simulation_.distance_m / simulation_.pitch_m));
    for (std::size_t i = 1; i <= steps; ++i) {
      const double until_m = static_cast<double>(i) * step_m_;
      while (beacons_.next_m() <= until_m) {
        roll(beacons_.next_m());
        read();
      }
      roll(until_m);
      run_.moments.push_back({run_.events.size(), static_cast<double>(i) / simulation_.odometry_hz, ground_truth_,
                              along_m_, along_m_ - fiducial_m_, kind_});
    }
  }

 private:
  void begin(std::uint64_t seed) {
    Random start{seed, "metrology/start"};
    run_.events.clear();
    run_.moments.clear();
    estimation::Setting& setting = run_.setting;
    setting.track = simulation_.track;
    setting.start_along_m = start.gaussian(0.0, simulation_.start_sigma_m);
    setting.start = ground_truth_;
    setting.start.x_m += start.gaussian(0.0, simulation_.start_sigma_m);
    setting.start.y_m += start.gaussian(0.0, simulation_.start_sigma_m);
    setting.start.heading_rad =
        wrap_angle(ground_truth_.heading_rad + start.gaussian(0.0, simulation_.start_heading_sigma_rad));
    setting.start_sigma_m = simulation_.start_sigma_m;
    setting.start_heading_sigma_rad = simulation_.start_heading_sigma_rad;
    setting.sensors = simulation_.sensors;
    setting.seed = seed;
  }

  /// Records the actual position and the kind of its section.
  [[nodiscard]] Pose2 pose() {
    const zone::TrackPosition track_position = simulation_.track->position_at(along_m_);
    const zone::Section& section = simulation_.track->circuit().section(track_position.section);
    kind_ = section.kind();
    const Pose2 on_line = section.pose_at(track_position.s_m);
    if (left_m_ == 0.0) return on_line;
    // on_line * Pose2{0.0, left_m_, 0.0}
    const SinCos h = plain::sincos(on_line.heading_rad);
    return {on_line.x_m - h.sin * left_m_, on_line.y_m + h.cos * left_m_, wrap_angle(on_line.heading_rad)};
  }

  /// Drives to a point along the path, with odometry events.
  void roll(double to_m) {
    const double d = to_m - along_m_;
    if (d <= 0.0) return;
    along_m_ = to_m;
    if (simulation_.sensors.line_sigma_m > 0.0) {
      // Whole steps are equal up to rounding.
      const bool whole = std::fabs(d - step_m_) < 1e-9 * step_m_;
      const double keeps = whole ? step_keeps_ : det_exp(-d / line_length_m);
      left_m_ = keeps * left_m_ + simulation_.sensors.line_sigma_m * std::sqrt(1.0 - keeps * keeps) * line_.next();
    }
    const double heading_before = ground_truth_.heading_rad;
    ground_truth_ = pose();
    const double q = simulation_.sensors.distance_variance_per_m;
    Odometry odometry{scale_ * (d + std::sqrt(q * d) * odometer_.next()), 0.0, d / simulation_.speed_mps};
    if (simulation_.turns) {
      const double turn = wrap_angle(ground_truth_.heading_rad - heading_before);
      const double variance =
          simulation_.sensors.turn_variance_per_m * d + simulation_.sensors.turn_variance_per_rad * std::fabs(turn);
      odometry.turn_rad = turn + std::sqrt(variance) * odometer_.next();
    }
    run_.events.emplace_back(odometry);
  }

  /// Reads the beacon under the vehicle. The reading is Gaussian about the actual value.
  void read() {
    const std::uint32_t number = beacons_.number();
    Point2 surveyed_M = beacons_.surveyed();
    const Point2 detected_B = inverse(ground_truth_) * surveyed_M;
    beacons_.pass();
    if (simulation_.survey_sigma_m > 0.0) {
      Random survey{survey_seed_, "metrology/survey/" + std::to_string(number)};
      surveyed_M.x_m += survey.gaussian(0.0, simulation_.survey_sigma_m);
      surveyed_M.y_m += survey.gaussian(0.0, simulation_.survey_sigma_m);
    }
    const double along = reader_.gaussian(0.0, simulation_.sensors.fiducial_along_sigma_m);
    const double across = reader_.gaussian(0.0, simulation_.sensors.fiducial_across_sigma_m);
    if (simulation_.read_ratio < 1.0 && !reader_.chance(simulation_.read_ratio)) return;
    run_.events.emplace_back(Reading{number, surveyed_M, {detected_B.x_m + along, detected_B.y_m + across}});
    fiducial_m_ = along_m_;
  }

  const Simulation& simulation_;
  Trial& run_;
  Beacons beacons_;
  std::uint64_t survey_seed_;
  Gaussians odometer_;
  Random reader_;
  Gaussians line_;
  double scale_;
  double along_m_{0.0};
  double fiducial_m_{0.0};
  double left_m_;
  zone::SectionKind kind_{};
  double step_m_{simulation_.speed_mps / simulation_.odometry_hz};
  double step_keeps_{det_exp(-step_m_ / line_length_m)};
  Pose2 ground_truth_;
};

}  // namespace

Result<void> check(const Simulation& simulation) {
  const auto positive = [](double v) { return v > 0.0 && v < 1e9; };
  if (!simulation.track) return fail("simulation.track", "there is no path to follow");
  if (!positive(simulation.distance_m)) return fail("simulation.distance", "a distance must be more than 0");
  if (!simulation.track->closed() && simulation.distance_m > simulation.track->length_m())
    return fail("simulation.distance", "the path ends after " + std::to_string(simulation.track->length_m()) + " m");
  if (!positive(simulation.speed_mps)) return fail("simulation.speed", "a speed must be more than 0");
  if (!positive(simulation.odometry_hz)) return fail("simulation.odometry", "the rate of odometry must be more than 0");
  if (!positive(simulation.pitch_m)) return fail("simulation.pitch", "the pitch of beacons must be more than 0");
  if (!(simulation.read_ratio > 0.0 && simulation.read_ratio <= 1.0))
    return fail("simulation.reads", "the ratio of beacons that are read must be in (0, 1]");
  if (!(simulation.sensors.fiducial_along_sigma_m > 0.0))
    return fail("simulation.reader", "no reader is without error");
  if (simulation.distance_m / simulation.speed_mps * simulation.odometry_hz < 1.0)
    return fail("simulation.distance", "the run ends before the first odometry");
  if (simulation.distance_m / simulation.speed_mps * simulation.odometry_hz > 2e7)
    return fail("simulation.length", "that is more than 20 million steps in one run");
  return {};
}

void simulate(const Simulation& simulation, std::uint64_t seed, Trial& run) {
  run.name = "seed " + std::to_string(seed);
  run.heading_known = true;
  Drive(simulation, seed, run).go();
}

std::vector<Simulation::Fiducial> fiducials_of(const estimation::Track& track, const zone::BeaconGrid& grid,
                                               double reach_m) {
  std::vector<Simulation::Fiducial> fiducials;
  // Along the track in steps short enough that no beacon in reach is skipped.
  const double step_m = 0.25 * grid.pitch_m;
  for (double s = 0.0; s < track.length_m(); s += step_m) {
    const auto near = grid.nearest(position(track.pose_at(s)));
    if (!near) continue;
    const auto foot = track.foot(near->position, s, step_m, reach_m);
    if (foot && *foot >= 0.0 && *foot < track.length_m()) fiducials.push_back({near->number, *foot, near->position});
  }
  std::ranges::sort(fiducials, {}, &Simulation::Fiducial::along_m);
  const auto same = [](const Simulation::Fiducial& a, const Simulation::Fiducial& b) {
    return a.number == b.number && std::fabs(a.along_m - b.along_m) < 1e-3;
  };
  fiducials.erase(std::unique(fiducials.begin(), fiducials.end(), same), fiducials.end());
  return fiducials;
}

std::vector<Simulation::Fiducial> fiducials_of(const estimation::Track& track, const zone::TrafficZone& zone) {
  std::vector<Simulation::Fiducial> fiducials;
  for (double s = 0.0; s < track.length_m();) {
    const zone::TrackPosition track_position = track.position_at(s);
    const double end_m = s - track_position.s_m + zone.circuit.section(track_position.section).length_m();
    for (const zone::Tag& tag : zone.tags) {
      if (tag.position.section == track_position.section)
        fiducials.push_back(
            {tag.number, s - track_position.s_m + tag.position.s_m, position(zone.circuit.pose_at(tag.position))});
    }
    s = end_m + 1e-9;
  }
  std::ranges::sort(fiducials, {}, &Simulation::Fiducial::along_m);
  return fiducials;
}

}  // namespace cosiva::experiments
