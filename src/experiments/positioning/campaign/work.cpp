#include "cosiva/experiments/positioning/campaign/work.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "cosiva/base/digest.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/positioning/metrology/limit.h"
#include "cosiva/experiments/positioning/metrology/metrics.h"
#include "cosiva/experiments/statistics/sample.h"
#include "cosiva/zone/layout/beacons.h"

namespace cosiva::experiments {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
/// Approximate number of iterations of a unit: a twentieth of a second, so that a killed process loses little and the
/// last unit ends soon.
constexpr double unit_cost = 2e5;
constexpr std::uint32_t beacons_max = 1'000'000'000;
/// Raised when runs give other results, so that no old state is used for a new one.
constexpr std::uint64_t revision = 1;

/// The longest distance from fiducial to fiducial; on a closed path across its end, on an open path also to its ends.
double longest_gap(const std::vector<Simulation::Fiducial>& fiducials, const estimation::Track& track) {
  double longest_m = track.closed() ? fiducials.front().along_m + track.length_m() - fiducials.back().along_m
                                    : std::fmax(fiducials.front().along_m, track.length_m() - fiducials.back().along_m);
  for (std::size_t i = 1; i < fiducials.size(); ++i)
    longest_m = std::fmax(longest_m, fiducials[i].along_m - fiducials[i - 1].along_m);
  return longest_m;
}

Vote vote_of(const Trial& trial, const Trace& trace, double threshold_m, double limit_m2) {
  const RunMetrics metrics = metrics_of(trial, trace, threshold_m);
  std::vector<double> errors = trace.error_m;
  return {metrics.mse_m2, metrics.mean_m,    statistics::percentile(errors, 0.95),
          metrics.max_m,  metrics.precision, metrics.covered[2],
          metrics.nees,   limit_m2,          static_cast<double>(metrics.refused)};
}

}  // namespace

std::string to_string(const CampaignPlan& plan, const SweptValues& values) {
  std::string text;
  for (const Swept swept : plan.swept()) {
    char number[32];
    std::snprintf(number, sizeof number, "%.6g", value_of(values, swept));
    text.append(text.empty() ? "" : ", ").append(info_of(swept).key).append(" = ").append(number);
  }
  return text;
}

Result<CampaignWork> CampaignWork::make(CampaignPlan plan, CampaignGround ground) {
  CampaignWork work{std::move(plan), std::move(ground)};
  const CampaignPlan& p = work.plan_;
  const estimation::Registry registry;
  for (const std::string& name : p.algorithms) {
    const auto registered = registry.find(name);
    if (!registered) return tl::unexpected(registered.error());
    work.algorithms_.push_back(**registered);
  }
  // Only the pitch, the speed or the rotation can make an environment impossible: all else is checked with the plan.
  std::set<std::array<double, 3>> detected;
  for (std::size_t i = 0; i < p.environments(); ++i) {
    const SweptValues values = p.environment(i);
    if (!detected
             .insert(
                 {value_of(values, Swept::pitch), value_of(values, Swept::speed), value_of(values, Swept::rotation)})
             .second)
      continue;
    if (const auto fine = work.checked(values); !fine) return tl::unexpected(fine.error());
  }
  const double slowest = p.of(Swept::speed).front();
  const double cost = p.distance_m * p.rate_hz / slowest * static_cast<double>(p.algorithms.size());
  work.block_ = static_cast<std::uint32_t>(std::clamp(unit_cost / cost, 1.0, static_cast<double>(p.runs)));
  return work;
}

std::size_t CampaignWork::units() const { return plan_.environments() * ((plan_.runs + block_ - 1) / block_); }

CampaignWork::Unit CampaignWork::unit(std::size_t number) const {
  const std::size_t blocks = (plan_.runs + block_ - 1) / block_;
  const auto first = static_cast<std::uint32_t>(number % blocks) * block_;
  return {number / blocks, first, std::min(block_, plan_.runs - first)};
}

std::size_t CampaignWork::unit_of(std::size_t environment, std::size_t run) const {
  return environment * ((plan_.runs + block_ - 1) / block_) + run / block_;
}

double CampaignWork::cost(std::size_t number) const {
  const Unit here = unit(number);
  const double speed = value_of(plan_.environment(here.environment), Swept::speed);
  return here.runs * static_cast<double>(plan_.algorithms.size()) * plan_.distance_m * plan_.rate_hz / speed;
}

std::string CampaignWork::identity() const {
  Digest digest;
  digest.add(revision);
  digest.add(std::uint64_t{plan_.runs});
  digest.add(plan_.seed);
  digest.add(std::uint64_t{block_});
  for (const double v : {plan_.distance_m, plan_.rate_hz, plan_.threshold_m}) digest.add(v);
  if (plan_.fiducials == Fiducials::grid) digest.add(plan_.reach_m);
  digest.add(std::uint64_t{plan_.particles});
  digest.add(std::uint64_t{plan_.horizon});
  for (const std::string& name : plan_.algorithms) digest.add(name);
  for (const auto& values : plan_.values) {
    digest.add(std::uint64_t{values.size()});
    for (const double v : values) digest.add(v);
  }
  // The path of the vehicle is a part of the identity.
  const zone::Circuit& circuit = ground_.track->circuit();
  digest.add(ground_.zone->vehicle.width_m);
  for (double s = 0.0; s < ground_.track->length_m();) {
    const zone::TrackPosition position = ground_.track->position_at(s);
    const zone::Section& section = circuit.section(position.section);
    const Pose2 start = section.pose_at(0.0);
    for (const double v : {start.x_m, start.y_m, start.heading_rad, section.length_m(), section.curvature_at(0.0),
                           section.curvature_at(section.length_m())})
      digest.add(v);
    s += section.length_m() - position.s_m + 1e-9;
  }
  return digest.hex();
}

Result<void> CampaignWork::checked(const SweptValues& values) const {
  auto simulated = bare(values);
  if (auto fine = check(simulated); !fine) {
    fine.error().location = to_string(plan_, values);
    return fine;
  }
  if (plan_.fiducials == Fiducials::line || grid(values)) return {};
  return fail("campaign.grid", "covering the zone takes more than 1000000000 beacons; widen the pitch",
              to_string(plan_, values));
}

Simulation CampaignWork::bare(const SweptValues& values) const {
  Simulation simulation{ground_.track};
  simulation.distance_m = plan_.distance_m;
  simulation.odometry_hz = plan_.rate_hz;
  simulation.speed_mps = value_of(values, Swept::speed);
  simulation.pitch_m = value_of(values, Swept::pitch);
  simulation.read_ratio = 1.0 - value_of(values, Swept::missed);
  simulation.survey_sigma_m = value_of(values, Swept::survey_error);
  simulation.scale_sigma = value_of(values, Swept::scale_error);
  const double odometry_m = value_of(values, Swept::odometry_noise);
  simulation.sensors.distance_variance_per_m = odometry_m * odometry_m;
  simulation.sensors.fiducial_along_sigma_m = simulation.sensors.fiducial_across_sigma_m =
      value_of(values, Swept::reading_noise);
  return simulation;
}

std::optional<zone::BeaconGrid> CampaignWork::grid(const SweptValues& values) const {
  return zone::covering_grid(ground_.track->circuit(), ground_.zone->vehicle, value_of(values, Swept::pitch),
                             {value_of(values, Swept::origin_x), value_of(values, Swept::origin_y)}, beacons_max,
                             value_of(values, Swept::rotation) * pi / 180.0);
}

Simulation CampaignWork::simulation(const SweptValues& values) const {
  Simulation simulation = bare(values);
  if (plan_.fiducials == Fiducials::line) return simulation;
  simulation.fiducials_only = true;
  if (const auto beacons = grid(values)) simulation.fiducials = fiducials_of(*ground_.track, *beacons, plan_.reach_m);
  return simulation;
}

FiducialsFound CampaignWork::found(const Simulation& simulation) const {
  if (plan_.fiducials == Fiducials::line) return {simulation.pitch_m, simulation.pitch_m};
  if (simulation.fiducials.empty()) return {nan, nan};
  return {ground_.track->length_m() / static_cast<double>(simulation.fiducials.size()),
          longest_gap(simulation.fiducials, *ground_.track)};
}

Result<UnitRecord> CampaignWork::done(std::size_t number) const {
  const Unit here = unit(number);
  const Simulation simulated = simulation(plan_.environment(here.environment));
  UnitRecord record{number, found(simulated), {}};
  Trial trial;
  Trace trace;
  for (std::uint32_t run = here.first_run; run < here.first_run + here.runs; ++run) {
    simulate(simulated, plan_.seed + run, trial);
    const RunLimit limit = limit_of(trial);
    estimation::Setting setting = trial.setting;
    setting.particles = plan_.particles;
    setting.horizon = plan_.horizon;
    for (const estimation::Registered& one : algorithms_) {
      const auto algorithm = one.make(setting);
      if (auto fine = apply(*algorithm, trial, trace); !fine) return tl::unexpected(fine.error());
      record.votes.push_back(
          vote_of(trial, trace, plan_.threshold_m, one.backtracks ? limit.smoother_m2 : limit.filter_m2));
    }
  }
  return record;
}

}  // namespace cosiva::experiments
