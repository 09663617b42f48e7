#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/experiments/transport/traffic/jobs.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::experiments {

/// The history of a job; times in seconds since the start, nothing: not yet.
struct JobCourse {
  std::optional<double> given_s;    ///< to a vehicle
  std::optional<double> fetched_s;  ///< the vehicle stopped at `from`
  std::optional<double> done_s;     ///< unloaded at `to`, or out of the zone
  virtual_side::Fleet::Vehicle vehicle{virtual_side::Fleet::none};
};

/// Assigns jobs to vehicles without a job: the oldest of the highest priority first, to the vehicle with the shortest
/// travel time by the router, among the few nearest in a straight line. A vehicle without a job circulates, so that it
/// blocks no other vehicle; a vehicle that loads or unloads stops on its route, as in the zone.
///
/// Invariant: the given jobs are in the order in which they are due; a vehicle that has left is away until it comes.
class Dispatcher {
 public:
  using Fleet = virtual_side::Fleet;

  /// @param fleet       of one copy (checked); steps between the calls of step()
  /// @param jobs        in the order of their times
  /// @param handling_s  duration of loading, and of unloading
  /// @param exits       positions where vehicles that are to leave the zone stop; jobs name them by index
  Dispatcher(Fleet& fleet, std::vector<Job> jobs, double handling_s, std::vector<zone::TrackPosition> exits = {});

  /// To be called after each step of the fleet.
  void step();

  /// The vehicles stopped at their exit with a load, in the order of arrival.
  [[nodiscard]] const std::vector<Fleet::Vehicle>& leaving() const { return leaving_; }
  /// Removes the first of them from the zone, and returns its job.
  std::size_t let_leave();
  /// A vehicle added to the zone carries a load to the job's goal; the job counts here from now on.
  void come(Fleet::Vehicle vehicle, Job carried);

  /// The zone's own jobs, then those that came from other zones.
  [[nodiscard]] const std::vector<Job>& jobs() const { return jobs_; }
  [[nodiscard]] std::size_t own_jobs() const { return own_jobs_; }
  [[nodiscard]] const std::vector<JobCourse>& courses() const { return courses_; }  ///< one per job
  [[nodiscard]] std::size_t open() const { return waiting_.size(); }                ///< due, and not assigned
  /// Vehicle-seconds with a job, since the start.
  [[nodiscard]] double busy_s() const { return busy_s_; }

 private:
  enum class Phase : std::uint8_t { idle, fetching, loading, carrying, unloading, leaving, away };
  struct Carrier {
    Phase phase{Phase::idle};
    std::size_t job{};
    double until_s{};
    double patient_until_s{-1.0};  ///< the vehicle is stopped where it cannot be sent on; below 0: it is not
  };
  void record_due();
  void arrive(Fleet::Vehicle vehicle);
  void handle(Fleet::Vehicle vehicle);
  void give_out();
  [[nodiscard]] std::optional<Fleet::Vehicle> best_for(zone::TrackPosition goal);
  /// From committed() and the router; nothing where there is no route.
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
  std::vector<std::size_t> waiting_;  ///< jobs, in the order of assignment
  std::vector<Carrier> carriers_;
  std::vector<Fleet::Vehicle> handling_;
  std::vector<Fleet::Vehicle> to_send_;  ///< could not be sent at once
  std::vector<Fleet::Vehicle> leaving_;
  std::size_t idle_{0};
  std::size_t away_{0};
  double busy_s_{0.0};
  bool changed_{true};  ///< a vehicle became idle or a job due, since the last assignment
  std::vector<zone::SectionId> route_;
};

}  // namespace cosiva::experiments
