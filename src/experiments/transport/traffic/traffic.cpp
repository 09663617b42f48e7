#include "cosiva/experiments/transport/traffic/traffic.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

using virtual_side::Fleet;

constexpr double sample_every_s = 1.0;
constexpr double cell_m = 0.25;
constexpr double stopped_mps = 0.01;
/// Approximate number of points of a run's curves, each a mean.
constexpr double curve_points = 240.0;

std::vector<TrafficMetrics::Cells> cells_of(const zone::TrafficZone& zone) {
  std::vector<TrafficMetrics::Cells> cells;
  cells.reserve(zone.circuit.size());
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    const double length_m = zone.circuit.section(id).length_m();
    const auto count = static_cast<std::size_t>(std::max(1.0, std::ceil(length_m / cell_m)));
    cells.push_back({length_m / static_cast<double>(count), std::vector<double>(count), std::vector<double>(count)});
  }
  return cells;
}

}  // namespace

std::uint64_t steps_in(double seconds, SimDuration step) {
  return static_cast<std::uint64_t>(std::llround(seconds / to_seconds(step)));
}

Result<TrafficRun> TrafficRun::make(TrafficOptions options) {
  if (!(options.duration_s > 0.0 && options.duration_s <= 1e8) ||
      !(options.warm_up_s >= 0.0 && options.warm_up_s <= 1e8))
    return fail("traffic.options", "a run and its warm-up last up to 10⁸ s, the run longer than 0 s");
  if (!(options.handling_s >= 0.0)) return fail("traffic.options", "the loading time must be 0 s or more");
  const virtual_side::FleetOptions terms{options.step, options.rules, std::chrono::seconds{10}};
  // A zone that no fleet can drive in would only be reported as having no room, which would be misleading.
  if (auto no_vehicle = Fleet::make(options.zone, terms, {}); !no_vehicle) return tl::unexpected(no_vehicle.error());
  auto starts = Fleet::spread(*options.zone, options.aivs);
  if (starts.size() < options.aivs || starts.size() + options.spare == 0) {
    return fail("traffic.room", "zone '" + options.zone->name + "' has room for " + std::to_string(starts.size()) +
                                    " AIVs to start, not for " + std::to_string(options.aivs));
  }
  starts.resize(starts.size() + options.spare, {0, {zone::no_section, 0.0}, 0});
  auto fleet = Fleet::make(options.zone, terms, starts);
  if (!fleet) return tl::unexpected(fleet.error());
  return TrafficRun{std::move(options), std::make_unique<Fleet>(std::move(*fleet))};
}

TrafficRun::TrafficRun(TrafficOptions options, std::unique_ptr<Fleet> fleet)
    : options_{std::move(options)},
      fleet_{std::move(fleet)},
      dispatcher_{std::make_unique<Dispatcher>(*fleet_, options_.jobs, options_.handling_s, options_.exits)},
      steps_per_sample_{std::max<std::uint64_t>(1, steps_in(sample_every_s, options_.step))},
      warm_up_steps_{steps_in(options_.warm_up_s, options_.step)},
      end_steps_{warm_up_steps_ + std::max<std::uint64_t>(1, steps_in(options_.duration_s, options_.step))},
      numbers_(fleet_->size()),
      speed_mps_(fleet_->size()),
      laps_(fleet_->size()),
      lap_began_s_(fleet_->size(), -1.0) {
  sampled_.cells = cells_of(*options_.zone);
  for (Fleet::Vehicle v = 0; v < fleet_->size(); ++v) numbers_[v] = options_.first_aiv + v;
  for (auto v = static_cast<Fleet::Vehicle>(fleet_->size()); v-- > options_.aivs;) away_.push_back(v);
  if (warm_up_steps_ == 0) end_warm_up();
}

double TrafficRun::time_s() const { return to_seconds(fleet_->time()); }

bool TrafficRun::advance(double seconds) {
  AloneWorker alone;
  return advance(seconds, alone);
}

bool TrafficRun::advance(double seconds, Workers& workers) {
  const std::uint64_t until =
      std::min(end_steps_, steps_ + std::max<std::uint64_t>(1, steps_in(seconds, options_.step)));
  while (steps_ < until) step(workers);
  return steps_ < end_steps_;
}

void TrafficRun::step(Workers& workers) {
  COSIVA_EXPECT(away_.size() <= fleet_->size());
  fleet_->step(workers);
  ++steps_;
  present_s_ += to_seconds(options_.step) * static_cast<double>(fleet_->size() - away_.size());
  const auto speeds = fleet_->speed_mps();
  for (std::size_t v = 0; v < speeds.size(); ++v) {
    gained_m2ps2_ += std::max(0.0, speeds[v] * speeds[v] - speed_mps_[v] * speed_mps_[v]);
    speed_mps_[v] = speeds[v];
  }
  if (!options_.jobs.empty() || !options_.exits.empty() || options_.spare > 0) dispatcher_->step();
  // The check is skipped while no vehicle has ever come this near.
  if (fleet_->smallest_gap_m() < near_miss_m) record_near_misses();
  if (steps_ == warm_up_steps_) end_warm_up();
  if (steps_ % steps_per_sample_ == 0 && steps_ > warm_up_steps_) take_sample();
}

std::vector<Traveller> TrafficRun::take_leaving() {
  std::vector<Traveller> left;
  while (!dispatcher_->leaving().empty()) {
    const Fleet::Vehicle vehicle = dispatcher_->leaving().front();
    const Job& job = dispatcher_->jobs()[dispatcher_->let_leave()];
    left.push_back({numbers_[vehicle], job, steps_});
    away_.push_back(vehicle);
  }
  return left;
}

bool TrafficRun::bring(const Traveller& traveller, zone::TrackPosition position) {
  if (away_.empty() || !fleet_->bring(away_.back(), position, 0)) return false;
  const Fleet::Vehicle vehicle = away_.back();
  away_.pop_back();
  numbers_[vehicle] = traveller.aiv;
  laps_[vehicle] = fleet_->laps(vehicle);
  lap_began_s_[vehicle] = -1.0;
  dispatcher_->come(vehicle, traveller.job);
  return true;
}

void TrafficRun::end_warm_up() {
  before_ = totals();
  for (Fleet::Vehicle v = 0; v < fleet_->size(); ++v) laps_[v] = fleet_->laps(v);
}

void TrafficRun::record_near_misses() {
  is_near_.resize(fleet_->size());
  for (Fleet::Vehicle v = 0; v < fleet_->size(); ++v) {
    const bool is_near = !fleet_->is_away(v) && fleet_->ahead(v).gap_m < near_miss_m;
    if (is_near && is_near_[v] == 0) ++near_misses_;
    is_near_[v] = is_near ? 1 : 0;
  }
}

void TrafficRun::take_sample() {
  const double sample_s = to_seconds(options_.step) * static_cast<double>(steps_per_sample_);
  const double now_s = time_s();
  double stopped = 0.0;
  for (Fleet::Vehicle v = 0; v < fleet_->size(); ++v) {
    if (fleet_->is_away(v)) continue;
    const zone::TrackPosition position = fleet_->track_position(v);
    TrafficMetrics::Cells& cells = sampled_.cells[position.section];
    const std::size_t cell =
        std::min(static_cast<std::size_t>(position.s_m / cells.length_m), cells.occupied_s.size() - 1);
    cells.occupied_s[cell] += sample_s;
    const bool is_stopped = fleet_->speed_mps()[v] < stopped_mps && !fleet_->is_at_goal(v);
    if (is_stopped) cells.stopped_s[cell] += sample_s;
    stopped += is_stopped ? 1.0 : 0.0;
    if (const std::uint32_t laps = fleet_->laps(v); laps != laps_[v]) {
      // Laps count from the second one: the first began before the measurement, or was incomplete.
      if (lap_began_s_[v] >= 0.0 && !fleet_->has_goal(v)) sampled_.lap_s.push_back(now_s - lap_began_s_[v]);
      lap_began_s_[v] = now_s;
      laps_[v] = laps;
    }
  }
  curve_.count += 1.0;
  curve_.stopped += stopped;
  curve_.open_jobs += static_cast<double>(dispatcher_->open());
  const double last_s = sampled_.time_s.empty() ? options_.warm_up_s : sampled_.time_s.back();
  if (now_s - last_s < options_.duration_s / curve_points - 1e-9) return;
  sampled_.time_s.push_back(now_s);
  sampled_.stopped.push_back(curve_.stopped / curve_.count);
  sampled_.open_jobs.push_back(curve_.open_jobs / curve_.count);
  curve_ = {};
}

TrafficRun::Totals TrafficRun::totals() const {
  Totals totals;
  for (Fleet::Vehicle v = 0; v < fleet_->size(); ++v) {
    totals.distance_m += fleet_->distance_m(v);
    totals.waiting_s += to_seconds(fleet_->waiting(v));
  }
  totals.busy_s = dispatcher_->busy_s();
  totals.present_s = present_s_;
  totals.gained_m2ps2 = gained_m2ps2_;
  for (std::size_t x = 0; x < options_.zone->crossings.size(); ++x) totals.crossings.push_back(fleet_->crossing(x));
  return totals;
}

TrafficMetrics TrafficRun::metrics() const {
  TrafficMetrics f = sampled_;
  f.zone = options_.zone->name;
  f.aivs = fleet_->size() - away_.size();
  f.warm_up_s = options_.warm_up_s;
  f.duration_s = std::max(0.0, time_s() - options_.warm_up_s);
  f.seed = options_.seed;
  f.step_s = to_seconds(options_.step);
  f.rules = options_.rules_name;
  const double hours = std::max(f.duration_s, f.step_s) / 3600.0;

  const auto& jobs = dispatcher_->jobs();
  const auto& courses = dispatcher_->courses();
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (jobs[i].due_s > time_s()) continue;
    if (courses[i].done_s && *courses[i].done_s <= options_.warm_up_s) continue;
    const bool is_own = i < dispatcher_->own_jobs();
    ++(is_own ? f.jobs_due : f.jobs_came);
    if (is_own && courses[i].fetched_s) f.wait_s.push_back(*courses[i].fetched_s - jobs[i].due_s);
    if (!courses[i].done_s) continue;
    ++(jobs[i].exit == no_exit ? f.jobs_done : f.jobs_left);
    if (jobs[i].exit == no_exit) f.job_s.push_back(*courses[i].done_s - jobs[i].due_s);
  }
  f.jobs_open = f.jobs_due + f.jobs_came - f.jobs_done - f.jobs_left;
  f.jobs_per_hour = static_cast<double>(f.jobs_done) / hours;
  f.laps_per_hour = static_cast<double>(f.lap_s.size()) / hours;

  const Totals now = totals();
  const double vehicle_s = std::max(now.present_s - before_.present_s, f.step_s);
  f.vehicle_s = vehicle_s;
  f.distance_m = now.distance_m - before_.distance_m;
  f.mean_speed_mps = f.distance_m / vehicle_s;
  const DriveEnergy& e = options_.energy;
  constexpr double gravity_mps2 = 9.81;
  const double work_j =
      e.rolling * e.mass_kg * gravity_mps2 * f.distance_m + 0.5 * e.mass_kg * (now.gained_m2ps2 - before_.gained_m2ps2);
  f.energy_wh = (e.base_load_w * vehicle_s + work_j / e.efficiency) / 3600.0;
  f.waiting_ratio = (now.waiting_s - before_.waiting_s) / vehicle_s;
  f.busy_ratio = (now.busy_s - before_.busy_s) / vehicle_s;
  for (std::size_t x = 0; x < now.crossings.size(); ++x) {
    const bool has_before = x < before_.crossings.size();
    f.crossings.push_back(
        {options_.zone->crossings[x].name, now.crossings[x].grants - (has_before ? before_.crossings[x].grants : 0),
         to_seconds(now.crossings[x].waiting) - (has_before ? to_seconds(before_.crossings[x].waiting) : 0.0)});
  }
  f.smallest_gap_m = fleet_->smallest_gap_m();
  f.near_misses = near_misses_;
  f.collisions = fleet_->collisions();
  f.stuck = fleet_->stuck();
  Digest digest;
  digest.add(fleet_->digest());
  for (const JobCourse& course : courses) {
    digest.add(std::uint64_t{course.vehicle});
    for (const auto& at : {course.given_s, course.fetched_s, course.done_s}) digest.add(at.value_or(-1.0));
  }
  for (const std::uint32_t number : numbers_) digest.add(std::uint64_t{number});
  f.digest = digest.hex();
  return f;
}

}  // namespace cosiva::experiments
