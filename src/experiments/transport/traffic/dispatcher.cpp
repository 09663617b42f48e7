#include "cosiva/experiments/transport/traffic/dispatcher.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

/// Number of the nearest vehicles whose route is computed, which is expensive.
constexpr std::size_t requested_max = 6;
/// A goal on the vehicle's own section is driven to directly when it is further ahead than the stopping distance plus
/// this.
constexpr double beyond_stop_m = 0.3;
/// Time that a vehicle at a stop waits for the crossings on its route.
constexpr double timeout_s = 20.0;

}  // namespace

Dispatcher::Dispatcher(Fleet& fleet, std::vector<Job> jobs, double handling_s, std::vector<zone::TrackPosition> exits)
    : fleet_{fleet},
      router_{fleet.zone()},
      jobs_{std::move(jobs)},
      courses_(jobs_.size()),
      own_jobs_{jobs_.size()},
      exits_{std::move(exits)},
      handling_s_{handling_s},
      carriers_(fleet.size()) {
  COSIVA_EXPECT(fleet.copies() == 1);
  COSIVA_EXPECT(std::ranges::is_sorted(jobs_, {}, &Job::due_s));
  for (Fleet::Vehicle v = 0; v < fleet.size(); ++v)
    if (fleet.is_away(v)) carriers_[v].phase = Phase::away;
  away_ = static_cast<std::size_t>(std::ranges::count(carriers_, Phase::away, &Carrier::phase));
  idle_ = fleet.size() - away_;
}

void Dispatcher::step() {
  const double before_s = std::exchange(now_s_, to_seconds(fleet_.time()));
  busy_s_ += (now_s_ - before_s) * static_cast<double>(fleet_.size() - idle_ - away_);
  record_due();
  for (const Fleet::Vehicle vehicle : fleet_.arrived()) arrive(vehicle);
  // Finished vehicles leave the list, so the list is processed backwards.
  for (std::size_t i = handling_.size(); i-- > 0;)
    if (carriers_[handling_[i]].until_s <= now_s_) {
      const Fleet::Vehicle vehicle = handling_[i];
      handling_.erase(handling_.begin() + static_cast<std::ptrdiff_t>(i));
      handle(vehicle);
    }
  for (const Fleet::Vehicle vehicle : std::exchange(to_send_, {})) drive_on(vehicle);
  if (std::exchange(changed_, false)) give_out();
}

void Dispatcher::record_due() {
  for (; next_due_ < own_jobs_ && jobs_[next_due_].due_s <= now_s_; ++next_due_) {
    const auto first_lower = std::ranges::find_if(
        waiting_, [&](std::size_t job) { return jobs_[job].priority < jobs_[next_due_].priority; });
    waiting_.insert(first_lower, next_due_);
    changed_ = true;
  }
}

void Dispatcher::arrive(Fleet::Vehicle vehicle) {
  Carrier& carrier = carriers_[vehicle];
  if (carrier.phase != Phase::fetching && carrier.phase != Phase::carrying) return;
  if (carrier.phase == Phase::fetching) courses_[carrier.job].fetched_s = now_s_;
  if (carrier.phase == Phase::carrying && jobs_[carrier.job].exit != no_exit) {
    carrier.phase = Phase::leaving;
    leaving_.push_back(vehicle);
    return;
  }
  carrier.phase = carrier.phase == Phase::fetching ? Phase::loading : Phase::unloading;
  carrier.until_s = now_s_ + handling_s_;
  handling_.push_back(vehicle);
}

void Dispatcher::handle(Fleet::Vehicle vehicle) {
  Carrier& carrier = carriers_[vehicle];
  if (carrier.phase == Phase::loading) {
    carrier.phase = Phase::carrying;
    drive_on(vehicle);
    return;
  }
  courses_[carrier.job].done_s = now_s_;
  carrier = {};
  fleet_.circulate(vehicle);
  ++idle_;
  changed_ = true;
}

void Dispatcher::give_out() {
  for (std::size_t i = 0; i < waiting_.size() && idle_ > 0;) {
    const std::size_t job = waiting_[i];
    const auto vehicle = best_for(fleet_.zone().stations[jobs_[job].from].position);
    if (!vehicle) {
      ++i;  // no vehicle can reach it; another job may be nearer
      continue;
    }
    waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    carriers_[*vehicle] = {Phase::fetching, job};
    courses_[job].given_s = now_s_;
    courses_[job].vehicle = *vehicle;
    --idle_;
    drive_on(*vehicle);
  }
}

std::optional<Dispatcher::Fleet::Vehicle> Dispatcher::best_for(zone::TrackPosition goal) {
  const Point2 there = position(fleet_.zone().circuit.pose_at(goal));
  std::vector<std::pair<double, Fleet::Vehicle>> near;
  for (Fleet::Vehicle v = 0; v < carriers_.size(); ++v)
    if (carriers_[v].phase == Phase::idle)
      near.emplace_back(distance(there, Point2{fleet_.x_m()[v], fleet_.y_m()[v]}), v);
  const std::size_t requested = std::min(requested_max, near.size());
  std::ranges::partial_sort(near, near.begin() + static_cast<std::ptrdiff_t>(requested));
  std::optional<std::pair<double, Fleet::Vehicle>> best;
  for (std::size_t i = 0; i < requested; ++i) {
    const auto time_s = route_to(near[i].second, goal);
    if (time_s && (!best || *time_s < best->first)) best = {*time_s, near[i].second};
  }
  return best ? std::optional{best->second} : std::nullopt;
}

std::optional<double> Dispatcher::route_to(Fleet::Vehicle vehicle, zone::TrackPosition goal) {
  const auto committed = fleet_.committed(vehicle);
  const zone::Circuit& circuit = fleet_.zone().circuit;
  const zone::TrackPosition here = fleet_.track_position(vehicle);
  const double speed = fleet_.speed_mps()[vehicle];
  const double stop_m = speed * speed / (2.0 * fleet_.zone().profiles.slow.braking_mps2) + beyond_stop_m;
  // A single committed section counts from where the vehicle can still stop; several from the end of the last.
  const zone::SectionId last = committed.back();
  const double length_m = circuit.section(last).length_m();
  const zone::TrackPosition from{last, committed.size() == 1 ? std::min(here.s_m + stop_m, length_m) : length_m};
  const auto route = router_.plan(from, goal, fleet_.zone().closed);
  if (!route) return std::nullopt;
  route_.assign(committed.begin(), committed.end());
  route_.insert(route_.end(), route->sections.begin() + 1, route->sections.end());
  return route->time_s;
}

zone::TrackPosition Dispatcher::goal_of(const Carrier& carrier) const {
  const Job& job = jobs_[carrier.job];
  if (carrier.phase == Phase::carrying && job.exit != no_exit) return exits_[job.exit];
  return fleet_.zone().stations[carrier.phase == Phase::fetching ? job.from : job.to].position;
}

void Dispatcher::drive_on(Fleet::Vehicle vehicle) {
  const zone::TrackPosition goal = goal_of(carriers_[vehicle]);
  if (route_to(vehicle, goal) && fleet_.send(vehicle, route_, goal.s_m)) {
    carriers_[vehicle].patient_until_s = -1.0;
    return;
  }
  // The vehicle is about to be committed to another section, and is sent from there; or it is stopped in crossings, and
  // others that it needs are occupied. The vehicle does not wait there for ever, but then circulates.
  to_send_.push_back(vehicle);
  Carrier& carrier = carriers_[vehicle];
  if (!fleet_.is_at_goal(vehicle)) return;
  if (carrier.patient_until_s < 0.0) carrier.patient_until_s = now_s_ + timeout_s;
  if (now_s_ < carrier.patient_until_s) return;
  carrier.patient_until_s = -1.0;
  fleet_.circulate(vehicle);
}

std::size_t Dispatcher::let_leave() {
  COSIVA_EXPECT(!leaving_.empty());
  const Fleet::Vehicle vehicle = leaving_.front();
  leaving_.erase(leaving_.begin());
  const bool taken = fleet_.take_away(vehicle);
  COSIVA_EXPECT(taken);
  const std::size_t job = carriers_[vehicle].job;
  courses_[job].done_s = now_s_;
  carriers_[vehicle] = {Phase::away, 0, 0.0};
  ++away_;
  return job;
}

void Dispatcher::come(Fleet::Vehicle vehicle, Job carried) {
  COSIVA_EXPECT(carriers_[vehicle].phase == Phase::away);
  carried.exit = no_exit;
  carriers_[vehicle] = {Phase::carrying, jobs_.size(), 0.0};
  --away_;
  jobs_.push_back(carried);
  courses_.push_back({now_s_, now_s_, std::nullopt, vehicle});
  drive_on(vehicle);
}

}  // namespace cosiva::experiments
