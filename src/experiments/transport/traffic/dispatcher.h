#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/experiments/transport/traffic/jobs.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::experiments {

/// What became of a job; times in seconds since the start, nothing: not yet.
struct JobCourse {
  std::optional<double> given_s;    ///< to a vehicle
  std::optional<double> fetched_s;  ///< the vehicle stood at `from`
  std::optional<double> done_s;     ///< unloaded at `to`, or out of the zone
  virtual_side::Fleet::Vehicle vehicle{virtual_side::Fleet::none};
};

/// Gives jobs to vehicles that have none. The oldest of the highest priority first, to the vehicle that would be there
/// first by the router's travel times, among the few nearest in a straight line. A vehicle without a job circulates, so
/// that it blocks nobody; one that loads or unloads stands on its way, as it does in the zone.
class Dispatcher {
 public:
  using Fleet = virtual_side::Fleet;

  /// @param fleet       of one copy (checked); steps between the calls of step()
  /// @param jobs        in the order of their times
  /// @param handling_s  loading, and unloading, takes so long
  /// @param exits       where vehicles stand that are to leave the zone; jobs name them by index
  Dispatcher(Fleet& fleet, std::vector<Job> jobs, double handling_s, std::vector<zone::TrackPosition> exits = {});

  /// After each step of the fleet.
  void step();

  /// Those that stand at their exit with a load, in the order in which they came.
  [[nodiscard]] const std::vector<Fleet::Vehicle>& leaving() const { return leaving_; }
  /// Takes the first of them out of the zone, and says with which job.
  std::size_t let_leave();
  /// One that was put into the zone brings a load to where the job says, which counts here from now on.
  void come(Fleet::Vehicle vehicle, Job carried);

  /// The zone's own, then those that came in from others.
  [[nodiscard]] const std::vector<Job>& jobs() const { return jobs_; }
  [[nodiscard]] std::size_t own_jobs() const { return own_jobs_; }
  [[nodiscard]] const std::vector<JobCourse>& courses() const { return courses_; }  ///< one per job
  [[nodiscard]] std::size_t open() const { return waiting_.size(); }                ///< due, and nobody's yet
  /// Vehicle-seconds with a job, since the start.
  [[nodiscard]] double busy_s() const { return busy_s_; }

 private:
  enum class Phase : std::uint8_t { idle, fetching, loading, carrying, unloading, leaving, away };
  struct Carrier {
    Phase phase{Phase::idle};
    std::size_t job{};
    double until_s{};
    double patient_until_s{-1.0};  ///< it stands where it cannot be sent on from; below 0: it does not
  };
  void record_due();
  void arrive(Fleet::Vehicle vehicle);
  void handle(Fleet::Vehicle vehicle);
  void give_out();
  [[nodiscard]] std::optional<Fleet::Vehicle> best_for(zone::TrackPosition goal);
  /// By committed() and the router; nothing where there is no way.
  [[nodiscard]] std::optional<double> route_to(Fleet::Vehicle vehicle, zone::TrackPosition goal);
  void drive_on(Fleet::Vehicle vehicle);
  [[nodiscard]] zone::TrackPosition goal_of(const Carrier& carrier) const;

  Fleet& fleet_;
  zone::Router router_;
  std::vector<Job> jobs_;
  std::vector<JobCourse> courses_;
  std::size_t own_jobs_;
  std::vector<zone::TrackPosition> exits_;
  double handling_s_;
  double now_s_{0.0};
  std::size_t next_due_{0};
  std::vector<std::size_t> waiting_;  ///< jobs, the first to be served first
  std::vector<Carrier> carriers_;
  std::vector<Fleet::Vehicle> handling_;
  std::vector<Fleet::Vehicle> to_send_;  ///< could not be sent at once
  std::vector<Fleet::Vehicle> leaving_;
  std::size_t idle_{0};
  std::size_t away_{0};
  double busy_s_{0.0};
  bool changed_{true};  ///< somebody became idle or a job due, since jobs were given out last
  std::vector<zone::SectionId> route_;
};

}  // namespace cosiva::experiments
