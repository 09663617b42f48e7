#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/base/json_writer.h"

namespace cosiva::experiments {

/// Distribution of a set of values; all 0 without values.
struct Distribution {
  std::size_t count{};
  double mean{};
  double p50{};
  double p90{};
  double p99{};
  double max{};
};
/// Percentiles are values of the set: the smallest that at least that ratio does not exceed.
[[nodiscard]] Distribution distribution_of(std::vector<double> values);

/// Half of the clearance that vehicles leave ahead of them [m].
inline constexpr double near_miss_m = 0.06;

/// The metrics of a run, after its warm-up; safety metrics count from the start.
struct TrafficMetrics {
  std::string zone;
  std::size_t aivs{};
  double duration_s{};
  double warm_up_s{};
  std::uint64_t seed{};
  double step_s{};
  std::string rules;

  std::size_t jobs_due{};
  std::size_t jobs_done{};
  std::size_t jobs_came{};  ///< from other zones, with the vehicle that carries them
  std::size_t jobs_left{};  ///< for other zones
  std::size_t jobs_open{};  ///< due or arrived at the end, and neither done nor left
  double jobs_per_hour{};
  std::vector<double> job_s;   ///< from due to done, for finished jobs
  std::vector<double> wait_s;  ///< from due to the stop of the vehicle at the load, for fetched jobs

  std::vector<double> lap_s;  ///< of vehicles that circulate
  double laps_per_hour{};

  double vehicle_s{};  ///< of vehicles in the zone
  double distance_m{};
  double mean_speed_mps{};
  double energy_wh{};      ///< of all, by DriveEnergy
  double waiting_ratio{};  ///< of all vehicle time
  double busy_ratio{};     ///< with a job

  struct Crossing {
    std::string name;
    std::uint64_t grants;
    double waiting_s;  ///< of all vehicles that were granted the crossing
  };
  std::vector<Crossing> crossings;
  /// Vehicle-seconds on each cell of each section, in driving order.
  struct Cells {
    double length_m;  ///< of a cell
    std::vector<double> occupied_s;
    std::vector<double> stopped_s;
  };
  std::vector<Cells> cells;  ///< by section
  /// Over the run: stopped vehicles, and unassigned jobs.
  std::vector<double> time_s;
  std::vector<double> stopped;
  std::vector<double> open_jobs;

  double smallest_gap_m{};
  std::uint64_t near_misses{};  ///< number of times that a vehicle came nearer than near_miss_m to its leader
  std::uint64_t collisions{};
  std::size_t stuck{};
  std::string digest;  ///< of the fleet and of every job's history

  [[nodiscard]] bool good() const { return collisions == 0 && stuck == 0; }
};

void write_json(JsonWriter& json, const TrafficMetrics& metrics);
/// A short text for a terminal.
[[nodiscard]] std::string to_text(const TrafficMetrics& metrics);

}  // namespace cosiva::experiments
